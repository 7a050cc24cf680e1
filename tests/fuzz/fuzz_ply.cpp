// PLY files, text and binary.
// Rooms: common/interchange
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "common/interchange/ply_reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view content{reinterpret_cast<const char*>(data), size};
  const auto mesh = meshloop::parse_ply(content, [](double) {});
  if (!mesh) return 0;
  for (const auto& triangle : mesh->triangles) {
    for (const auto index : triangle) {
      if (index >= mesh->positions.size()) std::abort();
    }
  }
  if (mesh->has_colors() && mesh->colors.size() != mesh->positions.size()) std::abort();
  return 0;
}
