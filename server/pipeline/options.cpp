#include "server/pipeline/options.h"

#include <fmt/format.h>
#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>

#include "common/program/arguments.h"
#include "server/capture/prefetching_source.h"
#include "server/capture/recording_source.h"
#include "server/pipeline/operator_name.h"

namespace meshloop {
namespace {

Result<RigTrackerOptions> tracker_options(const std::string& markers, const std::string& init) {
  RigTrackerOptions options;
  if (!markers.empty()) {
    auto map = read_markers(markers);
    if (!map) return fail(map.error());
    options.markers = std::move(*map);
  }
  if (!init.empty()) {
    const auto [kind, rest] = split_kind(init);
    if (kind != "pose") return fail("--init takes pose:tx,ty,tz,qx,qy,qz,qw", ErrorKind::usage);
    const auto T_world_color = parse_pose(rest);
    if (!T_world_color) return fail("--init", T_world_color.error());
    options.first_pose = T_world_color->inverse();
  }
  return options;
}

std::string check_name(const std::string& name) {
  // No value at all is refused for every option alike.
  return name.empty() ? std::string{} : why_not_one_line(name, "a name", kLongestName);
}

/// $USER is left out where a service or a container starts the program.
std::string login_name() {
  const char* user = std::getenv("USER");
  if (user != nullptr && *user != '\0' && check_name(user).empty()) return user;
  const passwd* entry = ::getpwuid(::geteuid());
  return entry != nullptr && *entry->pw_name != '\0' ? entry->pw_name : "operator";
}

}  // namespace

OperatorArguments::OperatorArguments() : name{login_name()} {}

void OperatorArguments::add_to(CLI::App& command) {
  command
      .add_option("--operator", name,
                  "who the journal says it was: UTF-8, at most 100 letters; the login name if not given")
      ->check(CLI::Validator{check_name, ""});
}

void SurfaceArguments::add_to(CLI::App& command) {
  command
      .add_option(
          "--fuse", fuse,
          "make new surface of this frame and those before it, so many in all; frames whose pose is uncertain or "
          "that moved too fast are left out")
      ->check(CLI::Range(1, static_cast<int>(kMostFusedViews)))
      ->capture_default_str();
  command
      .add_option(
          "--decimate", decimate_sigmas,
          "leave out triangles of new surface as long as it stays within so many sigma of the sensor's noise, and "
          "(without --texture on) its brightness within 12 levels of 255; 0: keep all")
      ->check(between(0, 3))
      ->capture_default_str();
  command
      .add_option("--texture", texture,
                  "on: new surface keeps its colours as a picture, as fine as the depth image, however few triangles "
                  "it has; off: as a colour for each corner of a triangle")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
  command
      .add_option(
          "--stitch", stitch,
          "on: new surface ends in the same vertices as the surface that it continues; off: it overlaps that by "
          "a pixel")
      ->check(CLI::IsMember({"on", "off"}))
      ->capture_default_str();
}

AdjustOptions SurfaceArguments::adjust_options() const {
  AdjustOptions options;
  options.decimate_sigmas = decimate_sigmas;
  options.texture = texture == "on";
  options.stitch = stitch == "on";
  return options;
}

void RecordingArguments::add_to(CLI::App& command, bool poses_allowed) {
  command.add_option("--recording", recording, "folder with rgb.txt, depth.txt and rig.yaml")->required();
  if (poses_allowed) {
    command.add_option("--poses", poses,
                       "colour camera poses (TUM format, camera to world); groundtruth.txt if not given");
  }
  add_source_options(command);
  poses_allowed_ = poses_allowed;
}

void RecordingArguments::add_source_options(CLI::App& command) {
  poses_allowed_ = false;
  command.add_option("--rig", rig, "another rig.yaml than the recording's");
  command.add_option("--sensor", sensor,
                     "another noise model than the rig's: kinect1, kinect1-khoshelham, tof or constant:METRES");
  command.add_option("--markers", markers, "track by these markers (markers.yaml)");
  command.add_option("--init", init, "pose:tx,ty,tz,qx,qy,qz,qw of the first colour image, camera to world");
}

Result<TrackedFrames> RecordingArguments::open(bool live, bool real_time) const {
  RecordingSource::Options source_options{.real_time = real_time};
  if (!sensor.empty()) {
    auto model = parse_sensor(sensor);
    if (!model) return fail("--sensor", model.error());
    source_options.sensor = *model;
  }
  auto source = RecordingSource::open(recording, rig.empty() ? std::nullopt : std::optional<std::filesystem::path>{rig},
                                      std::move(source_options));
  if (!source) return fail(source.error());
  PoseOptions options;
  options.skip_unreadable = live;
  const bool tracks = !markers.empty() || !init.empty();
  if (!poses.empty() && tracks) {
    return fail("--poses says where the camera was, --markers and --init have it found; give one of them",
                ErrorKind::usage);
  }
  if (!poses.empty()) {
    auto trajectory = read_trajectory(poses);
    if (!trajectory) return fail(trajectory.error());
    options.trajectory = std::move(*trajectory);
  } else if (tracks) {
    auto tracker = tracker_options(markers, init);
    if (!tracker) return fail(tracker.error());
    options.tracker = std::move(*tracker);
  } else if (poses_allowed_ && (*source)->recording().ground_truth()) {
    options.trajectory = (*source)->recording().ground_truth();
  } else {
    return fail(fmt::format("where do the poses of '{}' come from? Give --markers or --init{}", recording,
                            poses_allowed_ ? ", or --poses" : ""),
                ErrorKind::usage);
  }
  auto ahead = std::make_unique<PrefetchingSource>(std::move(*source), WhenFull::wait);
  return TrackedFrames::create(std::move(ahead), std::move(options));
}

void ThresholdArguments::add_to(CLI::App& command) {
  command
      .add_option("--threshold", threshold, "what counts as a change: metres (0.02) or multiples of the noise (3sigma)")
      ->capture_default_str();
  command
      .add_option("--model-sigma", model_sigma_m,
                  "how far the model may be from the real surfaces, in metres (one sigma)")
      ->check(between(0, 0.2))
      ->capture_default_str();
  command.add_flag("--exact", exact,
                   "draw every triangle of the model, however far away; slower with large models and many frames");
}

Result<ExaminerOptions> ThresholdArguments::examiner_options() const {
  const auto parsed = parse_threshold(threshold);
  if (!parsed) return fail(parsed.error());
  if (model_sigma_m > 0 && parsed->kind == Threshold::Kind::fixed) {
    return fail("--model-sigma widens a threshold in sigmas; with --threshold in metres it would do nothing",
                ErrorKind::usage);
  }
  ExaminerOptions options = ExaminerOptions::of(*parsed);
  options.model_sigma_m = model_sigma_m;
  if (exact) options.detail_share = 0;
  return options;
}

std::string ThresholdArguments::text() const {
  return threshold.ends_with("sigma") ? threshold : threshold + " m";
}

Result<SensorModel> parse_sensor(const std::string& text) {
  if (auto named = SensorModel::from_name(text)) return named;
  const auto [kind, rest] = split_kind(text);
  double sigma_m = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), sigma_m);
  if (kind != "constant" || error != std::errc{} || end != rest.data() + rest.size()) {
    return fail(fmt::format("unknown sensor '{}'; use kinect1, kinect1-khoshelham, tof or constant:METRES", text),
                ErrorKind::usage);
  }
  auto constant = SensorModel::constant(sigma_m);
  if (!constant) return fail(constant.error().message, ErrorKind::usage);
  return constant;
}

Result<Threshold> parse_threshold(const std::string& text) {
  Threshold threshold;
  const auto suffix = text.find("sigma");
  threshold.kind = suffix == std::string::npos ? Threshold::Kind::fixed : Threshold::Kind::k_sigma;
  const std::string number = text.substr(0, suffix);
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), threshold.value);
  const bool whole = error == std::errc{} && end == number.data() + number.size();
  const bool known_suffix = suffix == std::string::npos || text.substr(suffix) == "sigma";
  const double most = threshold.kind == Threshold::Kind::fixed ? 1 : 100;
  if (!whole || !known_suffix || !(threshold.value > 0 && threshold.value <= most)) {
    return fail(fmt::format("'{}' is not a threshold; use metres (0.02, at most 1) or multiples of the noise (3sigma, "
                            "at most 100)",
                            text),
                ErrorKind::usage);
  }
  return threshold;
}

}  // namespace meshloop
