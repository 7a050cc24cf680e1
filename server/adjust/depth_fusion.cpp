#include "server/adjust/depth_fusion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "server/adjust/depth_grid.h"

namespace meshloop {
namespace {

/// Measurements of one surface lie within so many sigma of each other's median; those of two views, of one another.
constexpr float kSame_sigmas = 3;
/// Cosine of the largest angle between two views of a point.
constexpr double kLeastCosine = 0.906;  // 25 degrees
constexpr float kFarthest_m = 1000;

bool is_depth(float z) {
  return z > 0 && z < kFarthest_m;
}

/// The depth of a view between its pixels.
class Lookup {
 public:
  Lookup(const DepthImage& depth, const Camera& camera)
      : depth_{depth}, step_per_m_{static_cast<float>(adjust::kSteepest * std::hypot(1 / camera.fx, 1 / camera.fy))} {}

  /// Between four pixels of one surface; else the pixel nearest to (u, v). 0 outside, and where nothing is measured.
  [[nodiscard]] float at(float u, float v, float tolerance_m) const {
    if (!(u >= 0 && v >= 0 && u < static_cast<float>(depth_.width() - 1) &&
          v < static_cast<float>(depth_.height() - 1))) {
      return 0;
    }
    const auto x = static_cast<int>(u);
    const auto y = static_cast<int>(v);
    const float* top = &depth_(x, y);
    const float* bottom = top + depth_.width();
    const float fx = u - static_cast<float>(x);
    const float fy = v - static_cast<float>(y);
    const auto [low, high] = std::minmax({top[0], top[1], bottom[0], bottom[1]});
    if (low > 0 && high - low <= tolerance_m + low * step_per_m_) {
      const float above = top[0] + (top[1] - top[0]) * fx;
      const float below = bottom[0] + (bottom[1] - bottom[0]) * fx;
      return above + (below - above) * fy;
    }
    return depth_(static_cast<int>(u + 0.5f), static_cast<int>(v + 0.5f));
  }

 private:
  const DepthImage& depth_;
  float step_per_m_;
};

/// What another view says of a point that the first one measured.
enum class Says { nothing, same, seen_through };

/// A measured depth along the first view's ray, and one divided by its variance.
struct Weighed {
  float z = 0;
  float weight = 0;
};

struct Answer {
  Says says = Says::nothing;
  Weighed depth{};
};

class OtherView {
 public:
  OtherView(const DepthView& view, const Pose& T_world_first, const Camera& camera, const SensorModel& sensor)
      : lookup_{*view.depth, camera}, camera_{camera}, sensor_{sensor} {
    const Pose T_view_first = view.T_camera_world * T_world_first;
    R_ = T_view_first.linear().cast<float>();
    t_ = T_view_first.translation().cast<float>();
    eye_in_first_ = T_view_first.inverse().translation().cast<float>();
  }

  /// ray: of the first view, with z = 1.
  [[nodiscard]] Answer ask(const Eigen::Vector3f& ray, float z) const {
    const Eigen::Vector3f p_first = ray * z;
    const Eigen::Vector3f p = R_ * p_first + t_;
    if (!(p.z() > 0.01f)) return {};
    const float cosine = p_first.normalized().dot((p_first - eye_in_first_).normalized());
    if (!(cosine >= static_cast<float>(kLeastCosine))) return {};
    const auto sigma_m = static_cast<float>(sensor_.sigma_z_m(static_cast<double>(p.z()), 0));
    // Two measurements differ by the noise of both.
    const float tolerance_m = kSame_sigmas * std::sqrt(2.0f) * sigma_m;
    const float u = static_cast<float>(camera_.fx) * p.x() / p.z() + static_cast<float>(camera_.cx);
    const float v = static_cast<float>(camera_.fy) * p.y() / p.z() + static_cast<float>(camera_.cy);
    const float measured = lookup_.at(u, v, tolerance_m);
    if (!is_depth(measured)) return {};
    const float difference = measured - p.z();
    if (difference < -tolerance_m) return {};
    if (difference > tolerance_m) return {Says::seen_through, {}};
    // Along the first view's ray depth grows in this view by R(2, :) * ray a metre.
    const float growth = R_.row(2).dot(ray);
    return {Says::same, {z + difference / growth, growth * growth / (sigma_m * sigma_m)}};
  }

