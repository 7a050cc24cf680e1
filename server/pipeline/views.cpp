#include "server/pipeline/views.h"

#include <utility>

#include "common/program/arguments.h"

namespace meshloop {
namespace {

/// Around the corners of a box, in pixels; empty when one lies behind the camera.
Eigen::AlignedBox2i seen_box(const Eigen::AlignedBox3d& box_m, const Pose& T_camera_world, const Camera& camera) {
  constexpr double kNearest_m = 0.05;
  constexpr double kFarthest_px = 1e6;
  Eigen::AlignedBox2d seen;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d p = T_camera_world * box_m.corner(static_cast<Eigen::AlignedBox3d::CornerType>(i));
    if (!(p.z() > kNearest_m)) return {};
    seen.extend(camera.project(p).cwiseMax(-kFarthest_px).cwiseMin(kFarthest_px));
  }
  return {seen.min().array().floor().matrix().cast<int>(), seen.max().array().ceil().matrix().cast<int>()};
}

}  // namespace

void ViewArguments::add_colors_to(CLI::App& command) {
  command
      .add_option("--palette", palette, "colours of the pictures; safe can be told apart with every colour blindness")
      ->check(CLI::IsMember({"paper", "safe"}))
      ->capture_default_str();
  command
      .add_option("--opacity", overlay.opacity_per_m,
                  "opacity of a difference of one metre; at 25 a colour is solid from 40 mm on")
      ->check(between(0.1, 10'000))
      ->capture_default_str();
}

void ViewArguments::add_to(CLI::App& command) {
  add_colors_to(command);
  command.add_option("--views", views, "pictures to write: over colour, over depth, both or none")
      ->check(CLI::IsMember({"color", "depth", "both", "none"}))
      ->capture_default_str();
}

OverlayOptions ViewArguments::options(const std::string& title) const {
  OverlayOptions options = overlay;
  options.palette = palette == "safe" ? Palette::color_blind_safe : Palette::paper;
  options.title = title;
  return options;
}

Views::Views(ColorOverlay color, Rig rig, ViewArguments arguments)
    : color_{std::move(color)}, rig_{std::move(rig)}, arguments_{std::move(arguments)} {}

Result<Views> Views::create(GpuContext& gpu, const Rig& rig, const ViewArguments& arguments) {
  auto color = ColorOverlay::create(gpu);
  if (!color) return fail(color.error());
  return Views{std::move(*color), rig, arguments};
}

Rig Views::rig_at(const TrackedFrame& tracked) const {
  Rig rig = rig_;
  if (tracked.color_pose.state != TrackState::lost && tracked.depth_pose.state != TrackState::lost) {
    rig.T_depth_color = tracked.depth_pose.T_camera_world * tracked.color_pose.T_camera_world.inverse();
  }
  return rig;
}

Result<std::vector<RegionThumbnail>> Views::thumbnails(const TrackedFrame& tracked, const Examination& examination,
                                                       const std::vector<RegionId>& wanted) {
  const auto source = color_.source_of(examination.comparison, tracked.frame.depth, rig_at(tracked));
  if (!source) return fail(source.error());
  return region_thumbnails(*source, examination.comparison, tracked.frame.color, examination.regions, wanted,
                           arguments_.options({}).palette);
}

OverlayOptions Views::options_of(const Examination& examination, const std::string& title) const {
  OverlayOptions options = arguments_.options(title);
  options.smallest_change_m = examination.smallest_change_m.value_or(0);
  return options;
}

Result<ColorImage> Views::on_color(const TrackedFrame& tracked, const Examination& examination,
                                   const std::string& title, const Framing* framing) {
  auto options = options_of(examination, title);
  if (framing != nullptr) {
    options.region_texts = framing->region_texts;
    for (const auto& place : framing->places) {
      const auto box = seen_box(place.box_m, tracked.color_pose.T_camera_world, rig_.color);
      if (!box.isEmpty()) options.frames.push_back({box, place.text});
    }
  }
  return color_.draw(examination.comparison, tracked.frame.depth, tracked.frame.color, rig_at(tracked),
                     framing != nullptr ? &framing->regions : &examination.regions, options);
}

ColorImage Views::on_depth(const TrackedFrame& tracked, const Examination& examination,
                           const std::string& title) const {
  return overlay_on_depth(examination.comparison, tracked.frame.depth, &examination.regions,
                          options_of(examination, title));
}

}  // namespace meshloop
