// rig.yaml: the cameras of a recording and how they are coupled.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "common/base/file.h"
#include "common/recording/recording.h"
#include "common/recording/rig_uncertainty.h"
#include "common/recording/yaml_reader.h"

namespace meshloop {
namespace {

constexpr double kUnitTolerance = 1e-3;
// Coefficients of a lens that is not rational.
constexpr std::size_t kPlainLens = 5;

// k1, k2, p1, p2, k3, and k4, k5, k6 where the lens is rational.
Status parse_distortion(const YAML::Node& node, const std::string& key, Camera& camera) {
  if (!node.IsSequence() || (node.size() != kPlainLens && node.size() != camera.distortion.size())) {
    return fail(fmt::format("'{}' must be a list of {} or {} numbers", key, kPlainLens, camera.distortion.size()));
  }
  return read_numbers(node, key, std::span{camera.distortion}.first(node.size()));
}

Result<Camera> parse_camera(const YAML::Node& node, const std::string& where) {
  if (auto ok = check_keys(node, where, {"width", "height", "fx", "fy", "cx", "cy", "distortion"}); !ok) {
    return fail(ok.error());
  }
  Camera camera;
  for (const auto& [key, value] : {std::pair{"width", &camera.width}, std::pair{"height", &camera.height}}) {
    const auto number = read_integer(node[key], where + "." + key);
    if (!number) return fail(number.error());
    *value = *number;
  }
  for (const auto& [key, value] : {std::pair{"fx", &camera.fx}, std::pair{"fy", &camera.fy},
                                   std::pair{"cx", &camera.cx}, std::pair{"cy", &camera.cy}}) {
    const auto number = read_number(node[key], where + "." + key);
    if (!number) return fail(number.error());
    *value = *number;
  }
  if (auto ok = parse_distortion(node["distortion"], where + ".distortion", camera); !ok) return fail(ok.error());
  if (auto ok = validate(camera); !ok) return fail(where, ok.error());
  return camera;
}

Result<Pose> parse_pose_map(const YAML::Node& node, const std::string& where) {
  if (auto ok = check_keys(node, where, {"translation", "rotation_xyzw"}); !ok) return fail(ok.error());
  Eigen::Vector3d translation;
  Eigen::Quaterniond rotation;
  if (auto ok = read_numbers(node["translation"], where + ".translation", {translation.data(), 3}); !ok) {
    return fail(ok.error());
  }
  // Eigen stores x, y, z, w
  if (auto ok = read_numbers(node["rotation_xyzw"], where + ".rotation_xyzw", {rotation.coeffs().data(), 4}); !ok) {
    return fail(ok.error());
  }
  if (!(std::abs(rotation.norm() - 1) < kUnitTolerance)) {
    return fail(
        fmt::format("'{}.rotation_xyzw' has the length {:.4g}, but must have length 1", where, rotation.norm()));
  }
  return make_pose(translation, rotation);
}

bool same_camera(const Camera& a, const Camera& b) {
  return a.width == b.width && a.height == b.height && a.fx == b.fx && a.fy == b.fy && a.cx == b.cx && a.cy == b.cy &&
         a.distortion == b.distortion;
}

Status check_rig(const Rig& rig) {
  if (auto ok = validate(rig); !ok) return ok;
  if (!rig.depth_registered) return {};
  if (!same_camera(rig.color, rig.depth)) {
    return fail(
        "'depth_registered' is true, so 'depth' must repeat the numbers of 'color'; for registered depth of "
        "another size say false, with that size's intrinsics and no rotation and translation");
  }
  if (!rig.T_depth_color.isApprox(Pose::Identity(), 1e-9)) {
    return fail("'depth_registered' is true, so 'T_depth_color' must be the identity");
  }
  if (!rig.covariance.T_depth_color.isZero()) {
    return fail("'depth_registered' is true, so 'T_depth_color' is exact; leave its covariance out");
  }
  return {};
}

Result<Rig> parse_rig(const YAML::Node& root) {
  if (auto ok = check_keys(root, "", {"color", "depth", "depth_scale", "T_depth_color", "sensor", "depth_registered"},
                           {"covariance"});
      !ok) {
    return fail(ok.error());
  }
  const auto color = parse_camera(root["color"], "color");
  if (!color) return fail(color.error());
  const auto depth = parse_camera(root["depth"], "depth");
  if (!depth) return fail(depth.error());
  const auto depth_scale = read_number(root["depth_scale"], "depth_scale");
  if (!depth_scale) return fail(depth_scale.error());
  const auto T_depth_color = parse_pose_map(root["T_depth_color"], "T_depth_color");
  if (!T_depth_color) return fail(T_depth_color.error());
  const auto sensor = parse_sensor(root["sensor"]);
  if (!sensor) return fail(sensor.error());
  const auto registered = read_bool(root["depth_registered"], "depth_registered");
  if (!registered) return fail(registered.error());
  const auto covariance = parse_covariance(root["covariance"]);
  if (!covariance) return fail(covariance.error());
  const Rig rig{*color, *depth, *depth_scale, *T_depth_color, *sensor, *registered, *covariance};
  if (auto ok = check_rig(rig); !ok) return fail(ok.error());
  return rig;
}

// Numbers are printed with as many digits as it takes to read the same bits again.
std::string camera_line(const std::string& name, const Camera& c) {
  const bool rational =
      std::any_of(c.distortion.begin() + kPlainLens, c.distortion.end(), [](double k) { return k != 0; });
  const auto lens = std::span{c.distortion}.first(rational ? c.distortion.size() : kPlainLens);
  return fmt::format("{}: {{width: {}, height: {}, fx: {}, fy: {}, cx: {}, cy: {}, distortion: [{}]}}\n", name, c.width,
                     c.height, c.fx, c.fy, c.cx, c.cy, fmt::join(lens, ", "));
}

std::string pose_line(const Pose& pose) {
  const Eigen::Vector3d t = pose.translation();
  const Eigen::Quaterniond q = Eigen::Quaterniond(pose.linear()).normalized();
  return fmt::format("T_depth_color: {{translation: [{}, {}, {}], rotation_xyzw: [{}, {}, {}, {}]}}\n", t.x(), t.y(),
                     t.z(), q.x(), q.y(), q.z(), q.w());
}

}  // namespace

Result<Rig> read_rig(const std::filesystem::path& file) {
  const auto root = load_yaml_map(file);
  if (!root) return fail(root.error());
  try {
    auto rig = parse_rig(*root);
    if (!rig) return fail(fmt::format("'{}'", file.string()), rig.error());
    return rig;
  } catch (const YAML::Exception& error) {
    return fail(fmt::format("'{}', line {}: {}", file.string(), error.mark.line + 1, error.msg));
  }
}

std::string rig_text(const Rig& rig) {
  return camera_line("color", rig.color) + camera_line("depth", rig.depth) +
         fmt::format("depth_scale: {}  # metres per unit of the depth images\n", rig.depth_scale) +
         pose_line(rig.T_depth_color) +
         fmt::format("sensor: {}\ndepth_registered: {}\n", sensor_text(rig.sensor), rig.depth_registered) +
         covariance_text(rig.covariance);
}

Status write_rig(const std::filesystem::path& file, const Rig& rig) {
  if (auto ok = check_rig(rig); !ok) return fail(fmt::format("cannot write '{}'", file.string()), ok.error());
  return write_text_file(file, rig_text(rig));
}

}  // namespace meshloop
