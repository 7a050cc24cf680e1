#include "server/adjust/edge_rings.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>

namespace meshloop {
namespace {

/// An outline is where the depth steps by so many sigma and so many metres, and by this many times more than beside it.
constexpr double kStep_sigmas = 8;
constexpr double kStep_m = 0.03;
constexpr double kStepsBeside = 3;
/// How far the measured outline is looked for.
constexpr int kFarthest_px = 24;
/// Outlines that are not measured right at the edge, as a Kinect's often are.
constexpr int kUnmeasured_px = 2;
/// The direction of an outline is that of its surroundings.
constexpr int kAround_px = 3;
/// Outlines nearer to each other than this, in pixels, hang together.
constexpr int kTogether_px = 4;

/// A shift of less than this is none: three times a Kinect's noise across the axis.
constexpr double kAtPlace_px = 2.5;
/// The motion explains what it leaves within this, in the end.
constexpr std::array<double, 6> kScales_px{12, 8, 5, 3, 2, 2};
constexpr int kRounds = 4;
/// What the motion may be where the outlines do not say, one sigma, metres and radians; and the noise of one outline.
constexpr double kMotion = 0.1;
constexpr double kNoise_px = 1;

/// What the motion shifts by less says nothing of it.
constexpr double kShifted_px = 3;
constexpr int kFewestShifted = 150;
constexpr double kLeastShifted = 0.25;
constexpr double kLeastExplained = 0.75;
constexpr double kMostContradicted = 0.15;
constexpr int kFewestThings = 3;
constexpr double kLargestThing = 0.7;
constexpr int kFewestOfAThing = 15;

double depth_at(const DepthImage& image, int x, int y) {
  const auto z = static_cast<double>(image(x, y));
  return z > 0 && z < 1000 ? z : 0;
}

bool is_inside(const DepthImage& image, int x, int y) {
  return x >= 0 && y >= 0 && x < image.width() && y < image.height();
}

class Outlines {
 public:
  Outlines(const DepthImage& expected, const DepthImage& measured, const SensorModel& sensor)
      : expected_{expected}, measured_{measured}, sensor_{sensor} {}

  [[nodiscard]] std::vector<OutlineShift> find() const {
    std::vector<OutlineShift> found;
    for (int y = kAround_px + 1; y + kAround_px + 1 < expected_.height(); ++y) {
      for (int x = kAround_px + 1; x + kAround_px + 1 < expected_.width(); ++x) {
        for (const auto& [dx, dy] : {std::pair{1, 0}, std::pair{-1, 0}, std::pair{0, 1}, std::pair{0, -1}}) {
          if (auto shift = at(x, y, dx, dy)) found.push_back(*shift);
        }
      }
    }
    return found;
  }

 private:
  /// Between the pixel and the one beside it the surface ends, and another one is farther away.
  [[nodiscard]] bool is_outline(int x, int y, int dx, int dy) const {
    const double near_m = depth_at(expected_, x, y);
    const double far_m = depth_at(expected_, x + dx, y + dy);
    if (near_m == 0 || far_m == 0) return false;
    const double step = far_m - near_m;
    if (step < std::max(kStep_m, kStep_sigmas * sensor_.sigma_z_m(far_m, 0))) return false;
    const double before = depth_at(expected_, x - dx, y - dy);
    const double behind = depth_at(expected_, x + 2 * dx, y + 2 * dy);
    if (before == 0 || behind == 0) return false;
    return step > kStepsBeside * std::max(std::abs(near_m - before), std::abs(behind - far_m));
  }

  /// Towards the farther surface: one divided by the depth becomes less.
  [[nodiscard]] Eigen::Vector2d across(int x, int y) const {
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
    for (int j = -kAround_px; j <= kAround_px; ++j) {
      for (int i = -kAround_px; i <= kAround_px; ++i) {
        const double z = depth_at(expected_, x + i, y + j);
        if (z > 0) gradient -= Eigen::Vector2d{i, j} / z;
      }
    }
    return gradient.normalized();
  }

