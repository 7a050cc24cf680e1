#include "device/track/edge_match.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

namespace meshloop {
namespace {

/// A jump of the inverse depth by this share is an outline.
constexpr double kJump = 0.015;
/// A kink of the inverse depth by this share a pixel is a crease.
constexpr double kKink = 4e-4;
/// A side counts as a plane when its own kinks stay below this share of a crease's or of this noise.
constexpr double kPlane = 0.2;
constexpr double kNoise = 3e-5;
/// How far a crease's sides are looked at.
constexpr int kSide = 4;
constexpr int kBorder = kSide + 1;
/// Two steps whose distances differ by less cannot be told apart.
constexpr double kAmbiguous_px = 1.5;
/// Share of the gradient that must lie along the scan line.
constexpr double kAcross = 0.5;

/// Inverse depths along a row or a column.
class ScanLine {
 public:
  ScanLine(const DepthImage& depth, int axis, int position) : depth_{depth}, axis_{axis}, position_{position} {}

  [[nodiscard]] int length() const { return axis_ == 0 ? depth_.width() : depth_.height(); }
  [[nodiscard]] double operator()(int i) const {
    const float z = axis_ == 0 ? depth_(i, position_) : depth_(position_, i);
    return z > 0 ? 1 / static_cast<double>(z) : 0;
  }
  [[nodiscard]] Eigen::Vector2d pixel(double i) const {
    return axis_ == 0 ? Eigen::Vector2d{i, position_} : Eigen::Vector2d{position_, i};
  }

 private:
  const DepthImage& depth_;
  int axis_;
  int position_;
};

struct Crossing {
  double at = 0;
  double inverse_depth = 0;
};

/// The near surface ends after pixel i, towards i + side.
std::optional<Crossing> outline_after(const ScanLine& line, int i, int side) {
  const double w = line(i);
  const double before = line(i - side);
  const double first = line(i - 2 * side);
  if (w <= 0 || before <= 0 || first <= 0) return std::nullopt;
  if (std::abs(w - 2 * before + first) > kKink * w) return std::nullopt;
  const double slope = w - before;
  if (w + slope - line(i + side) < kJump * w) return std::nullopt;
  return Crossing{i + 0.5 * side, w + 0.5 * slope};
}

/// A side from `i` on, away from the crease, is plane.
bool is_plane(const ScanLine& line, int i, int side, double kink) {
  const double first = line(i);
  const double last = line(i + 3 * side);
  if (first <= 0 || last <= 0) return false;
  const double bend = std::abs((line(i + side) - first) - (last - line(i + 2 * side)));
  return bend < std::max(kPlane * std::abs(kink), kNoise * first);
}

std::optional<Crossing> crease_at(const ScanLine& line, int i) {
  const double w = line(i);
  if (w <= 0) return std::nullopt;
  const double slope_before = (line(i - 1) - line(i - kSide)) / (kSide - 1);
  const double slope_after = (line(i + kSide) - line(i + 1)) / (kSide - 1);
  const double kink = slope_after - slope_before;
  if (std::abs(kink) < kKink * w) return std::nullopt;
  if (!is_plane(line, i - 1, -1, kink) || !is_plane(line, i + 1, 1, kink)) return std::nullopt;
  // Where the two sides meet, from pixel i.
  const double meet = (line(i - 1) + slope_before - line(i + 1) + slope_after) / kink;
  if (!(std::abs(meet) <= 0.75)) return std::nullopt;
  return Crossing{i + meet, line(i - 1) + slope_before * (1 + meet)};
}

void scan(const RenderedView& view, int axis, int position, std::vector<ModelEdge>& edges) {
  const ScanLine line{view.depth, axis, position};
  const Pose T_world_camera = view.T_camera_world.inverse();
  const auto add = [&](const Crossing& crossing) {
    const Eigen::Vector2d pixel = line.pixel(crossing.at);
    const Eigen::Vector3d p_camera = view.camera.back_project(pixel.x(), pixel.y(), 1 / crossing.inverse_depth);
    edges.push_back({T_world_camera * p_camera, pixel, axis});
  };
  for (int i = kBorder; i < line.length() - kBorder; ++i) {
    auto crossing = outline_after(line, i, 1);
    if (!crossing) crossing = outline_after(line, i, -1);
    if (!crossing) crossing = crease_at(line, i);
    if (!crossing) continue;
    add(*crossing);
    i += 2;
  }
}

/// The picture along the scan line of an edge.
class Profile {
 public:
  Profile(const GreyImage& image, const ModelEdge& edge) : image_{image}, edge_{edge} {}

