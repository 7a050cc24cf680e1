#include "server/adjust/cut.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <clipper.hpp>
#include <cmath>
#include <optional>
#include <utility>

#include "common/mesh/lattice.h"
#include "common/mesh/triangulate.h"
#include "server/adjust/places.h"

namespace meshloop::adjust {
namespace {

/// Clipper counts in whole micrometres.
constexpr double kPerMetre = 1e6;
/// Two points of an edge that are nearer to each other than this are one.
constexpr double kSame_m = 5e-5;
/// Clipper rounds: a point this near to an edge is on it.
constexpr double kOnEdge_um = 3;

/// Places, the smaller one first.
using Edge = std::pair<std::uint32_t, std::uint32_t>;
struct EdgePoint {
  /// Metres from the edge's first place.
  double along_m = 0;
  std::uint32_t vertex = 0;
};

/// The plane of a triangle: the first corner is its origin, and it is counter-clockwise.
class TrianglePlane {
 public:
  explicit TrianglePlane(const std::array<Eigen::Vector3d, 3>& corners) : origin_{corners[0]} {
    along_ = (corners[1] - corners[0]).normalized();
    const Eigen::Vector3d normal = along_.cross(corners[2] - corners[0]).normalized();
    across_ = normal.cross(along_);
  }
  [[nodiscard]] ClipperLib::IntPoint in_plane(const Eigen::Vector3d& p) const {
    const Eigen::Vector3d from = (p - origin_) * kPerMetre;
    return {std::llround(from.dot(along_)), std::llround(from.dot(across_))};
  }
  [[nodiscard]] Eigen::Vector3d in_space(const ClipperLib::IntPoint& p) const {
    return origin_ + (static_cast<double>(p.X) * along_ + static_cast<double>(p.Y) * across_) / kPerMetre;
  }

 private:
  Eigen::Vector3d origin_;
  Eigen::Vector3d along_;
  Eigen::Vector3d across_;
};

/// What is left of a triangle: an outer ring and the holes in it, as Clipper has them.
using Piece = std::vector<ClipperLib::Path>;

void collect(const ClipperLib::PolyNode& outer, std::vector<Piece>& pieces) {
  if (!ClipperLib::Orientation(outer.Contour)) return;
  Piece& piece = pieces.emplace_back();
  piece.push_back(outer.Contour);
  const std::size_t here = pieces.size() - 1;
  for (const auto* hole : outer.Childs) {
    pieces[here].push_back(hole->Contour);
    for (const auto* inner : hole->Childs) collect(*inner, pieces);
  }
}

bool is_a_corner(const ClipperLib::IntPoint& point, const ClipperLib::Path& triangle) {
  return std::find(triangle.begin(), triangle.end(), point) != triangle.end();
}

/// Nothing when the lines leave the triangle as it is, or Clipper cannot tell.
std::optional<std::vector<Piece>> difference(const ClipperLib::Path& triangle, const ClipperLib::Paths& lines) {
  ClipperLib::Clipper clipper{ClipperLib::ioStrictlySimple};
  clipper.AddPath(triangle, ClipperLib::ptSubject, true);
  clipper.AddPaths(lines, ClipperLib::ptClip, true);
  ClipperLib::PolyTree tree;
  if (!clipper.Execute(ClipperLib::ctDifference, tree, ClipperLib::pftNonZero, ClipperLib::pftNonZero)) {
    return std::nullopt;
  }
  std::vector<Piece> pieces;
  for (const auto* outer : tree.Childs) collect(*outer, pieces);
  const bool is_whole =
      pieces.size() == 1 && pieces[0].size() == 1 && pieces[0][0].size() == 3 &&
      std::all_of(pieces[0][0].begin(), pieces[0][0].end(), [&](const auto& p) { return is_a_corner(p, triangle); });
  if (is_whole) return std::nullopt;
  return pieces;
}

class Cutter {
 public:
  Cutter(const Submesh& submesh, const Removal& removal)
      : submesh_{submesh}, removal_{removal}, places_{places_of(submesh.positions)} {
    result_.submesh.positions = submesh.positions;
    result_.submesh.colors = submesh.colors;
    result_.submesh.texture = submesh.texture;
  }

