#include "server/adjust/straight_lines.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>

#include "server/adjust/outline.h"

namespace meshloop::adjust {
namespace {

constexpr double kOntoCrease_px = 1;
constexpr double kOntoCorner_px = 1.5;
constexpr double kOntoModel_px = 10;
/// Borders are as ragged as so many times the noise across the picture.
constexpr double kRagged = 3;
/// Two planes that part by less than this share of their depth from one pixel to the next meet in no certain line.
constexpr double kLeastBend = 1e-4;

PicturePlane difference(const PicturePlane& a, const PicturePlane& b) {
  return {a.per_column - b.per_column, a.per_row - b.per_row, a.at_corner - b.at_corner};
}

bool is_certain(const PicturePlane& bend, double inverse_z) {
  return std::hypot(bend.per_column, bend.per_row) > kLeastBend * inverse_z;
}

/// Where three planes meet.
std::optional<Eigen::Vector2d> corner_of(const PicturePlane& a, const PicturePlane& b, const PicturePlane& c) {
  const PicturePlane ab = difference(a, b);
  const PicturePlane ac = difference(a, c);
  const Eigen::Matrix2d M{{ab.per_column, ab.per_row}, {ac.per_column, ac.per_row}};
  const Eigen::Vector2d p = M.inverse() * Eigen::Vector2d{-ab.at_corner, -ac.at_corner};
  return p.allFinite() ? std::optional{p} : std::nullopt;
}

class LineFinder {
 public:
  LineFinder(const DepthGrid& grid, const FlatParts& parts, const Comparison& comparison)
      : grid_{grid},
        parts_{parts},
        comparison_{comparison},
        width_{grid.window.width()},
        height_{grid.window.height()},
        vertices_{std::vector<Eigen::Vector3f>(grid.z.size(), Eigen::Vector3f::Zero()),
                  std::vector<std::uint16_t>(grid.z.size(), 0)} {}

  VertexPlaces find() {
    for_each_pixel([&](int x, int y) {
      const auto own = plane_at(x, y);
      if (own != 0) onto_crease(x, y, own);
    });
    onto_corners();
    for_each_pixel([&](int x, int y) {
      if (grid_.role[pixel(x, y)] == Role::model_rim) onto_model(x, y);
    });
    return std::move(vertices_);
  }

 private:
  [[nodiscard]] std::size_t pixel(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  [[nodiscard]] std::uint16_t plane_at(int x, int y) const {
    if (x < 0 || y < 0 || x >= width_ || y >= height_) return 0;
    return parts_.plane_of_pixel[pixel(x, y)];
  }
  [[nodiscard]] const PicturePlane& plane(std::uint16_t number) const { return parts_.planes[number - 1u]; }
  template <typename Visit>
  void for_each_pixel(const Visit& visit) const {
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x) visit(x, y);
    }
  }

  void place(std::size_t i, const Eigen::Vector2d& at, const PicturePlane& on, std::uint16_t line) {
    const float z = on.depth(at.x(), at.y());
    if (!(z > 0)) return;
    vertices_.places[i] = {static_cast<float>(at.x()), static_cast<float>(at.y()), z};
    vertices_.lines[i] = line;
  }
  /// One number for each pair of planes; 0 stands for the model's.
  std::uint16_t line_between(std::uint16_t a, std::uint16_t b) {
    const std::pair<std::uint16_t, std::uint16_t> key{std::min(a, b), std::max(a, b)};
    if (const auto known = line_numbers_.find(key); known != line_numbers_.end()) return known->second;
    const auto next = static_cast<std::uint16_t>(line_numbers_.size() + 1);
    if (next == kCornerOfLines) return 0;
    return line_numbers_[key] = next;
  }

