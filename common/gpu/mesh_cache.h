#pragma once
#include <cstddef>
#include <memory>
#include <unordered_map>

#include "common/mesh/model.h"

namespace meshloop {

/// A submesh in GPU buffers.
struct GpuMesh {
  unsigned vertex_array = 0;
  unsigned position_buffer = 0;
  unsigned color_buffer = 0;
  unsigned index_buffer = 0;
  int index_count = 0;
  bool has_colors = false;
};

/// Keeps the submeshes of the present model on the GPU. A submesh is uploaded once, however many revisions share it.
/// Vertex attributes: 0 position (vec3), 1 colour (normalised RGB8). One thread, that of the context.
class MeshCache {
 public:
  MeshCache() = default;
  ~MeshCache();
  MeshCache(const MeshCache&) = delete;
  MeshCache& operator=(const MeshCache&) = delete;

  /// Uploads what is new in the model and frees what is no longer in it.
  void update(const Model& model);
  /// The node's mesh; `update` must have seen its model.
  [[nodiscard]] const GpuMesh& mesh_of(const Node& node) const;

 private:
  struct Entry {
    std::shared_ptr<const Submesh> submesh;
    GpuMesh mesh;
    bool used = false;
  };
  std::unordered_map<const Submesh*, Entry> entries_;
};

}  // namespace meshloop