  CutSubmesh run() {
    for (const auto& [t, lines] : removal_.cuts) {
      if (!removal_.triangles[t]) cut_triangle(t, lines);
    }
    std::vector<Triangle> filling;
    for (std::uint32_t t = 0; t < submesh_.triangles.size(); ++t) {
      if (removal_.triangles[t]) {
        ++result_.taken;
      } else if (is_untouched(t)) {
        result_.submesh.triangles.push_back(submesh_.triangles[t]);
      } else {
        ++result_.taken;
        fill(t, filling);
      }
    }
    // Vertices that fell together leave triangles without area.
    std::erase_if(filling, [&](const Triangle& triangle) { return !has_area(result_.submesh, triangle); });
    result_.added = filling.size();
    auto& triangles = result_.submesh.triangles;
    triangles.insert(triangles.end(), filling.begin(), filling.end());
    const std::vector<bool> all(triangles.size(), true);
    result_.submesh = keep_triangles(std::move(result_.submesh), all);
    return std::move(result_);
  }

 private:
  [[nodiscard]] Eigen::Vector3d position(std::uint32_t vertex) const {
    return result_.submesh.positions[vertex].cast<double>();
  }
  [[nodiscard]] std::array<Eigen::Vector3d, 3> corners_of(std::uint32_t t) const {
    const auto& [a, b, c] = submesh_.triangles[t];
    return {position(a), position(b), position(c)};
  }
  [[nodiscard]] Edge edge_of(std::uint32_t t, std::size_t side) const {
    const Triangle& triangle = submesh_.triangles[t];
    return std::minmax(places_[triangle[side]], places_[triangle[(side + 1) % 3]]);
  }
  void cut_triangle(std::uint32_t t, const std::vector<PlaneLine>& lines) {
    if (!has_area(submesh_, submesh_.triangles[t])) return;
    const auto corners = corners_of(t);
    const TrianglePlane plane{corners};
    ClipperLib::Path outline;
    for (const auto& corner : corners) outline.push_back(plane.in_plane(corner));
    ClipperLib::Paths paths;
    for (const auto& line : lines) {
      if (!std::all_of(line.begin(), line.end(), [](const auto& p) { return p.allFinite(); })) continue;
      auto& path = paths.emplace_back();
      for (const auto& p : line) path.push_back(plane.in_plane(p));
    }
    const auto pieces = difference(outline, paths);
    if (!pieces) return;
    auto& rings = pieces_[t];
    for (const auto& piece : *pieces) {
      std::vector<FlatRing> of_piece;
      for (const auto& path : piece) of_piece.push_back(ring_of(t, path, plane, outline));
      rings.push_back(std::move(of_piece));
    }
  }

  /// What falls together on the lattice is one vertex, still at two points of the plane.
  FlatRing ring_of(std::uint32_t t, const ClipperLib::Path& path, const TrianglePlane& plane,
                   const ClipperLib::Path& outline) {
    FlatRing ring;
    for (const auto& point : path) {
      ring.corners.push_back(vertex_at(t, plane.in_space(point), sides_of(point, outline)));
      ring.points.emplace_back(static_cast<double>(point.X), static_cast<double>(point.Y));
    }
    return ring;
  }

  /// The sides of the triangle on which a point lies.
  static std::vector<std::size_t> sides_of(const ClipperLib::IntPoint& point, const ClipperLib::Path& outline) {
    std::vector<std::size_t> sides;
    for (std::size_t side = 0; side < 3; ++side) {
      const auto& a = outline[side];
      const auto& b = outline[(side + 1) % 3];
      const Eigen::Vector2d edge{static_cast<double>(b.X - a.X), static_cast<double>(b.Y - a.Y)};
      const Eigen::Vector2d from{static_cast<double>(point.X - a.X), static_cast<double>(point.Y - a.Y)};
      if (std::abs(edge.x() * from.y() - edge.y() * from.x()) <= kOnEdge_um * edge.norm()) sides.push_back(side);
    }
    return sides;
  }

