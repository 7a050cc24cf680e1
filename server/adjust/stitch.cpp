#include "server/adjust/stitch.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <unordered_map>

#include "common/mesh/triangulate.h"
#include "server/adjust/border_match.h"
#include "server/adjust/depth_grid.h"
#include "server/adjust/flip_edges.h"
#include "server/adjust/open_border.h"
#include "server/adjust/patch_border.h"
#include "server/adjust/split_vertices.h"

namespace meshloop::adjust {
namespace {

using Edge = std::array<std::uint32_t, 2>;

/// So many border vertices are joined in one step: where one stretch cannot be mended, the others are.
constexpr std::size_t kAtOnce = 48;

class Stitcher {
 public:
  Stitcher(Submesh& patch, const std::vector<Edge>& edges, const StitchView& view)
      : patch_{patch}, view_{view}, border_{edges} {
    for (const auto& edge : edges) seen(edge[0]);
  }

  std::vector<std::uint32_t> run(const Model& model) {
    std::vector<std::uint32_t> joined;
    const OpenBorder neighbours = open_border(model, *view_.camera, view_.T_camera_world, marked());
    if (neighbours.empty()) return joined;
    neighbours_ = &neighbours;
    const auto stretches = find_stretches();
    if (stretches.empty()) return joined;
    list_triangles(stretches);
    for (const auto& stretch : stretches) {
      for (std::size_t i = 0; i < stretch.size(); i += kAtOnce)
        join(std::span{stretch}.subspan(i, std::min(kAtOnce, stretch.size() - i)));
    }
    tidy_seam();
    std::size_t kept = 0;
    for (std::size_t t = 0; t < patch_.triangles.size(); ++t) {
      if (!gone_.contains(static_cast<std::uint32_t>(t))) patch_.triangles[kept++] = patch_.triangles[t];
    }
    patch_.triangles.resize(kept);
    for (const auto& [neighbour, vertex] : vertex_of_neighbour_) joined.push_back(vertex);
    joined.insert(joined.end(), on_edges_.begin(), on_edges_.end());
    return joined;
  }

 private:
  using Stretch = std::vector<Matched>;

  const Eigen::Vector3f& seen(std::uint32_t vertex) {
    const auto [entry, is_new] = in_picture_.try_emplace(vertex);
    if (is_new) entry->second = in_picture(patch_.positions[vertex], *view_.camera, view_.T_camera_world);
    return entry->second;
  }

  [[nodiscard]] Image<std::uint8_t> marked() const {
    Image<std::uint8_t> marked{view_.camera->width, view_.camera->height};
    constexpr int kReach = static_cast<int>(kStitch_px) + 1;
    for (const auto& [vertex, p] : in_picture_) {
      if (!(p.z() > 0) || !view_.camera->contains(p.head<2>().cast<double>())) continue;
      const int u = static_cast<int>(std::lround(p.x()));
      const int v = static_cast<int>(std::lround(p.y()));
      for (int y = std::max(v - kReach, 0); y <= std::min(v + kReach, marked.height() - 1); ++y) {
        for (int x = std::max(u - kReach, 0); x <= std::min(u + kReach, marked.width() - 1); ++x) marked(x, y) = 1;
      }
    }
    return marked;
  }

  std::vector<Stretch> find_stretches() {
    const Camera& camera = *view_.camera;
    const BorderLookup lookup{*neighbours_, camera.width, camera.height, static_cast<float>(kStitch_px)};
    std::vector<Stretch> stretches;
    for (const auto& line : border_.lines()) {
      Stretch stretch;
      std::size_t missed = 0;
      for (std::size_t i = 0; i < line.size(); ++i) {
        const auto place = find_place(lookup, line, i);
        if (place) {
          stretch.push_back({line[i], *place});
          missed = 0;
        } else if (!stretch.empty() && ++missed <= kMissed) {
          stretch.push_back({line[i], stretch.back().place});
        }
        if (!place && missed > kMissed) finish(stretch, missed - 1, stretches);
      }
      finish(stretch, std::min(missed, kMissed), stretches);
    }
    return stretches;
  }

  // What was not found at its end does not belong to a stretch.
  static void finish(Stretch& stretch, std::size_t missed, std::vector<Stretch>& stretches) {
    if (stretch.size() > missed) {
      stretch.resize(stretch.size() - missed);
      stretches.push_back(std::move(stretch));
    }
    stretch.clear();
  }

