// What the importing child process hands back, should it have been taken over by its input.
// Rooms: common/interchange
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "common/interchange/part_buffer.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span{data, size});
  const auto read = meshloop::parts_from_bytes(bytes);
  if (!read) return 0;
  for (const auto& part : read->parts) (void)meshloop::validate(part.submesh);
  std::vector<std::byte> again;
  const bool written = meshloop::write_parts(*read, [&again](std::span<const std::byte> more) {
    again.insert(again.end(), more.begin(), more.end());
    return true;
  });
  if (!written || !std::equal(again.begin(), again.end(), bytes.begin(), bytes.end())) std::abort();
  return 0;
}
