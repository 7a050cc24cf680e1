#include "common/recording/trajectory.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "common/base/file.h"
#include "common/recording/text_lines.h"

namespace meshloop {
namespace {

constexpr std::size_t kLargestFile = 256u << 20;
constexpr double kUnitTolerance = 1e-3;

// tx ty tz qx qy qz qw
Result<Pose> pose_of(std::span<const double, 7> n) {
  const Eigen::Quaterniond rotation{n[6], n[3], n[4], n[5]};
  if (!(std::abs(rotation.norm() - 1) < kUnitTolerance)) {
    return fail(fmt::format("the quaternion has the length {:.4g}, but must have length 1", rotation.norm()));
  }
  return make_pose({n[0], n[1], n[2]}, rotation);
}

template <std::size_t kCount>
Result<std::array<double, kCount>> parse_numbers(std::string_view text, std::string_view separators) {
  std::array<double, kCount> numbers{};
  for (std::size_t i = 0; i < kCount; ++i) {
    if (text.empty()) return fail(fmt::format("expected {} numbers, but there are {}", kCount, i));
    const auto word = take_word(text, separators);
    const auto number = number_of(word);
    if (!number) return fail(fmt::format("'{:.40}' is not a finite number", word));
    numbers[i] = *number;
  }
  if (!text.empty()) return fail(fmt::format("expected {} numbers, but there are more", kCount));
  return numbers;
}

Result<StampedPose> parse_line(std::string_view line) {
  const auto numbers = parse_numbers<8>(line, " \t");
  if (!numbers) return fail(numbers.error());
  const auto pose = pose_of(std::span{*numbers}.subspan<1>());
  if (!pose) return fail(pose.error());
  return StampedPose{numbers->front(), *pose};
}

}  // namespace

Result<Trajectory> read_trajectory(const std::filesystem::path& file) {
  const auto text = read_text_file(file, kLargestFile);
  if (!text) return fail(text.error());
  Trajectory trajectory;
  for (const auto& line : lines_of(*text)) {
    const auto where = fmt::format("'{}', line {}", file.string(), line.number);
    const auto pose = parse_line(line.text);
    if (!pose) return fail(where, pose.error());
    if (!trajectory.empty() && pose->timestamp_s <= trajectory.back().timestamp_s) {
      return fail(where + ": the timestamps must grow");
    }
    trajectory.push_back(*pose);
  }
  return trajectory;
}

Status write_trajectory(const std::filesystem::path& file, const Trajectory& trajectory) {
  std::string text = "# timestamp tx ty tz qx qy qz qw (camera to world)\n";
  for (const auto& [timestamp_s, pose] : trajectory) text += trajectory_line(timestamp_s, pose);
  return write_text_file(file, text);
}

std::string trajectory_line(double timestamp_s, const Pose& T_world_camera) {
  const Eigen::Vector3d t = T_world_camera.translation();
  const Eigen::Quaterniond q = Eigen::Quaterniond(T_world_camera.linear()).normalized();
  return fmt::format("{} {} {} {} {} {} {} {}\n", timestamp_s, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}

std::optional<Pose> pose_at(const Trajectory& trajectory, double timestamp_s, double max_gap_s) {
  const auto after = std::lower_bound(trajectory.begin(), trajectory.end(), timestamp_s,
                                      [](const StampedPose& pose, double time) { return pose.timestamp_s < time; });
  if (after == trajectory.end()) return std::nullopt;
  if (after->timestamp_s == timestamp_s) return after->T_world_camera;
  if (after == trajectory.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const double gap = after->timestamp_s - before->timestamp_s;
  if (!(gap <= max_gap_s)) return std::nullopt;
  return interpolate(before->T_world_camera, after->T_world_camera, (timestamp_s - before->timestamp_s) / gap);
}

Result<Pose> parse_pose(const std::string& text) {
  const auto numbers = parse_numbers<7>(text, ", ");
  const auto doing = fmt::format("the pose '{:.120}' must be TX,TY,TZ,QX,QY,QZ,QW", text);
  if (!numbers) return fail(doing + ": " + numbers.error().message, ErrorKind::usage);
  auto pose = pose_of(*numbers);
  if (!pose) return fail(doing + ": " + pose.error().message, ErrorKind::usage);
  return pose;
}

}  // namespace meshloop
