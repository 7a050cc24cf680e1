#include "server/compare/region_tracker.h"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "server/compare/components.h"

namespace meshloop {
namespace {

// A measurement where the model has nothing has no difference to measure it by.
constexpr double kUnmodelledSignificance = 10;
// World boxes are flat where surfaces are, and shake with the noise.
constexpr double kBoxMargin_m = 0.02;
// Of the smaller box; less is another piece of the world.
constexpr double kLeastOverlap = 0.2;
constexpr int kForgetUnconfirmedAfter = 5;
// A region's centre shakes with its outline: a large one must be seen to move by this share of its size.
constexpr double kViewShareOfSize = 0.15;
// A region that moves along with the camera stays this near to where it should be then, as a share of the way.
constexpr double kMovedAlong = 0.25;

// The part of an image's area that RegionOptions::min_pixels is meant for.
double scale_of(const Camera& camera) {
  return camera.width * static_cast<double>(camera.height) / (640.0 * 480.0);
}

struct Sums {
  Region region;
  double difference_m = 0;
  double significance = 0;
  int pixels_with_difference = 0;
};

struct PixelChange {
  int u;
  int v;
  Label label;
  /// Of the thing that came or went.
  double depth_m;
  double difference_m;
  double sigma_m;
};

void add_pixel(Sums& sums, const PixelChange& pixel, const Camera& camera, const Pose& T_world_camera) {
  Region& region = sums.region;
  region.kind = kind_of(pixel.label);
  ++region.pixels;
  region.area_m2 += pixel.depth_m * pixel.depth_m / (camera.fx * camera.fy);
  region.pixel_box.extend(Eigen::Vector2i(pixel.u, pixel.v));
  const Eigen::Vector3d p_world = T_world_camera * camera.back_project(pixel.u, pixel.v, pixel.depth_m);
  region.world_box.extend(p_world);
  region.centre_m += p_world;
  if (!std::isfinite(pixel.difference_m)) {  // nothing was expected there
    sums.significance += kUnmodelledSignificance;
    return;
  }
  ++sums.pixels_with_difference;
  sums.difference_m += pixel.difference_m;
  sums.significance += std::abs(pixel.difference_m) / pixel.sigma_m;
  if (std::abs(pixel.difference_m) > std::abs(region.max_difference_m)) region.max_difference_m = pixel.difference_m;
}

Region finish(Sums& sums) {
  Region& region = sums.region;
  if (sums.pixels_with_difference > 0) region.mean_difference_m = sums.difference_m / sums.pixels_with_difference;
  region.significance = sums.significance / std::max(region.pixels, 1);
  region.centre_m /= std::max(region.pixels, 1);
  return region;
}

std::vector<Region> measure_components(const Components& components, const Comparison& comparison,
                                       const DepthImage& measured, const Camera& camera, const Pose& T_camera_world,
                                       double sigmas_per_threshold) {
  std::vector<Sums> sums(components.count);
  const Pose T_world_camera = T_camera_world.inverse();
  const auto width = static_cast<std::size_t>(measured.width());
  for (const std::size_t pixel : components.pixels) {
    const auto u = static_cast<int>(pixel % width);
    const auto v = static_cast<int>(pixel / width);
    const Label label = comparison.labels(u, v);
    const float depth_m = label == Label::farther ? comparison.expected(u, v) : measured(u, v);
    add_pixel(sums[components.numbers(u, v) - 1],
              {u, v, label, static_cast<double>(depth_m), static_cast<double>(comparison.difference_m(u, v)),
               static_cast<double>(comparison.threshold_m(u, v)) / sigmas_per_threshold},
              camera, T_world_camera);
  }
  std::vector<Region> regions;
  for (auto& sum : sums) regions.push_back(finish(sum));
  return regions;
}

double volume(const Eigen::AlignedBox3d& box) {
  return box.isEmpty() ? 0.0 : box.volume();
}

// 0 to 1: how much of the smaller box lies in the other.
double overlap(const Region& a, const Region& b) {
  if (a.kind != b.kind) return 0;
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(kBoxMargin_m);
  const Eigen::AlignedBox3d wide_a{a.world_box.min() - margin, a.world_box.max() + margin};
  const Eigen::AlignedBox3d wide_b{b.world_box.min() - margin, b.world_box.max() + margin};
  return volume(wide_a.intersection(wide_b)) / std::min(volume(wide_a), volume(wide_b));
}

bool is_cut(const Region& region, const Camera& camera) {
  const Eigen::AlignedBox2i& box = region.pixel_box;
  return box.min().minCoeff() <= 1 || box.max().x() >= camera.width - 2 || box.max().y() >= camera.height - 2;
}

struct Match {
  // Among regions that lie in each other, the one of the same size is meant.
  double score;
  std::size_t region;
  std::size_t known;
};

double score_of(const Region& a, const Region& b) {
  const double shared = overlap(a, b);
  if (shared < kLeastOverlap) return 0;
  return shared * std::min(a.area_m2, b.area_m2) / std::max(a.area_m2, b.area_m2);
}

bool same_size(const Comparison& comparison, const DepthImage& measured) {
  const auto fits = [&](const auto& image) {
    return image.width() == measured.width() && image.height() == measured.height();
  };
  return fits(comparison.labels) && fits(comparison.difference_m) && fits(comparison.expected) &&
         fits(comparison.threshold_m);
}

}  // namespace

RegionMap RegionTracker::update(const Comparison& comparison, const DepthImage& measured, const Camera& camera,
                                const Pose& T_camera_world, int frames) {
  if (!same_size(comparison, measured)) return {};
  const Components components = connect_changes(comparison.labels);
  const auto all =
      measure_components(components, comparison, measured, camera, T_camera_world, options_.sigmas_per_threshold);
  const double least_pixels = options_.min_pixels * scale_of(camera);
  std::vector<Region> kept;
  std::vector<std::size_t> kept_at(all.size() + 1, 0);  // by component number: position in `kept` plus 1
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].pixels < least_pixels || all[i].area_m2 < options_.min_area_m2) continue;
    kept.push_back(all[i]);
    kept_at[i + 1] = kept.size();
  }
  recognise(kept, {camera, T_camera_world, frames});
  forget();

  RegionMap map{Image<RegionId>(measured.width(), measured.height()), {}};
  for (const std::size_t pixel : components.pixels) {
    const std::size_t position = kept_at[components.numbers.data()[pixel]];
    if (position != 0) map.ids.data()[pixel] = kept[position - 1].id;
  }
  map.regions = std::move(kept);
  std::sort(map.regions.begin(), map.regions.end(), [](const Region& a, const Region& b) { return a.id < b.id; });
  return map;
}

