#include "common/simulation/demo_recordings.h"

#include <fmt/format.h>

#include <numbers>
#include <utility>

#include "common/base/file.h"
#include "common/image/image_file.h"
#include "common/simulation/random.h"
#include "common/simulation/sensor.h"

namespace meshloop::simulation {
namespace {

namespace fs = std::filesystem;

constexpr double kStart_s = 1;
constexpr double kStationPeriod_s = 0.1;
// A walk around the box in twelve seconds: a software renderer with two cores sees five pictures a second of it.
constexpr double kDevicePeriod_s = 0.1;
constexpr double kDepthDelay_s = 0.012;
constexpr double kGap_s = 2;
constexpr double kColorNoise = 2;
constexpr int kSupersampling = 2;
// Frames are made in parallel, so that each one is cast on one thread.
constexpr int kOneThread = 1;

/// When a frame of the station is taken, and where it stands on its round.
struct Moment {
  int half = 0;
  double round_s = 0;
  double in_round_s = 0;
  double color_s = 0;
};

Moment station_moment(int index, int frames) {
  const int first_half = (frames + 1) / 2;
  Moment moment;
  moment.half = index < first_half ? 0 : 1;
  moment.round_s = kStationPeriod_s * (moment.half == 0 ? first_half : frames - first_half);
  moment.in_round_s = kStationPeriod_s * (index - moment.half * first_half);
  moment.color_s = kStart_s + kStationPeriod_s * index + kGap_s * moment.half;
  return moment;
}

ColorImage color_frame(const Scene& scene, const Camera& camera, const Pose& T_world_color, double noise,
                       std::uint64_t seed) {
  ColorImage image = cast_color(scene, camera, T_world_color.inverse(), kSupersampling, kOneThread);
  add_color_noise(image, kColorNoise * noise, seed);
  return image;
}

// focal_px is meant for 640 columns.
Camera kinect_camera(const DemoRig::Size& size, double focal_px) {
  const double focal = focal_px * size.width / 640;
  return {size.width, size.height, focal, focal, (size.width - 1) / 2.0, (size.height - 1) / 2.0, {}};
}

DepthFormat depth_format(const DemoOptions& options) {
  return options.rig.float_depth ? DepthFormat::float_tiff : DepthFormat::png16;
}

std::string truth_line(int index, double depth_s, int half, const Pose& T_world_depth) {
  const Eigen::Vector3d t = T_world_depth.translation();
  const Eigen::Quaterniond q(T_world_depth.linear());
  return fmt::format("{} {:.6f} {} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f} {:.9f}\n", index, depth_s, half, t.x(),
                     t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}

}  // namespace

Rig demo_rig(const DemoOptions& options) {
  Rig rig;
  rig.color = kinect_camera(options.rig.color, 525);
  rig.depth = kinect_camera(options.rig.depth, 585);
  const Eigen::Vector3d axis = Eigen::Vector3d(0.3, 1, -0.2).normalized();
  rig.T_depth_color =
      make_pose({0.025, 0.0006, -0.0011}, Eigen::Quaterniond(Eigen::AngleAxisd(0.5 * std::numbers::pi / 180, axis)));
  if (options.rig.registered) {
    rig.depth = rig.color;
    rig.T_depth_color = Pose::Identity();
    rig.depth_registered = true;
  }
  if (options.noise > 0) {
    rig.sensor = SensorModel{SensorModel::Kind::kinect1};
  } else {
    rig.depth_scale = 0.00025;
    rig.sensor = SensorModel{SensorModel::Kind::constant, 0.001};
  }
  if (options.rig.float_depth) rig.depth_scale = 1;
  return rig;
}

StationRecording::StationRecording(RecordingWriter writer, fs::path truth, const Scene& before, const Scene& after,
                                   const DemoOptions& options)
    : options_{options},
      rig_{demo_rig(options)},
      before_{before},
      after_{after},
      writer_{std::move(writer)},
      truth_{std::move(truth)},
      lines_(static_cast<std::size_t>(options.station_frames)) {}

Result<std::unique_ptr<StationRecording>> StationRecording::create(const fs::path& folder, const Scene& before,
                                                                   const Scene& after, const DemoOptions& options) {
  auto writer = RecordingWriter::create(folder / "station", demo_rig(options), depth_format(options));
  if (!writer) return fail(writer.error());
  const fs::path truth = folder / "station_truth";
  std::error_code error;
  fs::create_directories(truth, error);
  if (error) return fail(fmt::format("cannot make the folder '{}': {}", truth.string(), error.message()));
  return std::unique_ptr<StationRecording>(new StationRecording(std::move(*writer), truth, before, after, options));
}

Status StationRecording::make_frame(int index) {
  Turns::Turn turn(turns_, index);
  const Moment moment = station_moment(index, options_.station_frames);
  const Scene& scene = moment.half == 0 ? before_ : after_;
  const StationPath path{moment.round_s, moment.half};
  const Pose T_world_color = path.at(moment.in_round_s);
  const Pose T_world_color_later = path.at(moment.in_round_s + kDepthDelay_s);
  const Pose T_depth_world = rig_.T_depth_color * T_world_color_later.inverse();
  const std::uint64_t seed = random_bits(options_.seed, static_cast<std::uint64_t>(index));

  const ColorImage color = color_frame(scene, rig_.color, T_world_color, options_.noise, seed);
  const ExactDepth exact = cast_depth(scene, rig_.depth, T_depth_world, false, kOneThread);
  const DepthImage depth = measure(exact, rig_.depth, rig_.sensor, {options_.noise, mix(seed)});
  if (auto ok = write_truth(index, T_depth_world, exact.depth); !ok) return ok;

  turn.wait();
  const double depth_s = moment.color_s + kDepthDelay_s;
  lines_[static_cast<std::size_t>(index)] = truth_line(index, depth_s, moment.half, T_depth_world.inverse());
  if (auto ok = writer_.add_color(moment.color_s, color); !ok) return ok;
  if (auto ok = writer_.add_depth(depth_s, depth); !ok) return ok;
  if (auto ok = writer_.add_ground_truth(moment.color_s, T_world_color); !ok) return ok;
  return writer_.add_ground_truth(depth_s, T_world_color_later);
}

Status StationRecording::write_truth(int index, const Pose& T_depth_world, const DepthImage& measured) const {
  const auto write = [&](const char* name, const DepthImage& image) {
    return write_tiff(truth_ / fmt::format("{}_{:06}.tiff", name, index), image);
  };
  if (auto ok = write("measured", measured); !ok) return ok;
  const auto expected = cast_depth(before_, rig_.depth, T_depth_world, true, kOneThread);
  if (auto ok = write("expected", expected.depth); !ok) return ok;
  if (station_moment(index, options_.station_frames).half == 0) return {};
  return write("previous", cast_depth(before_, rig_.depth, T_depth_world, false, kOneThread).depth);
}

Status StationRecording::finish() const {
  std::string text = "# frame depth_timestamp half tx ty tz qx qy qz qw (T_world_depth)\n";
  for (const std::string& line : lines_) text += line;
  return write_text_file(truth_ / "frames.txt", text);
}

DeviceRecording::DeviceRecording(RecordingWriter writer, const Scene& scene, const DemoOptions& options,
                                 const DevicePath& path, std::uint64_t noise_seed)
    : options_{options},
      rig_{demo_rig(options)},
      scene_{scene},
      path_{path},
      noise_seed_{noise_seed},
      writer_{std::move(writer)} {}

Result<std::unique_ptr<DeviceRecording>> DeviceRecording::create(const fs::path& folder, const Scene& scene,
                                                                 const DemoOptions& options, const DevicePath& path,
                                                                 std::uint64_t noise_seed) {
  auto writer = RecordingWriter::create(folder, demo_rig(options));
  if (!writer) return fail(writer.error());
  return std::unique_ptr<DeviceRecording>(new DeviceRecording(std::move(*writer), scene, options, path, noise_seed));
}

Status DeviceRecording::make_frame(int index) {
  Turns::Turn turn(turns_, index);
  const double in_round_s = kDevicePeriod_s * index;
  DevicePath path = path_;
  path.round_s = kDevicePeriod_s * options_.device_frames;
  const Pose T_world_color = path.at(in_round_s);
  const std::uint64_t seed = random_bits(noise_seed_, static_cast<std::uint64_t>(index));
  const ColorImage color = color_frame(scene_, rig_.color, T_world_color, options_.noise, seed);
  turn.wait();
  if (auto ok = writer_.add_color(kStart_s + in_round_s, color); !ok) return ok;
  return writer_.add_ground_truth(kStart_s + in_round_s, T_world_color);
}

}  // namespace meshloop::simulation
