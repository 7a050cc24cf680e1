#include "common/detail/closed_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include "common/base/connected.h"
#include "common/detail/working_cluster.h"

namespace meshloop {
namespace {

/// A triangle's side. The vertices in ascending order.
struct Side {
  std::uint32_t low = 0;
  std::uint32_t high = 0;
  std::uint32_t triangle = 0;
  bool is_upwards = false;

  [[nodiscard]] std::pair<std::uint32_t, std::uint32_t> edge() const { return {low, high}; }
};

/// By edge.
std::vector<Side> sides_of(std::span<const Triangle> triangles) {
  std::vector<Side> sides;
  sides.reserve(3 * triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t from = triangles[t][k];
      const std::uint32_t to = triangles[t][(k + 1) % 3];
      sides.push_back({std::min(from, to), std::max(from, to), t, from < to});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.edge() < b.edge(); });
  return sides;
}

/// By triangle: the number of its part, or kNone where the part has a border.
struct Parts {
  std::vector<std::int32_t> of_triangle;
  std::int32_t count = 0;
};

Parts without_border(std::span<const Triangle> triangles) {
  const std::vector<Side> sides = sides_of(triangles);
  Connected connected{triangles.size()};
  std::vector<std::uint32_t> at_border;
  for (std::size_t first = 0; first < sides.size();) {
    int surplus = 0;
    std::size_t last = first;
    for (; last < sides.size() && sides[last].edge() == sides[first].edge(); ++last) {
      surplus += sides[last].is_upwards ? 1 : -1;
      connected.join(sides[first].triangle, sides[last].triangle);
    }
    if (surplus != 0) at_border.push_back(sides[first].triangle);
    first = last;
  }
  std::vector<bool> is_open(triangles.size(), false);
  for (const auto triangle : at_border) is_open[connected.first_of(triangle)] = true;
  Parts parts;
  parts.of_triangle.assign(triangles.size(), ClosedParts::kNone);
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const std::uint32_t first = connected.first_of(t);
    if (is_open[first]) continue;
    parts.of_triangle[t] = first == t ? parts.count++ : parts.of_triangle[first];
  }
  return parts;
}

/// Of fewer triangles hardly a cluster would ever be left out.
constexpr std::size_t kWorthwhile = 64;

/// Where a line parallel to an axis goes through a triangle.
struct Crossing {
  int line = 0;
  double along = 0;
  /// 1 into the part, -1 out of it.
  int step = 0;
};

/// Lines parallel to one axis, in rows over the box of a part; a little off the middle of their cells, since vertices
/// like to lie there.
class Lines {
 public:
  Lines(const Eigen::AlignedBox3f& box, int axis, int across)
      : across_{across}, along_{axis}, u_{(axis + 1) % 3}, v_{(axis + 2) % 3} {
    const Eigen::Vector3d cell = box.sizes().cast<double>() / across;
    first_ = {static_cast<double>(box.min()[u_]) + kOff * cell[u_],
              static_cast<double>(box.min()[v_]) + kOff * cell[v_]};
    cell_ = {cell[u_], cell[v_]};
  }

  void cross(const std::array<Eigen::Vector3d, 3>& corners, std::vector<Crossing>& crossings) const {
    const auto flat = [&](const Eigen::Vector3d& p) { return Eigen::Vector2d{p[u_], p[v_]}; };
    const Eigen::Vector2d a = flat(corners[0]);
    const Eigen::Vector2d b = flat(corners[1]);
    const Eigen::Vector2d c = flat(corners[2]);
    const double area = turn(a, b, c);
    if (area == 0) return;
    const auto [u_from, u_to] = range(0, std::minmax({a.x(), b.x(), c.x()}));
    const auto [v_from, v_to] = range(1, std::minmax({a.y(), b.y(), c.y()}));
    for (int v = v_from; v < v_to; ++v) {
      for (int u = u_from; u < u_to; ++u) {
        const Eigen::Vector2d p = first_ + Eigen::Vector2d{u, v}.cwiseProduct(cell_);
        const Eigen::Vector3d shares = Eigen::Vector3d{turn(b, c, p), turn(c, a, p), turn(a, b, p)} / area;
        if (!(shares.minCoeff() > 0)) continue;
        const double along = shares.dot(Eigen::Vector3d{corners[0][along_], corners[1][along_], corners[2][along_]});
        crossings.push_back({v * across_ + u, along, area < 0 ? 1 : -1});
      }
    }
  }

