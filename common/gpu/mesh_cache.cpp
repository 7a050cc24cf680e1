#include "common/gpu/mesh_cache.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <thread>
#include <utility>

#include "common/base/clock.h"
#include "common/base/log.h"
#include "common/base/memory.h"
#include "common/gpu/projection.h"
#include "common/image/jpeg_codec.h"

namespace meshloop {
namespace {

/// A smaller submesh costs less whole than its choice of clusters.
constexpr std::size_t kWorthAHierarchy = 1024;
/// What an update may spend on uploading hierarchies: a frame has 33.
constexpr double kRefining_ms = 2;

template <class T>
void upload(GLenum target, const Buffer& buffer, const std::vector<T>& values) {
  glBindBuffer(target, buffer.name());
  glBufferData(target, static_cast<GLsizeiptr>(values.size() * sizeof(T)), values.data(), GL_STATIC_DRAW);
}

template <class T>
std::vector<T> in_order(const std::vector<T>& values, const std::vector<std::uint32_t>& order) {
  std::vector<T> result;
  result.reserve(order.size());
  for (const auto position : order) result.push_back(values[position]);
  return result;
}

std::optional<Texture> upload_picture(const ProjectedTexture& source) {
  const auto picture = decode_jpeg(source.jpeg);
  if (!picture) {
    log_warning("a node is drawn without its texture: {}", picture.error().message);
    return std::nullopt;
  }
  Texture texture = make_texture(GL_RGB8, picture->width(), picture->height());
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glBindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, picture->width(), picture->height(), GL_RGB, GL_UNSIGNED_BYTE,
                  picture->data());
  return texture;
}

void draw_triangles(std::uint32_t first, std::uint32_t count) {
  const auto offset = std::uintptr_t{first} * sizeof(Triangle);
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(3 * count), GL_UNSIGNED_INT, reinterpret_cast<const void*>(offset));
}

}  // namespace

MeshCache::Entry::Entry(std::shared_ptr<const Submesh> uploaded) : submesh{std::move(uploaded)} {
  static_assert(sizeof(Eigen::Vector3f) == 12 && sizeof(Rgb8) == 3 && sizeof(Triangle) == 12);
  upload_vertices(nullptr);
  upload(GL_ELEMENT_ARRAY_BUFFER, indices, submesh->triangles);
  glBindVertexArray(0);
  mesh.vertex_array = vertex_array.name();
  mesh.index_count = static_cast<int>(3 * submesh->triangles.size());
  mesh.has_colors = submesh->has_colors();
  mesh.bounds = submesh->bounds();
}

// Leaves the vertex array bound.
void MeshCache::Entry::upload_vertices(const std::vector<std::uint32_t>* order) {
  glBindVertexArray(vertex_array.name());
  upload(GL_ARRAY_BUFFER, positions, order == nullptr ? submesh->positions : in_order(submesh->positions, *order));
  glEnableVertexAttribArray(0);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
  if (!submesh->has_colors()) return;
  upload(GL_ARRAY_BUFFER, colors, order == nullptr ? submesh->colors : in_order(submesh->colors, *order));
  glEnableVertexAttribArray(1);
  glVertexAttribPointer(1, 3, GL_UNSIGNED_BYTE, GL_TRUE, 0, nullptr);
}

void MeshCache::Entry::refine(std::unique_ptr<ClusterHierarchy> built) {
  upload_vertices(&built->vertex_order);
  upload(GL_ELEMENT_ARRAY_BUFFER, indices, built->triangles);
  glBindVertexArray(0);
  // An empty list in braces would leave the memory with them.
  built->triangles = std::vector<Triangle>{};
  built->vertex_order = std::vector<std::uint32_t>{};
  hierarchy = std::move(built);
  mesh.hierarchy = hierarchy.get();
}

MeshCache::MeshCache() = default;
MeshCache::~MeshCache() = default;

void MeshCache::update(const Model& model, bool with_detail) {
  update(model, with_detail, HierarchyBuilder::Priority::yielding);
}

void MeshCache::update(const Model& model, bool with_detail, HierarchyBuilder::Priority priority) {
  for (const auto& node : model.nodes) {
    if (node.submesh == nullptr) continue;
    Entry& entry = entries_.try_emplace(node.submesh.get(), node.submesh).first->second;
    if (!with_detail || entry.is_asked || node.submesh->triangles.size() < kWorthAHierarchy) continue;
    entry.is_asked = true;
    if (!builder_) builder_ = std::make_unique<HierarchyBuilder>(std::thread::hardware_concurrency(), priority);
    builder_->ask(node.submesh);
  }
  refine_ready(kRefining_ms);
  std::erase_if(entries_, [](const auto& item) { return item.second.submesh.use_count() == 1; });
}

void MeshCache::finish(const Model& model) {
  // Somebody waits: threads that yield would wait for every other program on the machine.
  update(model, true, HierarchyBuilder::Priority::normal);
  if (!builder_) return;
  bool is_new = false;
  while (builder_->wait_for_next()) {
    refine_ready(std::numeric_limits<double>::infinity());
    is_new = true;
  }
  if (is_new) give_memory_back();
}

void MeshCache::refine_ready(double milliseconds) {
  if (!builder_) return;
  const Stopwatch watch;
  while (watch.milliseconds() < milliseconds) {
    auto [submesh, hierarchy] = builder_->take();
    if (!hierarchy) return;
    const auto entry = entries_.find(submesh.get());
    if (entry != entries_.end()) entry->second.refine(std::move(hierarchy));
  }
}

const GpuMesh& MeshCache::mesh_of(const Node& node) const {
  static const GpuMesh kNothing;
  const auto found = entries_.find(node.submesh.get());
  return found == entries_.end() ? kNothing : found->second.mesh;
}

unsigned MeshCache::bind_picture(const Node& node) {
  const auto found = entries_.find(node.submesh.get());
  if (found == entries_.end() || !node.submesh->texture) return 0;
  Entry& entry = found->second;
  if (!std::exchange(entry.is_decoded, true)) entry.picture = upload_picture(*node.submesh->texture);
  if (!entry.picture) return 0;
  glBindTexture(GL_TEXTURE_2D, entry.picture->name());
  return entry.picture->name();
}

void MeshCache::draw(const Node& node, const Eigen::Matrix4d& clip_from_node, const Tolerance& tolerance) {
  const GpuMesh& mesh = mesh_of(node);
  if (mesh.index_count == 0 || is_outside_view(clip_from_node, mesh.bounds)) return;
  glBindVertexArray(mesh.vertex_array);
  if (mesh.hierarchy == nullptr) {
    draw_triangles(0, static_cast<std::uint32_t>(mesh.index_count / 3));
    return;
  }
  CutView view;
  view.clip_from_mesh = clip_from_node.cast<float>();
  view.tolerance = &tolerance;
  for (const auto& [first, count] : cut_.choose(*mesh.hierarchy, view)) draw_triangles(first, count);
}

}  // namespace meshloop