  std::optional<BorderPlace> find_place(const BorderLookup& lookup, const std::vector<std::uint32_t>& line,
                                        std::size_t i) {
    const Eigen::Vector3f& p = seen(line[i]);
    if (!(p.z() > 0)) return std::nullopt;
    const Eigen::Vector3f& ahead = seen(line[std::min(i + 2, line.size() - 1)]);
    const Eigen::Vector3f& behind = seen(line[i - std::min<std::size_t>(i, 2)]);
    const auto slope = static_cast<float>(kSteepest / std::min(view_.camera->fx, view_.camera->fy));
    return lookup.find(p, (ahead - behind).head<2>(), 4 * view_.sigma_m + p.z() * slope);
  }

  void list_triangles(const std::vector<Stretch>& stretches) {
    std::vector<std::uint8_t> is_near(patch_.positions.size(), 0);
    for (const auto& stretch : stretches) {
      for (const auto& m : stretch) is_near[m.vertex] = 1;
    }
    const auto touches = [&](const Triangle& t) {
      return std::any_of(t.begin(), t.end(), [&](auto i) { return is_near[i] == 1; });
    };
    for (const auto& triangle : patch_.triangles) {  // and the vertices beside them
      if (!touches(triangle)) continue;
      for (const auto i : triangle) is_near[i] = std::max<std::uint8_t>(is_near[i], 2);
    }
    for (std::uint32_t t = 0; t < patch_.triangles.size(); ++t) {
      for (const auto i : patch_.triangles[t]) {
        if (is_near[i] != 0) triangles_of_[i].push_back(t);
      }
    }
  }

  void join(std::span<const Matched> part) {
    if (part.empty() || replace(part) || part.size() == 1) return;
    const std::size_t half = part.size() / 2;
    join(part.first(half));
    join(part.subspan(half));
  }

  /// The triangles at these border vertices, and the line around them.
  struct Strip {
    std::set<std::uint32_t> triangles;
    /// From the vertex after the part, through the patch, to the one before it.
    std::vector<std::uint32_t> inner;
  };

  /// `within`: vertices that go, the part's among them.
  std::optional<Strip> strip_of(std::span<const Matched> part, std::set<std::uint32_t> within, std::uint32_t before,
                                std::uint32_t after) const {
    Strip strip;
    constexpr int kWidenings = 4;
    for (int i = 0; i <= kWidenings; ++i) {
      for (const auto vertex : within) take_triangles(vertex, strip.triangles);
      std::map<std::uint32_t, std::uint32_t> next;
      const std::size_t inside = within.size();
      for (const auto& [from, to] : outline_of(strip.triangles)) {
        // Where the strip touches itself, what is left of the patch hangs on by a vertex: that goes too.
        if (!next.try_emplace(from, to).second) within.insert(from);
      }
      if (within.contains(before) || within.contains(after)) return std::nullopt;
      if (within.size() > inside) continue;
      for (auto v = after;; v = next[v]) {
        strip.inner.push_back(v);
        if (v == before) break;
        if (!next.contains(v) || strip.inner.size() > next.size()) return std::nullopt;
      }
      // Another line would be the one around an island.
      if (strip.inner.size() + part.size() != next.size()) return std::nullopt;
      return strip;
    }
    return std::nullopt;
  }

  void take_triangles(std::uint32_t vertex, std::set<std::uint32_t>& triangles) const {
    const auto found = triangles_of_.find(vertex);
    if (found == triangles_of_.end()) return;
    for (const auto t : found->second) {
      if (!gone_.contains(t)) triangles.insert(t);
    }
  }

  [[nodiscard]] std::set<Edge> outline_of(const std::set<std::uint32_t>& triangles) const {
    std::set<Edge> edges;
    for (const auto t : triangles) {
      const auto& [a, b, c] = patch_.triangles[t];
      for (const Edge& edge : {Edge{a, b}, Edge{b, c}, Edge{c, a}}) {
        if (edges.erase(Edge{edge[1], edge[0]}) == 0) edges.insert(edge);
      }
    }
    return edges;
  }

  bool replace(std::span<const Matched> part) {
    const auto before = border_.previous(part.front().vertex);
    const auto after = border_.next(part.back().vertex);
    if (before == kNoVertex || after == kNoVertex || before == after) return false;
    const auto between = vertices_between(*neighbours_, part.front().place, part.back().place, 4 * part.size() + 8);
    if (!between) return false;
    std::set<std::uint32_t> within;
    for (const auto& m : part) within.insert(m.vertex);
    const std::size_t vertices = patch_.positions.size();
    const auto outer = outer_line(part, *between, before, after);
    // Where the lines cross, the patch's measurements beside its border go too.
    for (int widening = 0; outer && widening <= 1; ++widening) {
      const auto strip = strip_of(part, within, before, after);
      if (!strip) break;
      if (replace(*strip, *outer)) return true;
      within.insert(std::next(strip->inner.begin()), std::prev(strip->inner.end()));
    }
    take_back(vertices);
    return false;
  }

