#pragma once
// Virtual objects on the GPU: as MeshCache, and with normals.
#include <memory>
#include <unordered_map>
#include <vector>

#include "common/gpu/gl_objects.h"
#include "device/draw/ar_renderer.h"

namespace meshloop {

/// Vertex attributes: 0 position, 1 colour, 2 normal. Of a texture the object shows what lies at its
/// vertices. Objects without colours are light grey.
struct ObjectMesh {
  explicit ObjectMesh(std::shared_ptr<const Submesh> source);

  // Keeps the address, which is the key, from being used again.
  std::shared_ptr<const Submesh> submesh;
  VertexArray vertex_array;
  Buffer positions;
  Buffer colors;
  Buffer normals;
  Buffer indices;
  GLsizei index_count = 0;
  Eigen::AlignedBox3f bounds;
};

/// One thread, that of the context, which is current in every call and at the end.
class ObjectCache {
 public:
  /// Uploads new objects and frees those that are gone. Objects whose submesh is missing or not valid, and poses that
  /// are not rigid, are left out of the result.
  [[nodiscard]] std::vector<const VirtualObject*> update(const std::vector<VirtualObject>& objects);
  /// `update` must have returned the object.
  [[nodiscard]] const ObjectMesh& mesh_of(const VirtualObject& object) const;

 private:
  std::unordered_map<const Submesh*, ObjectMesh> meshes_;
};

}  // namespace meshloop
