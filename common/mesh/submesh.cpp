#include "common/mesh/submesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

#include "common/image/jpeg_codec.h"

namespace meshloop {
namespace {

constexpr float kFarthest_m = 10'000;

template <class T>
void append_bytes(std::vector<std::byte>& bytes, const std::vector<T>& values) {
  const auto view = std::as_bytes(std::span{values});
  bytes.insert(bytes.end(), view.begin(), view.end());
}

}  // namespace

Eigen::AlignedBox3f Submesh::bounds() const {
  Eigen::AlignedBox3f box;
  for (const auto& p : positions) box.extend(p);
  return box;
}

std::size_t Submesh::geometry_bytes() const {
  return positions.size() * 12 + colors.size() * 3 + triangles.size() * 12;
}

std::size_t Submesh::raw_bytes() const {
  std::size_t bytes = geometry_bytes();
  if (texture) bytes += static_cast<std::size_t>(texture->width) * static_cast<std::size_t>(texture->height) * 3;
  return bytes;
}

Status validate(const Submesh& submesh) {
  if (submesh.triangles.empty()) return fail("the mesh has no triangles");
  if (submesh.positions.size() > kMaxVertices || submesh.triangles.size() > kMaxTriangles) {
    return fail(fmt::format("the mesh is too large ({} vertices, {} triangles; at most {} and {})",
                            submesh.positions.size(), submesh.triangles.size(), kMaxVertices, kMaxTriangles));
  }
  if (submesh.has_colors() && submesh.colors.size() != submesh.positions.size()) {
    return fail("the mesh has colours for some of its vertices only");
  }
  for (const auto& triangle : submesh.triangles) {
    for (const auto index : triangle) {
      if (index >= submesh.positions.size()) {
        return fail(fmt::format("a triangle names vertex {}, but there are only {}", index, submesh.positions.size()));
      }
    }
  }
  const auto usable = [](const Eigen::Vector3f& p) { return p.allFinite() && p.cwiseAbs().maxCoeff() <= kFarthest_m; };
  if (!std::all_of(submesh.positions.begin(), submesh.positions.end(), usable)) {
    return fail("a vertex position is not a finite number within 10 km; is the file in metres?");
  }
  if (!submesh.texture) return {};
  if (submesh.has_colors()) return fail("the mesh has colours at its vertices and a texture; it can have one of them");
  return validate(*submesh.texture, submesh.positions);
}

Hash content_hash(const Submesh& submesh) {
  std::vector<std::byte> bytes;
  bytes.reserve(submesh.geometry_bytes() + 24 + sizeof(TextureProjection) +
                (submesh.texture ? submesh.texture->jpeg.size() : 0));
  append_bytes(bytes,
               std::vector<std::uint64_t>{submesh.positions.size(), submesh.colors.size(), submesh.triangles.size()});
  append_bytes(bytes, submesh.positions);
  append_bytes(bytes, submesh.colors);
  append_bytes(bytes, submesh.triangles);
  if (submesh.texture) {
    const auto& projection = submesh.texture->projection;
    append_bytes(bytes, std::vector<float>(projection.data(), projection.data() + projection.size()));
    append_bytes(bytes, submesh.texture->jpeg);
  }
  return hash_of(bytes);
}

namespace detail {

bool has_area_exactly(const Submesh& submesh, const Triangle& triangle) {
  const Eigen::Vector3d p = submesh.positions[triangle[0]].cast<double>();
  const Eigen::Vector3d q = submesh.positions[triangle[1]].cast<double>();
  const Eigen::Vector3d r = submesh.positions[triangle[2]].cast<double>();
  return !(q - p).cross(r - p).isZero(0);
}

}  // namespace detail

Submesh keep_triangles(Submesh submesh, const std::vector<bool>& keep) {
  constexpr auto kUnused = std::numeric_limits<std::uint32_t>::max();
  auto& [positions, colors, triangles, texture] = submesh;
  std::size_t count = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (keep[t]) triangles[count++] = triangles[t];
  }
  triangles.resize(count);
  std::vector<std::uint32_t> new_index(positions.size(), kUnused);
  for (const auto& triangle : triangles) {
    for (const auto index : triangle) new_index[index] = 0;
  }
  std::uint32_t next = 0;
  for (std::size_t i = 0; i < new_index.size(); ++i) {
    if (new_index[i] == kUnused) continue;
    positions[next] = positions[i];
    if (!colors.empty()) colors[next] = colors[i];
    new_index[i] = next++;
  }
  positions.resize(next);
  if (!colors.empty()) colors.resize(next);
  for (auto& triangle : triangles) {
    for (auto& index : triangle) index = new_index[index];
  }
  return submesh;
}

Result<std::vector<Rgb8>> vertex_colors(const Submesh& submesh) {
  if (!submesh.texture) return submesh.colors;
  const auto picture = decode_jpeg(submesh.texture->jpeg);
  if (!picture) return fail("the texture", picture.error());
  std::vector<Rgb8> colors;
  colors.reserve(submesh.positions.size());
  for (const auto& p : submesh.positions) colors.push_back(bilinear(*picture, pixel_of(*submesh.texture, p)));
  return colors;
}

std::vector<Eigen::Vector3f> vertex_normals(const Submesh& submesh) {
  std::vector<Eigen::Vector3f> normals(submesh.positions.size(), Eigen::Vector3f::Zero());
  for (const auto& [a, b, c] : submesh.triangles) {
    const Eigen::Vector3f& p = submesh.positions[a];
    const Eigen::Vector3f area = (submesh.positions[b] - p).cross(submesh.positions[c] - p);
    for (const auto index : {a, b, c}) normals[index] += area;
  }
  for (auto& normal : normals) {
    const float length = normal.norm();
    normal = length > 1e-20f ? Eigen::Vector3f(normal / length) : Eigen::Vector3f::UnitZ();
  }
  return normals;
}

}  // namespace meshloop
