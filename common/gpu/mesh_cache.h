#pragma once
#include <cstddef>
#include <memory>
#include <unordered_map>

#include "common/gpu/gl_objects.h"
#include "common/mesh/model.h"

namespace meshloop {

/// A submesh in GPU buffers. The names belong to the cache.
struct GpuMesh {
  unsigned vertex_array = 0;
  unsigned position_buffer = 0;
  unsigned color_buffer = 0;
  unsigned index_buffer = 0;
  int index_count = 0;
  bool has_colors = false;
  /// In the node's frame.
  Eigen::AlignedBox3f bounds;
};

/// Keeps the submeshes of the present model on the GPU. A submesh is uploaded once, however many revisions share it.
/// Vertex attributes: 0 position (vec3), 1 colour (normalised RGB8; alpha reads 1). Where has_colors is false attribute
/// 1 is not an array: its value is the context's own (glVertexAttrib4f). Indices are GL_UNSIGNED_INT. One thread, that
/// of the context, which must be current in every call and at the end.
class MeshCache {
 public:
  MeshCache() = default;
  ~MeshCache() = default;
  MeshCache(const MeshCache&) = delete;
  MeshCache& operator=(const MeshCache&) = delete;

  /// Uploads what is new in the model and frees what is no longer in it. Nodes without a submesh are left out.
  void update(const Model& model);
  /// The node's mesh; `update` must have seen its model. A mesh of no triangles for a node that it has not seen.
  [[nodiscard]] const GpuMesh& mesh_of(const Node& node) const;
  [[nodiscard]] std::size_t size() const { return entries_.size(); }

 private:
  struct Entry {
    explicit Entry(std::shared_ptr<const Submesh> uploaded);
    // Keeps the address, which is the key, from being used again.
    std::shared_ptr<const Submesh> submesh;
    VertexArray vertex_array;
    Buffer positions;
    Buffer colors;
    Buffer indices;
    GpuMesh mesh;
    bool used = true;
  };
  std::unordered_map<const Submesh*, Entry> entries_;
};

}  // namespace meshloop
