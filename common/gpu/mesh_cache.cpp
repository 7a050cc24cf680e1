#include "common/gpu/mesh_cache.h"

#include <utility>

namespace meshloop {
namespace {

template <class T>
void upload(GLenum target, const Buffer& buffer, const std::vector<T>& values) {
  glBindBuffer(target, buffer.name());
  glBufferData(target, static_cast<GLsizeiptr>(values.size() * sizeof(T)), values.data(), GL_STATIC_DRAW);
}

}  // namespace

MeshCache::Entry::Entry(std::shared_ptr<const Submesh> uploaded) : submesh{std::move(uploaded)} {
  static_assert(sizeof(Eigen::Vector3f) == 12 && sizeof(Rgb8) == 3 && sizeof(Triangle) == 12);
  glBindVertexArray(vertex_array.name());
  upload(GL_ARRAY_BUFFER, positions, submesh->positions);
  glEnableVertexAttribArray(0);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
  if (submesh->has_colors()) {
    upload(GL_ARRAY_BUFFER, colors, submesh->colors);
    glEnableVertexAttribArray(1);
    glVertexAttribPointer(1, 3, GL_UNSIGNED_BYTE, GL_TRUE, 0, nullptr);
  }
  upload(GL_ELEMENT_ARRAY_BUFFER, indices, submesh->triangles);
  glBindVertexArray(0);
  mesh.vertex_array = vertex_array.name();
  mesh.position_buffer = positions.name();
  mesh.color_buffer = colors.name();
  mesh.index_buffer = indices.name();
  mesh.index_count = static_cast<int>(3 * submesh->triangles.size());
  mesh.has_colors = submesh->has_colors();
  mesh.bounds = submesh->bounds();
}

void MeshCache::update(const Model& model) {
  for (auto& [key, entry] : entries_) entry.used = false;
  for (const auto& node : model.nodes) {
    if (node.submesh == nullptr) continue;
    const auto [position, is_new] = entries_.try_emplace(node.submesh.get(), node.submesh);
    if (!is_new) position->second.used = true;
  }
  std::erase_if(entries_, [](const auto& item) { return !item.second.used; });
}

const GpuMesh& MeshCache::mesh_of(const Node& node) const {
  static const GpuMesh kNothing;
  const auto found = entries_.find(node.submesh.get());
  return found == entries_.end() ? kNothing : found->second.mesh;
}

}  // namespace meshloop
