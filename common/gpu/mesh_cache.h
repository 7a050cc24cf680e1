#pragma once
#include <cstddef>
#include <memory>
#include <unordered_map>

#include "common/gpu/chunks.h"
#include "common/gpu/gl_objects.h"
#include "common/mesh/model.h"

namespace meshloop {

/// A submesh in GPU buffers. The names belong to the cache.
struct GpuMesh {
  unsigned vertex_array = 0;
  int index_count = 0;
  bool has_colors = false;
  /// In the node's frame.
  Eigen::AlignedBox3f bounds;
  /// All of the indices, in order.
  std::vector<Chunk> chunks;
};

/// Draws the mesh with the program and the uniforms that are set, without the chunks that lie outside the view of the
/// matrix for certain.
void draw_visible(const GpuMesh& mesh, const Eigen::Matrix4d& clip_from_mesh);

/// Keeps submeshes on the GPU, uploaded once however many revisions and renderers share them (GpuContext has one).
/// Vertex attributes: 0 position (vec3), 1 colour (normalised RGB8; alpha reads 1). Where has_colors is false attribute
/// 1 is not an array: its value is the context's own (glVertexAttrib4f). Indices are GL_UNSIGNED_INT, in an order of
/// the cache's own. One thread, that of the context, which must be current in every call and at the end.
class MeshCache {
 public:
  MeshCache() = default;
  ~MeshCache() = default;
  MeshCache(const MeshCache&) = delete;
  MeshCache& operator=(const MeshCache&) = delete;

  /// Uploads what is new in the model, and frees what nobody but the cache holds any more. Nodes without a submesh are
  /// left out.
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
  };
  std::unordered_map<const Submesh*, Entry> entries_;
};

}  // namespace meshloop