// The best pairs first; each known region is found again at most once.
void RegionTracker::recognise(std::vector<Region>& regions, const View& view) {
  for (auto& known : known_) ++known.frames_unseen;
  std::vector<Match> matches;
  for (std::size_t r = 0; r < regions.size(); ++r) {
    for (std::size_t k = 0; k < known_.size(); ++k) {
      const double score = score_of(regions[r], known_[k].region);
      if (score > 0) matches.push_back({score, r, k});
    }
  }
  std::sort(matches.begin(), matches.end(), [](const Match& a, const Match& b) {
    return std::tuple(-a.score, a.known, a.region) < std::tuple(-b.score, b.known, b.region);
  });
  for (const auto& match : matches) {
    Region& region = regions[match.region];
    Known& known = known_[match.known];
    if (region.id != 0 || known.frames_unseen == 0) continue;
    region.id = known.region.id;
    region.frames_seen = known.region.frames_seen;
    region.views_seen = known.region.views_seen;
    count_view(region, known, view);
    known.frames_unseen = 0;
  }
  for (auto& region : regions) {
    if (region.id == 0) {
      region.id = next_id_++;
      region.views_seen = 1;
      known_.push_back({region, 0, view.frames, view.T_camera_world, region.centre_m});
    }
    Known& known =
        *std::find_if(known_.begin(), known_.end(), [&](const Known& k) { return k.region.id == region.id; });
    region.frames_seen += view.frames;
    const bool strong = region.significance >= options_.strong_significance * options_.sigmas_per_threshold;
    const int needed_at_rest = strong ? options_.confirm_views : options_.confirm_frames_at_rest;
    region.confirmed =
        known.region.confirmed || region.views_seen >= options_.confirm_views || known.frames_at_rest >= needed_at_rest;
    known.region = region;
  }
}

// What sticks to the camera moves through the world with it; what is in the world does not. The centre of a region that
// is cut by the picture's border moves either way, and tells nothing.
void RegionTracker::count_view(Region& region, Known& known, const View& view) const {
  const Eigen::Vector3d centre_camera = known.T_camera_world * known.centre_world;
  const Eigen::Vector3d carried_along = view.T_camera_world.inverse() * centre_camera;
  const double shift_m = (carried_along - known.centre_world).norm();
  const double needed_px = std::max(options_.new_view_px * view.camera.width / 640.0,
                                    kViewShareOfSize * std::sqrt(static_cast<double>(region.pixels)));
  if (shift_m < needed_px * centre_camera.z() / view.camera.fx || is_cut(region, view.camera)) {
    known.frames_at_rest += view.frames;
    return;
  }
  const bool stays = (region.centre_m - known.centre_world).norm() <= shift_m / 2;
  const bool moved_along = (region.centre_m - carried_along).norm() <= kMovedAlong * shift_m;
  if (!stays && !moved_along) {  // another part of it is seen: the next frames will tell
    known.frames_at_rest += view.frames;
    return;
  }
  region.views_seen = stays ? region.views_seen + 1 : 1;
  if (moved_along) known.frames_at_rest = view.frames;
  known.T_camera_world = view.T_camera_world;
  known.centre_world = region.centre_m;
}

void RegionTracker::forget() {
  std::erase_if(known_, [&](const Known& known) {
    return known.frames_unseen > (known.region.confirmed ? options_.forget_after_frames : kForgetUnconfirmedAfter);
  });
}

void RegionTracker::reset() {
  known_.clear();
}

void settle_labels(Comparison& comparison, const RegionMap& regions) {
  if (regions.ids.size() != comparison.labels.size()) return;
  for (std::size_t i = 0; i < comparison.labels.size(); ++i) {
    Label& label = comparison.labels.pixels()[i];
    if (is_change(label) && regions.ids.pixels()[i] == 0) label = Label::undecided;
  }
}

}  // namespace meshloop
