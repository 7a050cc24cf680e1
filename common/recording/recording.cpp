#include "common/recording/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "common/base/file.h"
#include "common/image/image_file.h"
#include "common/recording/text_lines.h"

namespace meshloop {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargestList = 256u << 20;
constexpr double kMaxColorDelay_s = 0.1;

bool stays_inside(const fs::path& path) {
  return path.is_relative() &&
         std::none_of(path.begin(), path.end(), [](const fs::path& part) { return part == ".."; });
}

Result<RecordedImage> parse_line(std::string_view line) {
  const auto timestamp_s = number_of(take_word(line));
  if (!timestamp_s) return fail("must begin with a timestamp in seconds");
  if (line.empty()) return fail("names no file");
  const fs::path file{line};
  if (!stays_inside(file)) return fail(fmt::format("the path '{:.200}' must not leave the recording's folder", line));
  return RecordedImage{*timestamp_s, file};
}

Result<std::vector<RecordedImage>> read_list(const fs::path& file) {
  const auto text = read_text_file(file, kLargestList);
  if (!text) return fail(text.error());
  std::vector<RecordedImage> images;
  for (const auto& line : lines_of(*text)) {
    const auto where = fmt::format("'{}', line {}", file.string(), line.number);
    auto image = parse_line(line.text);
    if (!image) return fail(where, image.error());
    if (!images.empty() && image->timestamp_s <= images.back().timestamp_s) {
      return fail(where + ": the timestamps must grow");
    }
    images.push_back(std::move(*image));
  }
  if (images.empty()) return fail(fmt::format("'{}' lists no image", file.string()));
  return images;
}

// The list is in the order of time and not empty.
const RecordedImage& nearest_in_time(const std::vector<RecordedImage>& images, double timestamp_s) {
  const auto after = std::lower_bound(images.begin(), images.end(), timestamp_s,
                                      [](const RecordedImage& image, double time) { return image.timestamp_s < time; });
  if (after == images.begin()) return *after;
  const auto before = std::prev(after);
  if (after == images.end()) return *before;
  return timestamp_s - before->timestamp_s <= after->timestamp_s - timestamp_s ? *before : *after;
}

template <class T>
Status check_size(const fs::path& file, const Image<T>& image, const Camera& camera, const char* name) {
  if (image.width() == camera.width && image.height() == camera.height) return {};
  return fail(fmt::format("'{}' has {}x{} pixels, but the rig's {} camera has {}x{}", file.string(), image.width(),
                          image.height(), name, camera.width, camera.height));
}

Status check_index(int index, const std::vector<RecordedImage>& images, const char* name) {
  if (index >= 0 && static_cast<std::size_t>(index) < images.size()) return {};
  if (images.empty()) return fail(fmt::format("the recording has no {} images", name));
  return fail(fmt::format("there is no {} image {}; they are numbered from 0 to {}", name, index, images.size() - 1),
              ErrorKind::usage);
}

bool is_there(const fs::path& file) {
  std::error_code ignored;
  return fs::exists(file, ignored);
}

}  // namespace

Result<Recording> Recording::open(const fs::path& folder) {
  return open(folder, folder / "rig.yaml");
}

Result<Recording> Recording::open(const fs::path& folder, const fs::path& rig_file) {
  if (!is_there(folder)) return fail(fmt::format("there is no recording '{}'", folder.string()));
  auto rig = read_rig(rig_file);
  if (!rig) return fail(rig.error());
  auto color = read_list(folder / "rgb.txt");
  if (!color) return fail(color.error());
  Recording recording;
  recording.folder_ = folder;
  recording.rig_ = std::move(*rig);
  recording.color_ = std::move(*color);
  if (is_there(folder / "depth.txt")) {
    auto depth = read_list(folder / "depth.txt");
    if (!depth) return fail(depth.error());
    recording.depth_ = std::move(*depth);
  }
  if (is_there(folder / "groundtruth.txt")) {
    auto ground_truth = read_trajectory(folder / "groundtruth.txt");
    if (!ground_truth) return fail(ground_truth.error());
    recording.ground_truth_ = std::move(*ground_truth);
  }
  return recording;
}

Result<ColorImage> Recording::read_color_file(const RecordedImage& image) const {
  auto color = read_color_image(folder_ / image.file);
  if (!color) return fail(color.error());
  if (auto ok = check_size(image.file, *color, rig_.color, "color"); !ok) return fail(ok.error());
  return color;
}

Result<DepthImage> Recording::read_depth_file(const RecordedImage& image) const {
  auto depth = read_depth_units(folder_ / image.file);
  if (!depth) return fail(depth.error());
  if (auto ok = check_size(image.file, *depth, rig_.depth, "depth"); !ok) return fail(ok.error());
  for (float& z : depth->pixels()) z = std::isfinite(z) && z > 0 ? static_cast<float>(z * rig_.depth_scale) : 0.0F;
  return depth;
}

Result<RgbdFrame> Recording::read_frame(int index) const {
  if (auto ok = check_index(index, depth_, "depth"); !ok) return fail(ok.error());
  const auto& depth_file = depth_[static_cast<std::size_t>(index)];
  const auto& color_file = nearest_in_time(color_, depth_file.timestamp_s);
  const double delay_s = std::abs(color_file.timestamp_s - depth_file.timestamp_s);
  if (!(delay_s <= kMaxColorDelay_s)) {
    return fail(fmt::format("frame {}: the nearest colour image is {:.3f} s away from '{}' (at most {} s)", index,
                            delay_s, depth_file.file.string(), kMaxColorDelay_s));
  }
  auto depth = read_depth_file(depth_file);
  if (!depth) return fail(fmt::format("frame {}", index), depth.error());
  auto color = read_color_file(color_file);
  if (!color) return fail(fmt::format("frame {}", index), color.error());
  return RgbdFrame{index, depth_file.timestamp_s, color_file.timestamp_s, std::move(*depth), std::move(*color)};
}

Result<ColorFrame> Recording::read_color(int index) const {
  if (auto ok = check_index(index, color_, "colour"); !ok) return fail(ok.error());
  const auto& file = color_[static_cast<std::size_t>(index)];
  auto color = read_color_file(file);
  if (!color) return fail(fmt::format("frame {}", index), color.error());
  return ColorFrame{index, file.timestamp_s, std::move(*color)};
}

}  // namespace meshloop