  [[nodiscard]] std::optional<OutlineShift> at(int x, int y, int dx, int dy) const {
    if (!is_outline(x, y, dx, dy)) return std::nullopt;
    const Eigen::Vector2d normal = across(x, y);
    // Each outline once: along the axis that lies nearest across it.
    const double along_axis = normal.dot(Eigen::Vector2d{dx, dy});
    if (!(along_axis > 0.7)) return std::nullopt;
    OutlineShift shift{x, y, depth_at(expected_, x, y), normal, 0, 0};
    const auto steps = steps_to_measured(x, y, dx, dy);
    if (!steps) return std::nullopt;
    shift.shift_px = *steps * along_axis;
    return shift;
  }

  /// From the expected outline to the measured one; not a number where there is none within reach, nothing where it
  /// cannot be told.
  [[nodiscard]] std::optional<double> steps_to_measured(int x, int y, int dx, int dy) const {
    const double near_m = depth_at(expected_, x, y);
    const double half = (depth_at(expected_, x + dx, y + dy) - near_m) / 2;
    enum class Shows { nothing, nearer, near, far };
    const auto shows = [&](int k) {
      const int u = x + k * dx;
      const int v = y + k * dy;
      if (!is_inside(measured_, u, v)) return Shows::nothing;
      const double z = depth_at(measured_, u, v);
      if (z == 0) return Shows::nothing;
      if (z < near_m - std::max(half, kStep_m)) return Shows::nearer;
      return z < near_m + half ? Shows::near : Shows::far;
    };
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    // Inwards, over what is seen through or not measured.
    int inwards = 0;
    int unmeasured = 0;
    while (inwards < kFarthest_px && (shows(-inwards) == Shows::far || shows(-inwards) == Shows::nothing)) {
      unmeasured += shows(-inwards) == Shows::nothing ? 1 : 0;
      ++inwards;
    }
    if (inwards == kFarthest_px) return unmeasured == inwards ? std::nullopt : std::optional{kNone};
    if (shows(-inwards) == Shows::nearer) return kNone;
    if (inwards > 0 && unmeasured == inwards) {
      if (inwards > kUnmeasured_px) return std::nullopt;
      inwards = 0;
    }
    if (inwards > 0) return -inwards;
    int outwards = 0;
    while (outwards < kFarthest_px && shows(outwards + 1) == Shows::near) ++outwards;
    if (outwards == kFarthest_px || shows(outwards + 1) == Shows::nearer) return kNone;
    return outwards;
  }

  const DepthImage& expected_;
  const DepthImage& measured_;
  const SensorModel& sensor_;
};

/// Numbers what hangs together in the picture; of each chain, each node is a thing of its own.
void number_things(std::vector<OutlineShift>& shifts, const Comparison& comparison) {
  const int columns = comparison.expected.width() / kTogether_px + 1;
  const int rows = comparison.expected.height() / kTogether_px + 1;
  Image<std::int32_t> chains{columns, rows, -1};
  for (const auto& shift : shifts) chains(shift.x / kTogether_px, shift.y / kTogether_px) = 0;
  std::int32_t count = 0;
  std::vector<Eigen::Vector2i> open;
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      if (chains(x, y) != 0) continue;
      ++count;
      open.assign(1, {x, y});
      while (!open.empty()) {
        const Eigen::Vector2i p = open.back();
        open.pop_back();
        if (p.x() < 0 || p.y() < 0 || p.x() >= columns || p.y() >= rows || chains(p.x(), p.y()) != 0) continue;
        chains(p.x(), p.y()) = count;
        for (int j = -1; j <= 1; ++j) {
          for (int i = -1; i <= 1; ++i) open.emplace_back(p.x() + i, p.y() + j);
        }
      }
    }
  }
  std::map<std::pair<std::int32_t, std::uint32_t>, int> things;
  for (auto& shift : shifts) {
    const std::pair key{chains(shift.x / kTogether_px, shift.y / kTogether_px),
                        comparison.node_index(shift.x, shift.y)};
    shift.thing = things.try_emplace(key, static_cast<int>(things.size())).first->second;
  }
}

