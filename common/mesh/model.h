#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "common/geometry/pose.h"
#include "common/mesh/submesh.h"

namespace meshloop {

/// Names a node for the life of the scene; never used again after the node is gone. Starts at 1.
using NodeId = std::uint64_t;
/// Counts the accepted changes of a scene. An imported model is revision 1; an empty scene is revision 0.
using Revision = std::uint64_t;

struct Shape;  // common/implicit/shape.h

/// A named piece of the model that moves rigidly.
struct Node {
  NodeId id = 0;
  std::string name;
  Pose T_world_node = Pose::Identity();
  std::shared_ptr<const Submesh> submesh;
  /// content_hash of the submesh, kept so that it is computed once.
  Hash hash{};
  /// The exact solid for which the submesh stands in; null for nodes that are triangles. Drawn by SceneRenderer; scene
  /// files and the network carry the submesh alone. A node whose submesh is replaced loses it.
  std::shared_ptr<const Shape> shape = nullptr;
};

/// All nodes at one revision, in the order of their ids. Immutable once made: shared as shared_ptr<const Model>.
struct Model {
  Revision revision = 0;
  std::vector<Node> nodes;

  [[nodiscard]] const Node* find(NodeId id) const;
  [[nodiscard]] std::size_t triangle_count() const;
};

/// A node with its hash. The submesh must be valid.
[[nodiscard]] Node make_node(NodeId id, std::string name, Submesh submesh, const Pose& T_world_node = Pose::Identity());

/// What one accepted change does to the model.
struct AddNode {
  Node node;
};
struct ReplaceSubmesh {
  NodeId id = 0;
  std::shared_ptr<const Submesh> submesh;
};
struct RemoveNode {
  NodeId id = 0;
};
struct MoveNode {
  NodeId id = 0;
  Pose T_world_node = Pose::Identity();
};
using Edit = std::variant<AddNode, ReplaceSubmesh, RemoveNode, MoveNode>;

/// A model with the edits applied in order and `revision` set; nodes that no edit names share their geometry with the
/// old model. Refuses an id that is unknown, or used already, and a submesh that is not valid.
[[nodiscard]] Result<Model> apply(const Model& model, const std::vector<Edit>& edits, Revision revision);

}  // namespace meshloop