  std::uint32_t vertex_at(std::uint32_t t, const Eigen::Vector3d& p, const std::vector<std::size_t>& sides) {
    const Triangle& triangle = submesh_.triangles[t];
    const Eigen::Vector3f snapped = on_lattice(p.cast<float>());
    for (const auto corner : triangle) {
      if ((position(corner) - p).norm() < kSame_m || submesh_.positions[corner] == snapped) return corner;
    }
    std::optional<std::uint32_t> vertex;
    for (const auto side : sides) {
      if (!vertex) vertex = known_on(t, side, p);
    }
    if (!vertex) vertex = add_vertex(t, snapped);
    for (const auto side : sides) {
      if (!known_on(t, side, p)) edge_points_[edge_of(t, side)].push_back({along(t, side, p), *vertex});
    }
    return *vertex;
  }

  /// The vertex that lies there on the edge already.
  [[nodiscard]] std::optional<std::uint32_t> known_on(std::uint32_t t, std::size_t side,
                                                      const Eigen::Vector3d& p) const {
    const auto points = edge_points_.find(edge_of(t, side));
    if (points == edge_points_.end()) return std::nullopt;
    const double along_m = along(t, side, p);
    for (const auto& point : points->second) {
      if (std::abs(point.along_m - along_m) < kSame_m) return point.vertex;
    }
    return std::nullopt;
  }

  /// Metres from the edge's first place; both triangles at an edge give the same.
  [[nodiscard]] double along(std::uint32_t t, std::size_t side, const Eigen::Vector3d& p) const {
    const Triangle& triangle = submesh_.triangles[t];
    const Edge edge = edge_of(t, side);
    const std::uint32_t first = places_[triangle[side]] == edge.first ? triangle[side] : triangle[(side + 1) % 3];
    return (p - position(first)).norm();
  }

  std::uint32_t add_vertex(std::uint32_t t, const Eigen::Vector3f& p) {
    const std::array<float, 3> key{p.x(), p.y(), p.z()};
    const auto next = static_cast<std::uint32_t>(result_.submesh.positions.size());
    const auto [entry, is_new] = added_.emplace(key, next);
    if (!is_new) return entry->second;
    result_.submesh.positions.push_back(p);
    if (submesh_.has_colors()) result_.submesh.colors.push_back(color_at(t, p.cast<double>()));
    return next;
  }

  [[nodiscard]] Rgb8 color_at(std::uint32_t t, const Eigen::Vector3d& p) const {
    const Triangle& triangle = submesh_.triangles[t];
    const auto q = corners_of(t);
    const Eigen::Vector3d normal = (q[1] - q[0]).cross(q[2] - q[0]);
    std::array<double, 3> shares{};
    for (std::size_t k = 0; k < 3; ++k) {
      const Eigen::Vector3d opposite = (q[(k + 1) % 3] - p).cross(q[(k + 2) % 3] - p);
      shares[k] = std::max(opposite.dot(normal), 0.0);
    }
    const double sum = shares[0] + shares[1] + shares[2];
    std::array<double, 3> rgb{};
    int all_levels = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double share = sum > 0 ? shares[k] / sum : 1.0 / 3;
      const Rgb8& color = submesh_.colors[triangle[k]];
      rgb[0] += share * color.r;
      rgb[1] += share * color.g;
      rgb[2] += share * color.b;
      all_levels |= color.r | color.g | color.b;
    }
    // Colours in coarse steps stay in them.
    const int step = all_levels % kCoarseColorStep == 0 ? kCoarseColorStep : 1;
    const auto level = [&](double value) {
      const auto steps = static_cast<int>(std::lround(value / step));
      return static_cast<std::uint8_t>(std::min(steps * step, 256 - step));
    };
    return {level(rgb[0]), level(rgb[1]), level(rgb[2])};
  }

  [[nodiscard]] bool is_untouched(std::uint32_t t) const {
    if (pieces_.contains(t)) return false;
    for (std::size_t side = 0; side < 3 && !edge_points_.empty(); ++side) {
      if (edge_points_.contains(edge_of(t, side))) return false;
    }
    return true;
  }

