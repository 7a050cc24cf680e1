#include "server/adjust/expected_planes.h"

#include <cmath>

namespace meshloop::adjust {
namespace {

/// A bend of the model between neighbouring pixels that is less than this is none.
constexpr double kBend_sigmas = 0.2;

}  // namespace

ExpectedPlanes::ExpectedPlanes(const Comparison& comparison, const Camera& camera, const SensorModel& sensor)
    : comparison_{comparison},
      camera_{camera},
      sensor_{sensor},
      planes_(comparison.expected.size()),
      states_(planes_.size(), State::unknown) {}

const ExpectedPlanes::Plane* ExpectedPlanes::at(const Eigen::Vector3d& p) {
  if (!(p.z() > 0.01)) return nullptr;
  const Eigen::Vector2d pixel = camera_.project(p);
  if (!camera_.contains(pixel, 1)) return nullptr;
  const int x = static_cast<int>(pixel.x() + 0.5);
  const int y = static_cast<int>(pixel.y() + 0.5);
  const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(camera_.width) + static_cast<std::size_t>(x);
  if (states_[i] == State::unknown) states_[i] = make(x, y, planes_[i]) ? State::plane : State::none;
  return states_[i] == State::plane ? &planes_[i] : nullptr;
}

bool ExpectedPlanes::make(int x, int y, Plane& plane) const {
  if (!is_straight(x, y, 1, 0) || !is_straight(x, y, 0, 1)) return false;
  const Eigen::Vector3d across = point(x + 1, y) - point(x - 1, y);
  const Eigen::Vector3d down = point(x, y + 1) - point(x, y - 1);
  plane = Plane{across.cross(down).normalized(), point(x, y)};
  return true;
}

Eigen::Vector3d ExpectedPlanes::point(int x, int y) const {
  return camera_.back_project(x, y, static_cast<double>(comparison_.expected(x, y)));
}

// No bend that the sensor could tell: on a plane one divided by the depth is linear in the picture.
bool ExpectedPlanes::is_straight(int x, int y, int dx, int dy) const {
  const auto node = comparison_.node_index(x, y);
  if (node == 0 || comparison_.node_index(x - dx, y - dy) != node || comparison_.node_index(x + dx, y + dy) != node) {
    return false;
  }
  const double z = comparison_.expected(x, y);
  const double straight_z = 2 / (1 / static_cast<double>(comparison_.expected(x - dx, y - dy)) +
                                 1 / static_cast<double>(comparison_.expected(x + dx, y + dy)));
  return std::abs(z - straight_z) < kBend_sigmas * sensor_.sigma_z_m(z, 0);
}

}  // namespace meshloop::adjust