  [[nodiscard]] bool inside(double reach_px) const {
    const double along = edge_.pixel(edge_.axis);
    const double across = edge_.pixel(1 - edge_.axis);
    const int length = edge_.axis == 0 ? image_.width() : image_.height();
    const int breadth = edge_.axis == 0 ? image_.height() : image_.width();
    return along >= reach_px + 3 && along < length - 4 - reach_px && across >= 1 && across < breadth - 1;
  }
  /// `offset` along the scan line, `aside` whole lines next to it.
  [[nodiscard]] double value(double offset, int aside) const {
    const double along = edge_.pixel(edge_.axis) + offset;
    const int across = static_cast<int>(edge_.pixel(1 - edge_.axis)) + aside;
    const int i = static_cast<int>(std::floor(along));
    const double share = along - i;
    return (1 - share) * at(i, across) + share * at(i + 1, across);
  }
  [[nodiscard]] double gradient(double offset) const { return (value(offset + 1, 0) - value(offset - 1, 0)) / 2; }
  [[nodiscard]] double gradient_across(double offset) const { return (value(offset, 1) - value(offset, -1)) / 2; }

 private:
  [[nodiscard]] double at(int along, int across) const {
    return edge_.axis == 0 ? image_(along, across) : image_(across, along);
  }
  const GreyImage& image_;
  const ModelEdge& edge_;
};

/// Where the brightness steps, as an offset; the nearest.
std::optional<double> nearest_step(const Profile& profile, const EdgeSearch& search) {
  std::optional<double> nearest;
  double second = search.reach_px + kAmbiguous_px;
  const int reach = static_cast<int>(std::ceil(search.reach_px));
  for (int k = -reach; k <= reach; ++k) {
    const double before = std::abs(profile.gradient(k - 1));
    const double here = std::abs(profile.gradient(k));
    const double after = std::abs(profile.gradient(k + 1));
    if (here < search.min_gradient || here < before || here <= after) continue;
    const double bend = before - 2 * here + after;
    const double step = k + (bend < 0 ? 0.5 * (before - after) / bend : 0.0);
    if (!nearest || std::abs(step) < std::abs(*nearest)) {
      if (nearest) second = std::abs(*nearest);
      nearest = step;
    } else {
      second = std::min(second, std::abs(step));
    }
  }
  if (nearest && (std::abs(*nearest) > search.reach_px || second - std::abs(*nearest) < kAmbiguous_px)) return {};
  return nearest;
}

}  // namespace

std::vector<ModelEdge> find_model_edges(const RenderedView& view, int spacing_px) {
  std::vector<ModelEdge> edges;
  for (int y = kBorder; y < view.depth.height() - kBorder; y += spacing_px) scan(view, 0, y, edges);
  for (int x = kBorder; x < view.depth.width() - kBorder; x += spacing_px) scan(view, 1, x, edges);
  return edges;
}

std::vector<EdgeObservation> match_edges(const std::vector<ModelEdge>& edges, const GreyImage& smooth,
                                         const EdgeSearch& search, double sigma_px) {
  std::vector<EdgeObservation> found;
  for (const auto& edge : edges) {
    const Profile profile{smooth, edge};
    if (!profile.inside(search.reach_px)) continue;
    const auto step = nearest_step(profile, search);
    if (!step) continue;
    Eigen::Vector2d normal;
    normal(edge.axis) = profile.gradient(*step);
    normal(1 - edge.axis) = profile.gradient_across(*step);
    normal.normalize();
    if (!(std::abs(normal(edge.axis)) >= kAcross)) continue;
    Eigen::Vector2d pixel = edge.pixel;
    pixel(edge.axis) += *step;
    found.push_back({edge.p_world, pixel, normal, sigma_px});
  }
  return found;
}

}  // namespace meshloop