/// How a twist of exp(twist) p = "where the pose expects it" shifts the measured outline from the expected one: the
/// measured point is exp(-twist) of the expected one.
Eigen::Matrix<double, 1, 6> shift_by_motion(const OutlineShift& shift, const Camera& camera) {
  const Eigen::Vector3d p = camera.back_project(shift.x, shift.y, shift.near_z_m);
  Eigen::Matrix<double, 2, 3> projection;
  projection << camera.fx / p.z(), 0, -camera.fx * p.x() / (p.z() * p.z()), 0, camera.fy / p.z(),
      -camera.fy * p.y() / (p.z() * p.z());
  Eigen::Matrix<double, 3, 6> motion;
  motion << -Eigen::Matrix3d::Identity(), skew(p);
  return shift.across.transpose() * projection * motion;
}

struct Row {
  Eigen::Matrix<double, 1, 6> by_motion;
  const OutlineShift* shift;
};

Twist fit_motion(const std::vector<Row>& rows) {
  Twist motion = Twist::Zero();
  for (const double scale : kScales_px) {
    for (int round = 0; round < kRounds; ++round) {
      PoseCovariance information = PoseCovariance::Identity() / (kMotion * kMotion);
      Twist pull = Twist::Zero();
      for (const auto& [by_motion, shift] : rows) {
        const double left = shift->shift_px - by_motion.dot(motion);
        const double share = left * left / (scale * scale);
        const double weight = 1 / ((1 + share) * (1 + share) * kNoise_px * kNoise_px);
        information += weight * by_motion.transpose() * by_motion;
        pull += weight * shift->shift_px * by_motion.transpose();
      }
      motion = information.ldlt().solve(pull);
    }
  }
  return motion;
}

}  // namespace

std::vector<OutlineShift> outline_shifts(const Comparison& comparison, const DepthImage& measured,
                                         const SensorModel& sensor) {
  auto shifts = Outlines{comparison.expected, measured, sensor}.find();
  number_things(shifts, comparison);
  return shifts;
}

EdgeRings find_edge_rings(const Comparison& comparison, const DepthImage& measured, const Camera& camera,
                          const SensorModel& sensor) {
  EdgeRings rings;
  const auto shifts = outline_shifts(comparison, measured, sensor);
  rings.outlines = static_cast<int>(shifts.size());
  std::vector<Row> rows;
  for (const auto& shift : shifts) {
    if (std::isfinite(shift.shift_px)) rows.push_back({shift_by_motion(shift, camera), &shift});
  }
  if (rows.empty()) return rings;
  rings.motion = fit_motion(rows);
  std::map<int, int> of_things;
  int shifted = 0;
  int explained = 0;
  for (const auto& row : rows) {
    const double shift_px = row.shift->shift_px;
    const double expected_px = row.by_motion.dot(rings.motion);
    const bool is_at_place = std::abs(shift_px) < kAtPlace_px;
    (is_at_place ? rings.at_place : shift_px > 0 ? rings.ringed_closer : rings.ringed_farther) += 1;
    if (std::abs(expected_px) < kShifted_px) continue;
    ++shifted;
    if (std::abs(shift_px - expected_px) < kAtPlace_px) {
      ++explained;
      ++of_things[row.shift->thing];
    } else if (is_at_place) {
      rings.contradicted += 1;
    }
  }
  for (double* share : {&rings.at_place, &rings.ringed_closer, &rings.ringed_farther}) *share /= rings.outlines;
  rings.shifted = static_cast<double>(shifted) / rings.outlines;
  if (shifted > 0) rings.explained = static_cast<double>(explained) / shifted;
  if (shifted > 0) rings.contradicted /= shifted;
  int largest = 0;
  for (const auto& [thing, count] : of_things) {
    rings.things += count >= kFewestOfAThing ? 1 : 0;
    largest = std::max(largest, count);
  }
  if (explained > 0) rings.largest_thing = static_cast<double>(largest) / explained;
  return rings;
}

bool EdgeRings::is_misregistered() const {
  return shifted * outlines >= kFewestShifted && shifted >= kLeastShifted && explained >= kLeastExplained &&
         contradicted <= kMostContradicted && things >= kFewestThings && largest_thing <= kLargestThing;
}

}  // namespace meshloop
