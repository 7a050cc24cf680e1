// What the importing child process hands back, should it have been taken over by its input.
// Rooms: common/interchange
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "common/interchange/part_buffer.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto bytes = std::as_bytes(std::span{data, size});
  const auto parts = meshloop::parts_from_bytes(bytes);
  if (!parts) return 0;
  for (const auto& part : *parts) (void)meshloop::validate(part.submesh);
  const auto again = meshloop::to_bytes(*parts);
  if (!std::equal(again.begin(), again.end(), bytes.begin(), bytes.end())) std::abort();
  return 0;
}
