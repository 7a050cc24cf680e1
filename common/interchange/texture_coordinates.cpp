#include "common/interchange/texture_coordinates.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

namespace meshloop {
namespace {

constexpr float kLargestError_px = 0.5f;
constexpr int kMostHalvings = 10;

class Divider {
 public:
  explicit Divider(const Submesh& submesh) : texture_{*submesh.texture} {
    mesh_.positions = submesh.positions;
    mesh_.triangles = submesh.triangles;
    pixels_.reserve(mesh_.positions.size());
    for (const auto& p : mesh_.positions) pixels_.push_back(pixel_of(texture_, p));
  }

  TexturedMesh run() && {
    const std::size_t most = 2 * static_cast<std::size_t>(texture_.width) * static_cast<std::size_t>(texture_.height);
    for (int i = 0; i < kMostHalvings && mesh_.triangles.size() < most; ++i) {
      if (!halve_edges()) break;
    }
    const Eigen::Array2f size{static_cast<float>(texture_.width), static_cast<float>(texture_.height)};
    mesh_.coordinates.reserve(pixels_.size());
    for (const auto& pixel : pixels_) mesh_.coordinates.emplace_back((pixel.array() + 0.5f) / size);
    return std::move(mesh_);
  }

 private:
  using Edge = std::pair<std::uint32_t, std::uint32_t>;

  /// False when no edge had to be.
  bool halve_edges() {
    middles_.clear();
    std::vector<Triangle> divided;
    divided.reserve(mesh_.triangles.size());
    for (const auto& triangle : mesh_.triangles) divide(triangle, divided);
    mesh_.triangles = std::move(divided);
    return !middles_.empty();
  }

  /// The vertex in the middle of an edge that is to be halved; its first vertex otherwise. Depends on the two ends
  /// alone, in either order.
  std::uint32_t middle_of(std::uint32_t a, std::uint32_t b) {
    const Edge edge = std::minmax(a, b);
    if (const auto known = middles_.find(edge); known != middles_.end()) return known->second;
    const Eigen::Vector3f middle = (mesh_.positions[a] + mesh_.positions[b]) * 0.5f;
    const Eigen::Vector2f pixel = pixel_of(texture_, middle);
    if ((pixel - (pixels_[a] + pixels_[b]) * 0.5f).norm() <= kLargestError_px) return a;
    const auto vertex = static_cast<std::uint32_t>(mesh_.positions.size());
    mesh_.positions.push_back(middle);
    pixels_.push_back(pixel);
    middles_.emplace(edge, vertex);
    return vertex;
  }

  void divide(const Triangle& triangle, std::vector<Triangle>& divided) {
    std::array<std::uint32_t, 3> middle{};
    std::array<bool, 3> is_halved{};
    for (std::size_t k = 0; k < 3; ++k) {
      middle[k] = middle_of(triangle[k], triangle[(k + 1) % 3]);
      is_halved[k] = middle[k] != triangle[k];
    }
    const auto count = std::count(is_halved.begin(), is_halved.end(), true);
    if (count == 0) {
      divided.push_back(triangle);
      return;
    }
    if (count == 3) {
      for (std::size_t k = 0; k < 3; ++k) divided.push_back({triangle[k], middle[k], middle[(k + 2) % 3]});
      divided.push_back({middle[0], middle[1], middle[2]});
      return;
    }
    // Turned so that of one halved edge it is the first, and of two it is the last that is not.
    std::size_t first = 0;
    while (count == 1 ? !is_halved[first] : is_halved[(first + 2) % 3]) ++first;
    const auto a = triangle[first];
    const auto b = triangle[(first + 1) % 3];
    const auto c = triangle[(first + 2) % 3];
    const auto ab = middle[first];
    if (count == 1) {
      divided.push_back({a, ab, c});
      divided.push_back({ab, b, c});
      return;
    }
    const auto bc = middle[(first + 1) % 3];
    divided.push_back({ab, b, bc});
    divided.push_back({a, ab, bc});
    divided.push_back({a, bc, c});
  }

  const ProjectedTexture& texture_;
  TexturedMesh mesh_;
  /// Of the positions, in the texture.
  std::vector<Eigen::Vector2f> pixels_;
  std::map<Edge, std::uint32_t> middles_;
};

}  // namespace

TexturedMesh with_coordinates(const Submesh& submesh) {
  return Divider{submesh}.run();
}

}  // namespace meshloop