  // Where new and old measurements beside each other differ by more than a surface may, pinholes and crumbs are left at
  // the seam: what has a short border, with the hole or the crumb inside of it.
  void tidy_seam() {
    for (auto line : border_.lines()) {
      const bool is_closed = line.size() >= 3 && border_.next(line.back()) == line.front();
      const bool is_at_seam = std::any_of(line.begin(), line.end(), [&](std::uint32_t vertex) {
        return triangles_of_.contains(vertex) || neighbour_of_.contains(vertex);
      });
      if (!is_closed || !is_at_seam || line.size() > kShortBorder) continue;
      if (has_surface_inside(line)) {
        take_crumb(line);
        continue;
      }
      std::reverse(line.begin(), line.end());
      std::vector<Triangle> made;
      if (!fill(line, {}, made)) continue;
      for (const auto& triangle : made) add(triangle);
    }
  }

  // Every vertex at its border is its own (split_vertices).
  void take_crumb(const std::vector<std::uint32_t>& line) {
    const std::set<std::uint32_t> corners{line.begin(), line.end()};
    for (std::uint32_t t = 0; t < patch_.triangles.size(); ++t) {
      const auto& triangle = patch_.triangles[t];
      if (std::any_of(triangle.begin(), triangle.end(), [&](std::uint32_t i) { return corners.contains(i); }))
        gone_.insert(t);
    }
  }

  /// Counter-clockwise as the camera sees it: the surface is on the left of its border.
  bool has_surface_inside(const std::vector<std::uint32_t>& line) {
    float area2 = 0;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const Eigen::Vector3f& a = seen(line[i]);
      const Eigen::Vector3f& b = seen(line[(i + 1) % line.size()]);
      area2 += b.x() * a.y() - a.x() * b.y();
    }
    return area2 > 0;
  }

  bool replace(const Strip& strip, std::vector<std::uint32_t> outer) {
    std::vector<Triangle> made;
    if (!fill(strip.inner, outer, made)) return false;
    gone_.insert(strip.triangles.begin(), strip.triangles.end());
    for (const auto& triangle : made) add(triangle);
    border_.unlink(strip.inner.back(), strip.inner.front());
    outer.push_back(strip.inner.front());
    for (auto from = strip.inner.back(); const auto to : outer) {
      border_.link(from, to);
      from = to;
    }
    return true;
  }

  /// With what lies between them and the vertices of the model's border that are joined already at both ends, and
  /// without what is joined.
  [[nodiscard]] std::vector<std::uint32_t> not_joined(std::vector<std::uint32_t> between, std::uint32_t before,
                                                      std::uint32_t after) const {
    constexpr std::size_t kMost = 8;
    const auto missing = [&](std::uint32_t from, std::uint32_t to) {
      std::vector<std::uint32_t> way;
      for (auto v = from; v != kNoVertex && way.size() < kMost; v = (*neighbours_)[v].next) {
        if (v == to) return way;
        way.push_back(v);
      }
      return std::vector<std::uint32_t>{};
    };
    if (between.empty()) return between;
    if (const auto last = neighbour_of_.find(before); last != neighbour_of_.end()) {
      auto way = missing(between.front(), last->second);
      if (way.size() > 1) between.insert(between.begin(), way.rbegin(), std::prev(way.rend()));
    }
    if (const auto first = neighbour_of_.find(after); first != neighbour_of_.end()) {
      const auto way = missing(first->second, between.back());
      if (way.size() > 1) between.insert(between.end(), way.rbegin(), std::prev(way.rend()));
    }
    const auto is_joined = [&](std::uint32_t neighbour) { return vertex_of_neighbour_.contains(neighbour); };
    const auto first = std::find_if_not(between.begin(), between.end(), is_joined);
    const auto end = std::find_if_not(between.rbegin(), std::reverse_iterator{first}, is_joined).base();
    return {first, end};
  }

  /// The patch's vertices at the model's border, new ones where there are none yet.
  std::optional<std::vector<std::uint32_t>> outer_line(std::span<const Matched> part,
                                                       const std::vector<std::uint32_t>& between, std::uint32_t before,
                                                       std::uint32_t after) {
    std::vector<std::uint32_t> outer;
    for (const auto neighbour : not_joined(between, before, after)) {
      if (vertex_of_neighbour_.contains(neighbour)) return std::nullopt;
      const auto vertex = add_vertex((*neighbours_)[neighbour].p_world, (*neighbours_)[neighbour].color, part);
      vertex_of_neighbour_[neighbour] = vertex;
      neighbour_of_[vertex] = neighbour;
      outer.push_back(vertex);
    }
    if (outer.empty() && !is_joined(before) && !is_joined(after)) {
      if (!between.empty()) return std::nullopt;  // another part of the border is there
      for (const auto& m : {part.front(), part.back()}) {
        if (!outer.empty() && m.vertex == part.front().vertex) break;
        const auto& a = (*neighbours_)[m.place.vertex];
        const auto& b = (*neighbours_)[a.next];
        outer.push_back(add_vertex(a.p_world + m.place.share * (b.p_world - a.p_world), a.color, part));
        on_edges_.insert(outer.back());
      }
    }
    return outer;
  }