  void fill(std::uint32_t t, std::vector<Triangle>& filling) {
    const auto found = pieces_.find(t);
    const auto pieces = found != pieces_.end() ? found->second : std::vector<std::vector<FlatRing>>{{whole(t)}};
    for (const auto& piece : pieces) {
      std::vector<FlatRing> rings;
      for (const auto& ring : piece) rings.push_back(with_edge_points(t, ring));
      append_flat_polygon(std::move(rings), filling);
    }
  }

  [[nodiscard]] FlatRing whole(std::uint32_t t) const {
    const TrianglePlane plane{corners_of(t)};
    FlatRing ring;
    for (const auto vertex : submesh_.triangles[t]) {
      const auto point = plane.in_plane(position(vertex));
      ring.corners.push_back(vertex);
      ring.points.emplace_back(static_cast<double>(point.X), static_cast<double>(point.Y));
    }
    return ring;
  }

  /// Where a vertex lies on a side, in metres from the edge's first place.
  [[nodiscard]] std::optional<double> place_on(std::uint32_t t, std::size_t side, std::uint32_t vertex) const {
    const Triangle& triangle = submesh_.triangles[t];
    if (vertex == triangle[side] || vertex == triangle[(side + 1) % 3]) return along(t, side, position(vertex));
    const auto points = edge_points_.find(edge_of(t, side));
    if (points == edge_points_.end()) return std::nullopt;
    const auto known = std::find_if(points->second.begin(), points->second.end(),
                                    [&](const EdgePoint& point) { return point.vertex == vertex; });
    if (known == points->second.end()) return std::nullopt;
    return known->along_m;
  }

  /// The neighbours' points on the triangle's sides belong to its rings too.
  [[nodiscard]] FlatRing with_edge_points(std::uint32_t t, const FlatRing& ring) const {
    FlatRing complete;
    for (std::size_t i = 0; i < ring.corners.size(); ++i) {
      complete.corners.push_back(ring.corners[i]);
      complete.points.push_back(ring.points[i]);
      const std::size_t next = (i + 1) % ring.corners.size();
      for (std::size_t side = 0; side < 3; ++side) {
        const auto from = place_on(t, side, ring.corners[i]);
        const auto to = place_on(t, side, ring.corners[next]);
        if (!from || !to) continue;
        for (const auto& point : between(edge_of(t, side), *from, *to)) {
          const double share = (point.along_m - *from) / (*to - *from);
          complete.corners.push_back(point.vertex);
          complete.points.emplace_back(ring.points[i] + share * (ring.points[next] - ring.points[i]));
        }
      }
    }
    return complete;
  }

  [[nodiscard]] std::vector<EdgePoint> between(const Edge& edge, double from_m, double to_m) const {
    std::vector<EdgePoint> found;
    const auto points = edge_points_.find(edge);
    if (points == edge_points_.end()) return found;
    for (const auto& point : points->second) {
      if (point.along_m > std::min(from_m, to_m) && point.along_m < std::max(from_m, to_m)) found.push_back(point);
    }
    std::sort(found.begin(), found.end(), [&](const EdgePoint& a, const EdgePoint& b) {
      return from_m < to_m ? a.along_m < b.along_m : a.along_m > b.along_m;
    });
    return found;
  }

  const Submesh& submesh_;
  const Removal& removal_;
  std::vector<std::uint32_t> places_;
  CutSubmesh result_;
  std::map<std::array<float, 3>, std::uint32_t> added_;
  std::map<Edge, std::vector<EdgePoint>> edge_points_;
  /// By triangle that was cut: its pieces, each an outer ring and its holes. None: nothing is left of it.
  std::map<std::uint32_t, std::vector<std::vector<FlatRing>>> pieces_;
};

}  // namespace

CutSubmesh cut(const Submesh& submesh, const Removal& removal) {
  if (!removal.cuts.empty()) return Cutter{submesh, removal}.run();
  std::vector<bool> keep = removal.triangles;
  keep.flip();
  const auto taken = static_cast<std::size_t>(std::count(keep.begin(), keep.end(), false));
  return {keep_triangles(submesh, keep), taken, 0};
}

}  // namespace meshloop::adjust
