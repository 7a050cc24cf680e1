// X3D and VRML 97 files: the first byte chooses. What is read becomes parts, as in an import.
// Rooms: common/interchange
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "common/interchange/scene_geometry.h"
#include "common/interchange/vrml_reader.h"
#include "common/interchange/x3d_reader.h"

namespace {

void check(const meshloop::WebNodes& nodes) {
  // Spheres make many triangles of a few bytes; that is not what is looked for.
  constexpr std::size_t kEnough = 10'000;
  const auto parts = meshloop::parts_of(nodes, "part", kEnough);
  if (!parts) return;
  for (const auto& part : *parts) {
    const auto& mesh = part.submesh;
    for (const auto& triangle : mesh.triangles) {
      for (const auto index : triangle) {
        if (index >= mesh.positions.size()) std::abort();
      }
    }
    if (mesh.has_colors() && mesh.colors.size() != mesh.positions.size()) std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string text{reinterpret_cast<const char*>(data) + 1, size - 1};
  if (data[0] % 2 == 0) {
    if (const auto nodes = meshloop::parse_vrml("#VRML V2.0 utf8\n" + text)) check(*nodes);
  } else if (const auto scene = meshloop::parse_x3d("<X3D><Scene>" + text + "</Scene></X3D>")) {
    check(scene->nodes);
  }
  return 0;
}
