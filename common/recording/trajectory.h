#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.h"
#include "common/geometry/pose.h"

namespace meshloop {

struct StampedPose {
  double timestamp_s = 0;
  /// Camera to world, as TUM files hold it.
  Pose T_world_camera = Pose::Identity();
};

/// Poses in the order of time.
using Trajectory = std::vector<StampedPose>;

/// TUM format: `timestamp tx ty tz qx qy qz qw`, `#` comments. Refuses numbers that are not finite, a quaternion that
/// is not of unit length (to 1e-3) and times that do not grow.
[[nodiscard]] Result<Trajectory> read_trajectory(const std::filesystem::path& file);
[[nodiscard]] Status write_trajectory(const std::filesystem::path& file, const Trajectory& trajectory);
/// One line of such a file, with its line end. Numbers are read back with the same bits.
[[nodiscard]] std::string trajectory_line(double timestamp_s, const Pose& T_world_camera);

/// Interpolated on SE(3); nothing outside the trajectory's time or inside a gap longer than `max_gap_s`.
[[nodiscard]] std::optional<Pose> pose_at(const Trajectory& trajectory, double timestamp_s, double max_gap_s = 0.5);

/// `tx,ty,tz,qx,qy,qz,qw`, camera to world, as on the command line.
[[nodiscard]] Result<Pose> parse_pose(const std::string& text);

}  // namespace meshloop
