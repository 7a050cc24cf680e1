#include "server/adjust/open_border.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>

#include "common/mesh/lattice.h"

namespace meshloop::adjust {
namespace {

constexpr std::size_t kMostTriangles = 250'000;
constexpr float kBehind_m = 0.01f;

/// How many pixels of a rectangle are marked, in constant time (summed-area table).
class MarkedArea {
 public:
  explicit MarkedArea(const Image<std::uint8_t>& marked)
      : width_{marked.width()}, height_{marked.height()}, sums_{width_ + 1, height_ + 1} {
    for (int y = 0; y < height_; ++y) {
      for (int x = 0; x < width_; ++x)
        sums_(x + 1, y + 1) = sums_(x, y + 1) + sums_(x + 1, y) - sums_(x, y) + (marked(x, y) != 0 ? 1 : 0);
    }
  }

  [[nodiscard]] bool touches(const Eigen::AlignedBox2f& box) const {
    const int x0 = column(box.min().x());
    const int y0 = row(box.min().y());
    const int x1 = column(box.max().x() + 1);
    const int y1 = row(box.max().y() + 1);
    return sums_(x1, y1) - sums_(x0, y1) - sums_(x1, y0) + sums_(x0, y0) > 0;
  }

 private:
  // Of the sums before the pixel.
  [[nodiscard]] int column(float u) const {
    return static_cast<int>(std::clamp(std::floor(u + 0.5f), 0.0f, static_cast<float>(width_)));
  }
  [[nodiscard]] int row(float v) const {
    return static_cast<int>(std::clamp(std::floor(v + 0.5f), 0.0f, static_cast<float>(height_)));
  }

  int width_;
  int height_;
  Image<int> sums_;
};

/// Finds the edges that have no other side.
class BorderFinder {
 public:
  BorderFinder(const Camera& camera, const Eigen::Isometry3f& T_camera_world, const Image<std::uint8_t>& marked)
      : camera_{camera}, T_camera_world_{T_camera_world}, area_{marked} {}

  void add(const Node& node) {
    const Submesh& submesh = *node.submesh;
    const Eigen::Isometry3f T_world_node = node.T_world_node.cast<float>();
    if (!is_near(corners_of(submesh.bounds(), T_world_node))) return;
    std::vector<Eigen::Vector3f> seen(submesh.positions.size());
    std::transform(submesh.positions.begin(), submesh.positions.end(), seen.begin(),
                   [&](const Eigen::Vector3f& p) { return in_picture(T_world_node * p, camera_, T_camera_world_); });
    for (const auto& triangle : submesh.triangles) {
      if (!is_near(std::array{seen[triangle[0]], seen[triangle[1]], seen[triangle[2]]})) continue;
      std::array<std::uint32_t, 3> numbers{};
      for (std::size_t k = 0; k < 3; ++k) {
        const auto i = triangle[k];
        numbers[k] = number_of({T_world_node * submesh.positions[i], seen[i],
                                submesh.has_colors() ? std::optional{submesh.colors[i]} : std::nullopt});
      }
      for (std::size_t k = 0; k < 3; ++k) count(numbers[k], numbers[(k + 1) % 3]);
    }
  }

  OpenBorder finish() {
    for (const auto& [edge, triangles] : left_minus_right_) {
      const auto [a, b] = edge;
      if (triangles > 0) link(a, b);
      if (triangles < 0) link(b, a);
    }
    for (auto& vertex : border_) {
      if (vertex.next == kSeveral) vertex.next = kNoVertex;
      if (vertex.previous == kSeveral) vertex.previous = kNoVertex;
    }
    return std::move(border_);
  }

 private:
  static constexpr std::uint32_t kSeveral = kNoVertex - 1;

  [[nodiscard]] std::vector<Eigen::Vector3f> corners_of(const Eigen::AlignedBox3f& box,
                                                        const Eigen::Isometry3f& T_world_node) const {
    std::vector<Eigen::Vector3f> corners;
    for (int i = 0; i < 8; ++i) {
      const auto corner = box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(i));
      corners.push_back(in_picture(T_world_node * corner, camera_, T_camera_world_));
    }
    return corners;
  }

  [[nodiscard]] bool is_near(std::span<const Eigen::Vector3f> corners) const {
    Eigen::AlignedBox2f box;
    bool is_behind = false;
    bool is_before = false;
    for (const auto& p : corners) {
      (p.z() > kBehind_m ? is_before : is_behind) = true;
      if (p.z() > kBehind_m) box.extend(p.head<2>());
    }
    if (!is_before) return false;
    return is_behind || area_.touches(box);  // what reaches behind the camera may be anywhere in the picture
  }

  std::uint32_t number_of(const BorderVertex& vertex) {
    const Eigen::Vector3f cell = on_lattice(vertex.p_world);
    const auto [entry, is_new] =
        numbers_.try_emplace({cell.x(), cell.y(), cell.z()}, static_cast<std::uint32_t>(border_.size()));
    if (is_new) border_.push_back(vertex);
    return entry->second;
  }

  void count(std::uint32_t a, std::uint32_t b) {
    if (a != b) left_minus_right_[std::minmax(a, b)] += a < b ? 1 : -1;
  }

  void link(std::uint32_t from, std::uint32_t to) {
    if (!is_near(std::array{border_[from].in_picture, border_[to].in_picture})) return;
    border_[from].next = border_[from].next == kNoVertex ? to : kSeveral;
    border_[to].previous = border_[to].previous == kNoVertex ? from : kSeveral;
  }

  const Camera& camera_;
  Eigen::Isometry3f T_camera_world_;
  MarkedArea area_;
  OpenBorder border_;
  std::map<std::array<float, 3>, std::uint32_t> numbers_;
  /// Of each edge, by its ends, the smaller first.
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> left_minus_right_;
};

}  // namespace

Eigen::Vector3f in_picture(const Eigen::Vector3f& p_world, const Camera& camera,
                           const Eigen::Isometry3f& T_camera_world) {
  const Eigen::Vector3f p = T_camera_world * p_world;
  const float per_z = 1 / (p.z() > kBehind_m ? p.z() : 1.0f);
  return {static_cast<float>(camera.fx) * p.x() * per_z + static_cast<float>(camera.cx),
          static_cast<float>(camera.fy) * p.y() * per_z + static_cast<float>(camera.cy), p.z()};
}

OpenBorder open_border(const Model& model, const Camera& camera, const Eigen::Isometry3f& T_camera_world,
                       const Image<std::uint8_t>& marked) {
  BorderFinder finder{camera, T_camera_world, marked};
  for (const auto& node : model.nodes) {
    if (node.submesh->triangles.size() <= kMostTriangles) finder.add(node);
  }
  return finder.finish();
}

}  // namespace meshloop::adjust
