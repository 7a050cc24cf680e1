#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <system_error>

#include "common/base/file.h"
#include "common/image/image_file.h"
#include "common/recording/recording.h"

namespace meshloop {
namespace {

namespace fs = std::filesystem;

Status make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return fail(fmt::format("cannot make the folder '{}': {}", folder.string(), error.message()));
  return {};
}

template <class T>
Status check_size(const Image<T>& image, const Camera& camera, const char* name) {
  if (image.width() == camera.width && image.height() == camera.height) return {};
  return fail(fmt::format("the image has {}x{} pixels, but the rig's {} camera has {}x{}", image.width(),
                          image.height(), name, camera.width, camera.height));
}

std::uint16_t units_of(float depth_m, double scale) {
  const double units = std::round(depth_m / scale);
  return units >= 0 && units <= 65535 ? static_cast<std::uint16_t>(units) : std::uint16_t{0};
}

float float_units_of(float depth_m, double scale) {
  return std::isfinite(depth_m) && depth_m > 0 ? static_cast<float>(depth_m / scale) : 0.0F;
}

template <class T, class Convert>
Image<T> in_units(const DepthImage& image_m, Convert convert) {
  Image<T> units{image_m.width(), image_m.height()};
  std::transform(image_m.pixels().begin(), image_m.pixels().end(), units.pixels().begin(), convert);
  return units;
}

}  // namespace

Result<RecordingWriter> RecordingWriter::create(const fs::path& folder, const Rig& rig, DepthFormat depth_format) {
  std::error_code ignored;
  for (const char* list : {"rgb.txt", "depth.txt"}) {
    if (fs::exists(folder / list, ignored)) {
      return fail(fmt::format("'{}' holds a recording already; name another folder or delete it", folder.string()));
    }
  }
  for (const char* name : {"", "rgb", "depth"}) {
    if (auto ok = make_folder(folder / name); !ok) return fail(ok.error());
  }
  if (auto ok = write_rig(folder / "rig.yaml", rig); !ok) return fail(ok.error());
  return RecordingWriter{rig, folder, depth_format};
}

Status RecordingWriter::check_time(const Stream& stream, double timestamp_s) const {
  if (std::isfinite(timestamp_s) && (stream.count == 0 || timestamp_s > stream.last_s)) return {};
  return fail(fmt::format("the timestamp {} s does not follow {} s in '{}.txt'", timestamp_s, stream.last_s,
                          (folder_ / stream.name).string()));
}

Status RecordingWriter::append(Stream& stream, double timestamp_s, const std::string& header, const std::string& line) {
  const auto text = stream.count == 0 ? "# " + header + "\n" + line : line;
  if (auto ok = append_text_file(folder_ / (stream.name + ".txt"), text); !ok) return ok;
  stream.last_s = timestamp_s;
  ++stream.count;
  return {};
}

template <class Write>
Status RecordingWriter::add_image(Stream& stream, double timestamp_s, const char* ending, Write write) {
  if (auto ok = check_time(stream, timestamp_s); !ok) return ok;
  const auto name = fmt::format("{}/{:06}.{}", stream.name, stream.count, ending);
  if (Status ok = write(folder_ / name); !ok) return ok;
  return append(stream, timestamp_s, "timestamp path", fmt::format("{} {}\n", timestamp_s, name));
}

Status RecordingWriter::add_color(double timestamp_s, const ColorImage& image) {
  if (auto ok = check_size(image, rig_.color, "color"); !ok) return ok;
  return add_image(color_, timestamp_s, "png", [&](const fs::path& file) { return write_png(file, image); });
}

Status RecordingWriter::add_depth(double timestamp_s, const DepthImage& image_m) {
  if (auto ok = check_size(image_m, rig_.depth, "depth"); !ok) return ok;
  if (depth_format_ == DepthFormat::float_tiff) {
    const auto units =
        in_units<float>(image_m, [&](float depth_m) { return float_units_of(depth_m, rig_.depth_scale); });
    return add_image(depth_, timestamp_s, "tiff", [&](const fs::path& file) { return write_tiff(file, units); });
  }
  const auto units =
      in_units<std::uint16_t>(image_m, [&](float depth_m) { return units_of(depth_m, rig_.depth_scale); });
  return add_image(depth_, timestamp_s, "png", [&](const fs::path& file) { return write_png(file, units); });
}

Status RecordingWriter::add_ground_truth(double timestamp_s, const Pose& T_world_color) {
  if (auto ok = check_time(ground_truth_, timestamp_s); !ok) return ok;
  if (!is_rigid(T_world_color)) return fail("the ground truth pose is not a rigid transform");
  return append(ground_truth_, timestamp_s, "timestamp tx ty tz qx qy qz qw (camera to world)",
                trajectory_line(timestamp_s, T_world_color));
}

}  // namespace meshloop