  [[nodiscard]] bool is_joined(std::uint32_t vertex) const { return vertex >= first_new_; }

  std::uint32_t add_vertex(const Eigen::Vector3f& p_world, const std::optional<Rgb8>& color,
                           std::span<const Matched> part) {
    patch_.positions.push_back(p_world);
    if (patch_.has_colors()) patch_.colors.push_back(color.value_or(patch_.colors[part.front().vertex]));
    return static_cast<std::uint32_t>(patch_.positions.size() - 1);
  }

  void take_back(std::size_t vertices) {
    const auto is_new = [&](std::uint32_t vertex) { return vertex >= vertices; };
    std::erase_if(vertex_of_neighbour_, [&](const auto& entry) { return is_new(entry.second); });
    std::erase_if(neighbour_of_, [&](const auto& entry) { return is_new(entry.first); });
    std::erase_if(on_edges_, is_new);
    std::erase_if(in_picture_, [&](const auto& entry) { return is_new(entry.first); });
    patch_.positions.resize(vertices);
    if (patch_.has_colors()) patch_.colors.resize(vertices);
  }

  /// Triangles between both lines, none of them turned over as the camera sees it.
  bool fill(const std::vector<std::uint32_t>& inner, const std::vector<std::uint32_t>& outer,
            std::vector<Triangle>& made) {
    FlatRing ring;
    for (const auto* line : {&inner, &outer}) {
      for (const auto vertex : *line) {
        const Eigen::Vector3f& p = seen(vertex);
        if (!(p.z() > 0)) return false;
        ring.corners.push_back(vertex);
        ring.points.emplace_back(p.x(), -p.y());
      }
    }
    if (ring.corners.size() < 3) return false;
    const std::size_t needed = ring.corners.size() - 2;
    append_flat_polygon({std::move(ring)}, made);
    flip_to_delaunay(made, [&](std::uint32_t vertex) -> Eigen::Vector2f { return seen(vertex).head<2>(); });
    return made.size() == needed &&
           std::all_of(made.begin(), made.end(), [&](const Triangle& t) { return faces_camera(t); });
  }

  bool faces_camera(const Triangle& triangle) {
    constexpr float kLeast_px2 = 1e-3f;
    const Eigen::Vector2f a = seen(triangle[0]).head<2>();
    const Eigen::Vector2f along = seen(triangle[1]).head<2>() - a;
    const Eigen::Vector2f across = seen(triangle[2]).head<2>() - a;
    return along.y() * across.x() - along.x() * across.y() > kLeast_px2;
  }

  void add(const Triangle& triangle) {
    const auto number = static_cast<std::uint32_t>(patch_.triangles.size());
    patch_.triangles.push_back(triangle);
    for (const auto i : triangle) {
      if (const auto entry = triangles_of_.find(i); entry != triangles_of_.end()) entry->second.push_back(number);
    }
  }

  /// Edges around a hole that is closed, or a crumb that goes.
  static constexpr std::size_t kShortBorder = 8;
  /// A border vertex that was not found among others that were.
  static constexpr std::size_t kMissed = 2;

  Submesh& patch_;
  const StitchView& view_;
  PatchBorder border_;
  const OpenBorder* neighbours_ = nullptr;
  std::uint32_t first_new_ = static_cast<std::uint32_t>(patch_.positions.size());
  std::unordered_map<std::uint32_t, Eigen::Vector3f> in_picture_;
  /// Of vertices beside a border of the model, and their neighbours.
  std::unordered_map<std::uint32_t, std::vector<std::uint32_t>> triangles_of_;
  std::set<std::uint32_t> gone_;
  /// The patch's vertex in the place of one of the model's border.
  std::map<std::uint32_t, std::uint32_t> vertex_of_neighbour_;
  std::map<std::uint32_t, std::uint32_t> neighbour_of_;
  std::set<std::uint32_t> on_edges_;
};

}  // namespace

std::vector<std::uint32_t> stitch(Submesh& patch, std::vector<std::array<std::uint32_t, 2>> border, const Model& model,
                                  const StitchView& view) {
  if (border.empty() || model.nodes.empty()) return {};
  split_vertices(patch, border);
  return Stitcher{patch, border, view}.run(model);
}

}  // namespace meshloop::adjust
