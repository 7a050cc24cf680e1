#include "device/draw/object_cache.h"

#include <algorithm>
#include <set>
#include <utility>

namespace meshloop {
namespace {

constexpr Rgb8 kColorless{205, 205, 200};

template <class T>
void fill(GLenum target, const Buffer& buffer, const std::vector<T>& values) {
  glBindBuffer(target, buffer.name());
  glBufferData(target, static_cast<GLsizeiptr>(values.size() * sizeof(T)), values.data(), GL_STATIC_DRAW);
}

void attribute(GLuint location, const Buffer& buffer, GLenum type, GLboolean normalised) {
  glBindBuffer(GL_ARRAY_BUFFER, buffer.name());
  glEnableVertexAttribArray(location);
  glVertexAttribPointer(location, 3, type, normalised, 0, nullptr);
}

}  // namespace

ObjectMesh::ObjectMesh(std::shared_ptr<const Submesh> source) : submesh{std::move(source)} {
  auto of_vertices = vertex_colors(*submesh).value_or(std::vector<Rgb8>{});
  if (of_vertices.empty()) of_vertices.assign(submesh->positions.size(), kColorless);
  glBindVertexArray(vertex_array.name());
  fill(GL_ARRAY_BUFFER, positions, submesh->positions);
  attribute(0, positions, GL_FLOAT, GL_FALSE);
  fill(GL_ARRAY_BUFFER, colors, of_vertices);
  attribute(1, colors, GL_UNSIGNED_BYTE, GL_TRUE);
  fill(GL_ARRAY_BUFFER, normals, vertex_normals(*submesh));
  attribute(2, normals, GL_FLOAT, GL_FALSE);
  fill(GL_ELEMENT_ARRAY_BUFFER, indices, submesh->triangles);
  glBindVertexArray(0);
  index_count = static_cast<GLsizei>(submesh->triangles.size() * 3);
  bounds = submesh->bounds();
}

std::vector<const VirtualObject*> ObjectCache::update(const std::vector<VirtualObject>& objects) {
  std::set<const Submesh*> named;
  for (const auto& object : objects) named.insert(object.submesh.get());
  std::erase_if(meshes_, [&](const auto& entry) { return !named.contains(entry.first); });
  std::vector<const VirtualObject*> drawable;
  for (const auto& object : objects) {
    if (!object.submesh || !is_rigid(object.T_world_object)) continue;
    const bool known = meshes_.contains(object.submesh.get());
    if (!known && !validate(*object.submesh)) continue;
    if (!known) meshes_.emplace(object.submesh.get(), ObjectMesh{object.submesh});
    drawable.push_back(&object);
  }
  return drawable;
}

const ObjectMesh& ObjectCache::mesh_of(const VirtualObject& object) const {
  return meshes_.at(object.submesh.get());
}

}  // namespace meshloop