  /// Of two planes that meet, one gives the pixels: along the axis across which the line runs, the pixel next to it.
  void onto_crease(int x, int y, std::uint16_t own) {
    for (const Eigen::Vector2i& step : {Eigen::Vector2i{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
      const auto other = plane_at(x + step.x(), y + step.y());
      if (other <= own) continue;  // also 0: none
      const PicturePlane bend = difference(plane(own), plane(other));
      const bool along_row = std::abs(bend.per_column) >= std::abs(bend.per_row);
      if (along_row != (step.y() == 0)) continue;
      if (!is_certain(bend, plane(own).at(x, y))) continue;
      const double shift = -bend.at(x, y) / (along_row ? bend.per_column : bend.per_row);
      if (!(std::abs(shift) <= kOntoCrease_px)) continue;
      const Eigen::Vector2d at{along_row ? x + shift : x, along_row ? y : y + shift};
      place(pixel(x, y), at, plane(own), line_between(own, other));
      near_crease_.push_back({x, y, own, other});
      return;
    }
  }

  /// The nearest pixel of those beside a line that has a third plane within two pixels.
  void onto_corners() {
    std::map<std::array<std::uint16_t, 3>, std::pair<double, std::size_t>> nearest;
    for (const auto& [x, y, own, other] : near_crease_) {
      for (int ny = y - 2; ny <= y + 2; ++ny) {
        for (int nx = x - 2; nx <= x + 2; ++nx) {
          const auto third = plane_at(nx, ny);
          if (third == 0 || third == own || third == other) continue;
          const auto corner = corner_of(plane(own), plane(other), plane(third));
          if (!corner) continue;
          const double distance = (*corner - Eigen::Vector2d{x, y}).norm();
          if (distance > kOntoCorner_px) continue;
          std::array<std::uint16_t, 3> key{own, other, third};
          std::sort(key.begin(), key.end());
          const auto [entry, is_new] = nearest.try_emplace(key, distance, pixel(x, y));
          if (!is_new && distance < entry->second.first) entry->second = {distance, pixel(x, y)};
        }
      }
    }
    for (const auto& [planes, found] : nearest) {
      const auto corner = corner_of(plane(planes[0]), plane(planes[1]), plane(planes[2]));
      place(found.second, *corner, plane(planes[0]), kCornerOfLines);
    }
  }

  /// The model's surface at a pixel as a plane; nothing where it bends or ends.
  [[nodiscard]] std::optional<PicturePlane> model_plane(int x, int y) const {
    const int u = x + grid_.window.x0;
    const int v = y + grid_.window.y0;
    const auto& expected = comparison_.expected;
    if (u < 1 || v < 1 || u + 1 >= expected.width() || v + 1 >= expected.height()) return std::nullopt;
    const auto inverse = [&](int du, int dv) { return 1 / static_cast<double>(expected(u + du, v + dv)); };
    const double here = inverse(0, 0);
    const PicturePlane slope{(inverse(1, 0) - inverse(-1, 0)) / 2, (inverse(0, 1) - inverse(0, -1)) / 2, 0};
    const double bend =
        std::abs(inverse(1, 0) + inverse(-1, 0) - 2 * here) + std::abs(inverse(0, 1) + inverse(0, -1) - 2 * here);
    if (!(bend < kLeastBend * here)) return std::nullopt;
    return PicturePlane{slope.per_column, slope.per_row, here - slope.at(x, y)};
  }

  [[nodiscard]] std::uint16_t plane_beside(int x, int y) const {
    std::map<std::uint16_t, int> votes;
    for (int ny = y - 1; ny <= y + 1; ++ny) {
      for (int nx = x - 1; nx <= x + 1; ++nx) ++votes[plane_at(nx, ny)];
    }
    votes.erase(0);
    const auto most =
        std::max_element(votes.begin(), votes.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
    return most == votes.end() ? std::uint16_t{0} : most->first;
  }

  void onto_model(int x, int y) {
    const auto beside = plane_beside(x, y);
    if (beside == 0) return;
    const auto model = model_plane(x, y);
    if (!model) return;
    const PicturePlane bend = difference(plane(beside), *model);
    if (!is_certain(bend, model->at(x, y))) return;
    const Eigen::Vector2d gradient{bend.per_column, bend.per_row};
    const Eigen::Vector2d at = Eigen::Vector2d{x, y} - bend.at(x, y) / gradient.squaredNorm() * gradient;
    if (!((at - Eigen::Vector2d{x, y}).norm() <= kOntoModel_px) || !is_same_model(at, *model)) return;
    place(pixel(x, y), at, *model, line_between(0, beside));
  }
  /// The model still is that plane at the pixel.
  [[nodiscard]] bool is_same_model(const Eigen::Vector2d& at, const PicturePlane& model) const {
    const int u = static_cast<int>(std::lround(at.x())) + grid_.window.x0;
    const int v = static_cast<int>(std::lround(at.y())) + grid_.window.y0;
    const auto& expected = comparison_.expected;
    if (u < 0 || v < 0 || u >= expected.width() || v >= expected.height() || !(expected(u, v) > 0)) return false;
    const double there = model.at(u - grid_.window.x0, v - grid_.window.y0);
    return std::abs(1 / static_cast<double>(expected(u, v)) - there) < 10 * kLeastBend * there;
  }

  struct NearCrease {
    int x;
    int y;
    std::uint16_t own;
    std::uint16_t other;
  };

  const DepthGrid& grid_;
  const FlatParts& parts_;
  const Comparison& comparison_;
  int width_;
  int height_;
  VertexPlaces vertices_;
  std::map<std::pair<std::uint16_t, std::uint16_t>, std::uint16_t> line_numbers_;
  std::vector<NearCrease> near_crease_;
};

Eigen::Vector2d nearest_on(const Loop& loop, const Eigen::Vector2d& p) {
  Eigen::Vector2d nearest = loop.front();
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Eigen::Vector2d& a = loop[i];
    const Eigen::Vector2d along = loop[(i + 1) % loop.size()] - a;
    const double share = std::clamp((p - a).dot(along) / std::max(along.squaredNorm(), 1e-12), 0.0, 1.0);
    const Eigen::Vector2d q = a + share * along;
    if ((q - p).squaredNorm() < (nearest - p).squaredNorm()) nearest = q;
  }
  return nearest;
}

/// The straight lines around a patch, each with the box in which it can be met.
class Outline {
 public:
  Outline(const Image<std::uint8_t>& mask, double ragged_px) : reach_px_{ragged_px + 0.5} {
    // What is smaller than a block is a hole, or a crumb, and has no straight border.
    constexpr double kSmallest_px = 64;
    for (auto& loop : outline_of(mask, kSmallest_px, ragged_px)) {
      Eigen::AlignedBox2d box;
      for (const auto& corner : loop) box.extend(corner);
      const Eigen::Vector2d reach = Eigen::Vector2d::Constant(reach_px_);
      loops_.emplace_back(Eigen::AlignedBox2d{Eigen::Vector2d{box.min() - reach}, Eigen::Vector2d{box.max() + reach}},
                          std::move(loop));
    }
  }
  [[nodiscard]] std::optional<Eigen::Vector2d> nearest(const Eigen::Vector2d& p) const {
    std::optional<Eigen::Vector2d> nearest;
    double distance = reach_px_;
    for (const auto& [box, loop] : loops_) {
      if (!box.contains(p)) continue;
      const Eigen::Vector2d at = nearest_on(loop, p);
      if ((at - p).norm() > distance) continue;
      distance = (at - p).norm();
      nearest = at;
    }
    return nearest;
  }

 private:
  double reach_px_;
  std::vector<std::pair<Eigen::AlignedBox2d, Loop>> loops_;
};

struct Move {
  std::uint32_t pixel;
  /// The place without it.
  Eigen::Vector3f before;
};

/// Takes moves of vertices back until they turn no triangle over in the picture.
class FoldsTakenBack {
 public:
  FoldsTakenBack(const GridMesh& mesh, std::vector<Eigen::Vector3f>& places) : mesh_{mesh}, places_{places} {}

  void take_back(const std::vector<Move>& moves) {
    for (const auto& move : moves) before_.emplace(move.pixel, move.before);
    for (bool changed = true; changed;) {
      changed = false;
      for (const auto& move : moves) {
        for_blocks_around(move.pixel, [&](std::uint32_t block) {
          for_each_triangle(mesh_, block, [&](const Triangle& t) { changed |= is_turned_over(t) && take_back(t); });
        });
      }
    }
  }

 private:
  template <class Visit>
  void for_blocks_around(std::uint32_t pixel, const Visit& visit) const {
    const auto w = static_cast<std::uint32_t>(mesh_.width);
    for (const std::uint32_t back : {w + 1, w, 1U, 0U}) {
      if (pixel >= back) visit(pixel - back);
    }
  }
  [[nodiscard]] Eigen::Vector2f own(std::uint32_t i) const {
    const auto w = static_cast<std::uint32_t>(mesh_.width);
    return {static_cast<float>(i % w), static_cast<float>(i / w)};
  }
  [[nodiscard]] Eigen::Vector2f at(std::uint32_t i) const {
    return places_[i].z() > 0 ? Eigen::Vector2f{places_[i].head<2>()} : own(i);
  }
  [[nodiscard]] bool is_turned_over(const Triangle& triangle) const {
    const auto twice_area = [](const Eigen::Vector2f& a, const Eigen::Vector2f& b, const Eigen::Vector2f& c) {
      return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    };
    const auto& [a, b, c] = triangle;
    return !(twice_area(at(a), at(b), at(c)) * twice_area(own(a), own(b), own(c)) > 0);
  }
  bool take_back(const Triangle& triangle) {
    bool changed = false;
    for (const auto i : triangle) {
      const auto move = before_.find(i);
      if (move == before_.end()) continue;
      places_[i] = move->second;
      before_.erase(move);
      changed = true;
    }
    return changed;
  }

  const GridMesh& mesh_;
  std::vector<Eigen::Vector3f>& places_;
  std::unordered_map<std::uint32_t, Eigen::Vector3f> before_;
};

}  // namespace

VertexPlaces meet_in_lines(const DepthGrid& grid, const FlatParts& parts, const Comparison& comparison) {
  return LineFinder{grid, parts, comparison}.find();
}

void straighten_border(const DepthGrid& grid, const FlatParts& parts, const GridMesh& mesh,
                       const GridVertices& vertices, VertexPlaces& places) {
  Image<std::uint8_t> mask{grid.window.width(), grid.window.height()};
  for (const auto i : vertices.pixels) mask.pixels()[i] = is_part(grid.role[i]) ? 1 : 0;
  const Outline outline{mask, std::max(kStraightSteps_px, kRagged * grid.lateral_px)};
  const auto columns = static_cast<std::uint32_t>(mesh.width);
  std::vector<Move> moves;
  for (const auto& edge : border_of(mesh)) {
    const auto i = edge[0];  // each border vertex begins an edge
    if (!is_part(grid.role[i]) || places.lines[i] != 0) continue;
    const auto at = outline.nearest({static_cast<double>(i % columns), static_cast<double>(i / columns)});
    if (!at) continue;
    const auto plane = parts.plane_of_pixel[i];
    const float z = plane == 0 ? grid.z[i] : parts.planes[plane - 1u].depth(at->x(), at->y());
    if (!(z > 0)) continue;
    moves.push_back({i, places.places[i]});
    places.places[i] = {static_cast<float>(at->x()), static_cast<float>(at->y()), z};
  }
  FoldsTakenBack{mesh, places.places}.take_back(moves);
}

}  // namespace meshloop::adjust
