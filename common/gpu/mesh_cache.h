#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <unordered_map>

#include "common/detail/cluster_cut.h"
#include "common/detail/hierarchy_builder.h"
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
  /// Which indices are which clusters; null until it is built, and for a submesh too small to need one.
  const ClusterHierarchy* hierarchy = nullptr;
};

/// Keeps submeshes on the GPU, uploaded once however many revisions and renderers share them (GpuContext has one), and
/// has their hierarchies built in the background; until then a mesh is drawn whole.
/// Vertex attributes: 0 position (vec3), 1 colour (normalised RGB8; alpha reads 1). Where has_colors is false attribute
/// 1 is not an array: its value is the context's own (glVertexAttrib4f). Indices are GL_UNSIGNED_INT, in an order of
/// the cache's own. One thread, that of the context, which must be current in every call and at the end.
class MeshCache {
 public:
  MeshCache();
  ~MeshCache();
  MeshCache(const MeshCache&) = delete;
  MeshCache& operator=(const MeshCache&) = delete;

  /// Uploads what is new in the model and a few of the hierarchies that are ready, and frees what nobody but the cache
  /// holds any more. Nodes without a submesh are left out. Hierarchies are asked for only when the model is to be drawn
  /// with less than every triangle.
  void update(const Model& model, bool with_detail);
  /// Waits until the model has all its hierarchies, and uploads them: for batch work, whose results must not depend on
  /// how fast a thread was.
  void finish(const Model& model);
  /// The node's mesh; `update` must have seen its model. A mesh of no triangles for a node that it has not seen.
  [[nodiscard]] const GpuMesh& mesh_of(const Node& node) const;
  [[nodiscard]] std::size_t size() const { return entries_.size(); }
  /// The picture of the node's ProjectedTexture, sampled between its pixels, clamped at its edges; 0 where the node has
  /// none or it cannot be decoded. Decoded when it is asked for first: who draws without colours never pays for it.
  /// Binds it to the active texture unit.
  unsigned bind_picture(const Node& node);

  /// Draws the node's mesh with the program and the uniforms that are set: what may lie in the view of the matrix, in
  /// the detail that the tolerance asks for. Colours are right only with an exact tolerance.
  void draw(const Node& node, const Eigen::Matrix4d& clip_from_node, const Tolerance& tolerance);

 private:
  struct Entry {
    explicit Entry(std::shared_ptr<const Submesh> uploaded);
    void upload_vertices(const std::vector<std::uint32_t>* order);
    void refine(std::unique_ptr<ClusterHierarchy> built);
    // Keeps the address, which is the key, from being used again.
    std::shared_ptr<const Submesh> submesh;
    /// Without its triangles and its order of vertices: those are in the buffers.
    std::unique_ptr<const ClusterHierarchy> hierarchy;
    bool is_asked = false;
    /// Empty until it is asked for.
    std::optional<Texture> picture;
    bool is_decoded = false;
    VertexArray vertex_array;
    Buffer positions;
    Buffer colors;
    Buffer indices;
    GpuMesh mesh;
  };
  void update(const Model& model, bool with_detail, HierarchyBuilder::Priority priority);
  /// Uploads hierarchies that are ready until `milliseconds` are over.
  void refine_ready(double milliseconds);

  std::unordered_map<const Submesh*, Entry> entries_;
  ClusterCut cut_;
  std::unique_ptr<HierarchyBuilder> builder_;
};

}  // namespace meshloop