 private:
  Lookup lookup_;
  const Camera& camera_;
  const SensorModel& sensor_;
  Eigen::Matrix3f R_;
  Eigen::Vector3f t_;
  Eigen::Vector3f eye_in_first_;
};

struct Mean {
  float z = 0;
  std::uint8_t count = 0;
};

/// The most likely depth, of those within three sigma of the median.
Mean mean_of(std::span<Weighed> depths, float sigma_m) {
  const auto is_nearer = [](const Weighed& a, const Weighed& b) { return a.z < b.z; };
  std::sort(depths.begin(), depths.end(), is_nearer);
  const float median = depths[depths.size() / 2].z;
  float sum = 0;
  float weights = 0;
  std::uint8_t count = 0;
  for (const auto& [z, weight] : depths) {
    if (std::abs(z - median) > kSame_sigmas * sigma_m) continue;
    sum += weight * (z - median);
    weights += weight;
    ++count;
  }
  return {median + sum / weights, count};
}

Mean fuse_pixel(const std::vector<OtherView>& others, const Eigen::Vector3f& ray, float z, float sigma_m) {
  std::array<Weighed, kMostFusedViews> depths{{{z, 1 / (sigma_m * sigma_m)}}};
  std::size_t count = 1;
  std::size_t seen_through = 0;
  for (const auto& other : others) {
    const Answer answer = other.ask(ray, z);
    if (answer.says == Says::same) depths[count++] = answer.depth;
    if (answer.says == Says::seen_through) ++seen_through;
  }
  if (seen_through > count) return {};
  return mean_of(std::span{depths}.first(count), sigma_m);
}

/// It does not see what is new, or another state of it. Asked about every third pixel.
bool has_no_say(const OtherView& view, const DepthImage& first, const Camera& camera, const Image<std::uint8_t>& mask) {
  constexpr int kEvery_px = 3;
  if (mask.empty()) return false;
  int asked = 0;
  int same = 0;
  int seen_through = 0;
  for (int y = 0; y < first.height(); y += kEvery_px) {
    for (int x = 0; x < first.width(); x += kEvery_px) {
      if (mask(x, y) < 2 || !is_depth(first(x, y))) continue;
      ++asked;
      const Answer answer = view.ask(camera.back_project(x, y, 1).cast<float>(), first(x, y));
      same += answer.says == Says::same ? 1 : 0;
      seen_through += answer.says == Says::seen_through ? 1 : 0;
    }
  }
  return asked > 0 && seen_through >= same;
}

}  // namespace

Image<std::uint8_t> fused_pixels(const RegionMap& regions) {
  constexpr int kBeside_px = 2;  // smoothing looks as far
  Image<std::uint8_t> pixels{regions.ids.width(), regions.ids.height()};
  for (const auto& region : regions.regions) {
    if (!region.confirmed || region.kind != ChangeKind::insertion) continue;
    const auto window = adjust::window_of(regions.ids, region.id);
    for (int y = std::max(window.y0 - kBeside_px, 0); y < std::min(window.y1 + kBeside_px, pixels.height()); ++y) {
      for (int x = std::max(window.x0 - kBeside_px, 0); x < std::min(window.x1 + kBeside_px, pixels.width()); ++x) {
        const bool is_new = regions.ids(x, y) == region.id;
        pixels(x, y) = std::max(pixels(x, y), static_cast<std::uint8_t>(is_new ? 2 : 1));
      }
    }
  }
  return pixels;
}

FusedDepth fuse_depth(std::span<const DepthView> views, const Camera& camera, const SensorModel& sensor,
                      const Image<std::uint8_t>& mask) {
  const DepthImage& first = *views.front().depth;
  FusedDepth fused{first, Image<std::uint8_t>{first.width(), first.height()}, 1};
  const Pose T_world_first = views.front().T_camera_world.inverse();
  std::vector<OtherView> others;
  for (const auto& view : views.subspan(1, std::min(views.size(), kMostFusedViews) - 1)) {
    OtherView other{view, T_world_first, camera, sensor};
    if (!has_no_say(other, first, camera, mask)) others.push_back(std::move(other));
  }
  fused.views = others.size() + 1;
  for (int y = 0; y < first.height(); ++y) {
    for (int x = 0; x < first.width(); ++x) {
      const float z = first(x, y);
      if (!is_depth(z)) continue;
      Mean mean{z, 1};
      if (mask.empty() || mask(x, y) != 0) {
        const Eigen::Vector3f ray = camera.back_project(x, y, 1).cast<float>();
        mean = fuse_pixel(others, ray, z, static_cast<float>(sensor.sigma_z_m(static_cast<double>(z), 0)));
      }
      fused.depth(x, y) = mean.z;
      fused.measurements(x, y) = mean.count;
    }
  }
  return fused;
}

}  // namespace meshloop
