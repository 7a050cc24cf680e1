#include "device/pipeline/start_pose.h"

#include <utility>

#include "common/program/arguments.h"
#include "common/recording/trajectory.h"

namespace meshloop {

Result<StartPose> StartPose::parse(const std::string& text) {
  const auto [kind, rest] = split_kind(text);
  StartPose start;
  if (kind == "pose") {
    const auto T_world_camera = parse_pose(rest);
    if (!T_world_camera) return fail("--init", T_world_camera.error());
    start.given_ = T_world_camera->inverse();
    return start;
  }
  if (kind == "markers") {
    auto markers = read_markers(rest);
    if (!markers) return fail("--init", markers.error());
    auto detector = MarkerDetector::create(markers->dictionary);
    if (!detector) return fail("--init", detector.error());
    start.markers_ = std::move(*markers);
    start.detector_ = std::move(*detector);
    return start;
  }
  return fail("--init takes pose:tx,ty,tz,qx,qy,qz,qw or markers:FILE", ErrorKind::usage);
}

std::optional<Pose> StartPose::find(const ColorFrame& frame, const Camera& camera) {
  if (given_) return std::exchange(given_, std::nullopt);
  if (!detector_) return std::nullopt;
  const auto sightings = detector_->detect(to_grey(frame.color));
  const auto found = pose_from_markers(sightings, *markers_, camera, std::nullopt);
  return found ? std::optional<Pose>{found->T_camera_world} : std::nullopt;
}

}  // namespace meshloop
