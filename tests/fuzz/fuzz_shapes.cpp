// Files of shapes; what is read must have rays that end.
// Rooms: common/implicit
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "common/implicit/cast_ray.h"
#include "common/implicit/shape_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto shapes = meshloop::parse_shapes({reinterpret_cast<const char*>(data), size});
  if (!shapes) return 0;
  for (const auto& named : *shapes) {
    const auto bounds = meshloop::bounds_of(named.shape);
    if (!bounds.min().allFinite() || !bounds.max().allFinite()) std::abort();
    const Eigen::Vector3d from = bounds.center() - Eigen::Vector3d{0, 0, 3};
    if (bounds.sizes().maxCoeff() > 10) continue;
    const auto hit = meshloop::cast_ray(named.shape, {from, {0.1, 0.05, 1}}, 0.05, 50);
    if (hit && !(hit->t > 0.05 && hit->t < 50)) std::abort();
  }
  return 0;
}