 private:
  static constexpr double kOff = 0.4382;

  static double turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
  }
  /// The lines between two places; the last one is not among them.
  [[nodiscard]] std::pair<int, int> range(int side, const std::pair<double, double>& places) const {
    const auto line_at = [&](double place) {
      return std::clamp(static_cast<int>(std::ceil((place - first_[side]) / cell_[side])), 0, across_);
    };
    if (!(cell_[side] > 0)) return {0, 0};
    return {line_at(places.first), line_at(places.second)};
  }

  int across_;
  int along_;
  int u_;
  int v_;
  Eigen::Vector2d first_;
  Eigen::Vector2d cell_;
};

/// Some line goes through, and none goes out more often than it went in. One that ends inside touched an edge and tells
/// nothing.
bool go_in_before_out(std::vector<Crossing>& crossings) {
  std::sort(crossings.begin(), crossings.end(), [](const Crossing& a, const Crossing& b) {
    return std::tuple{a.line, a.along, -a.step} < std::tuple{b.line, b.along, -b.step};
  });
  bool goes_through = false;
  for (std::size_t first = 0; first < crossings.size();) {
    int inside = 0;
    int least = 0;
    std::size_t last = first;
    for (; last < crossings.size() && crossings[last].line == crossings[first].line; ++last) {
      inside += crossings[last].step;
      least = std::min(least, inside);
    }
    if (inside == 0 && least < 0) return false;
    goes_through = goes_through || inside == 0;
    first = last;
  }
  return goes_through;
}

bool faces_outwards(const std::vector<Eigen::Vector3f>& positions, const std::vector<Triangle>& part,
                    const Eigen::AlignedBox3f& box) {
  constexpr double kFewest = 8;
  constexpr double kMost = 48;
  const int across = static_cast<int>(std::clamp(std::sqrt(static_cast<double>(part.size())), kFewest, kMost));
  std::vector<Crossing> crossings;
  for (int axis = 0; axis < 3; ++axis) {
    const Lines lines{box, axis, across};
    crossings.clear();
    for (const auto& [a, b, c] : part) {
      lines.cross({positions[a].cast<double>(), positions[b].cast<double>(), positions[c].cast<double>()}, crossings);
    }
    if (!go_in_before_out(crossings)) return false;
  }
  return true;
}

}  // namespace

ClosedParts closed_parts_of(const std::vector<Eigen::Vector3f>& positions, std::span<const Triangle> triangles) {
  const Parts parts = without_border(triangles);
  std::vector<std::vector<Triangle>> closed(static_cast<std::size_t>(parts.count));
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (parts.of_triangle[t] != ClosedParts::kNone) {
      closed[static_cast<std::size_t>(parts.of_triangle[t])].push_back(triangles[t]);
    }
  }
  ClosedParts result;
  std::vector<std::int32_t> number(closed.size(), ClosedParts::kNone);
  for (std::size_t i = 0; i < closed.size(); ++i) {
    if (closed[i].size() < kWorthwhile) continue;
    const Eigen::AlignedBox3f box = bounds_of(positions, closed[i]);
    if (!faces_outwards(positions, closed[i], box)) continue;
    number[i] = static_cast<std::int32_t>(result.bounds.size());
    result.bounds.push_back(box);
  }
  constexpr std::int32_t kUnknown = -2;
  result.of_vertex.assign(positions.size(), kUnknown);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const std::int32_t part = parts.of_triangle[t];
    const std::int32_t own = part == ClosedParts::kNone ? part : number[static_cast<std::size_t>(part)];
    for (const auto vertex : triangles[t]) {
      auto& known = result.of_vertex[vertex];
      known = known == kUnknown || known == own ? own : ClosedParts::kNone;
    }
  }
  return result;
}

}  // namespace meshloop
