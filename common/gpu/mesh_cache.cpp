#include "common/gpu/mesh_cache.h"

#include <cstdint>
#include <utility>

#include "common/gpu/projection.h"

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
  auto chunked = make_chunks(*submesh);
  upload(GL_ELEMENT_ARRAY_BUFFER, indices, chunked.triangles);
  glBindVertexArray(0);
  mesh.vertex_array = vertex_array.name();
  mesh.index_count = static_cast<int>(3 * submesh->triangles.size());
  mesh.has_colors = submesh->has_colors();
  mesh.bounds = submesh->bounds();
  mesh.chunks = std::move(chunked.chunks);
}

void draw_visible(const GpuMesh& mesh, const Eigen::Matrix4d& clip_from_mesh) {
  if (mesh.index_count == 0 || is_outside_view(clip_from_mesh, mesh.bounds)) return;
  glBindVertexArray(mesh.vertex_array);
  int first = 0;
  int count = 0;
  const auto draw = [&] {
    if (count == 0) return;
    const auto offset = static_cast<std::uintptr_t>(first) * sizeof(GLuint);
    glDrawElements(GL_TRIANGLES, count, GL_UNSIGNED_INT, reinterpret_cast<const void*>(offset));
  };
  for (const auto& chunk : mesh.chunks) {
    if (is_outside_view(clip_from_mesh, chunk.bounds)) continue;
    if (chunk.first_index != first + count) {
      draw();
      first = chunk.first_index;
      count = 0;
    }
    count += chunk.index_count;
  }
  draw();
}

void MeshCache::update(const Model& model) {
  for (const auto& node : model.nodes) {
    if (node.submesh != nullptr) entries_.try_emplace(node.submesh.get(), node.submesh);
  }
  std::erase_if(entries_, [](const auto& item) { return item.second.submesh.use_count() == 1; });
}

const GpuMesh& MeshCache::mesh_of(const Node& node) const {
  static const GpuMesh kNothing;
  const auto found = entries_.find(node.submesh.get());
  return found == entries_.end() ? kNothing : found->second.mesh;
}

}  // namespace meshloop
