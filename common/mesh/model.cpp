#include "common/mesh/model.h"

#include <fmt/format.h>

#include <algorithm>

namespace meshloop {
namespace {

auto position_of(Model& model, NodeId id) {
  return std::lower_bound(model.nodes.begin(), model.nodes.end(), id,
                          [](const Node& node, NodeId wanted) { return node.id < wanted; });
}

Result<Node*> find_node(Model& model, NodeId id) {
  const auto it = position_of(model, id);
  if (it == model.nodes.end() || it->id != id) return fail(fmt::format("the model has no node {}", id));
  return &*it;
}

Status apply_one(Model& model, const AddNode& edit) {
  if (edit.node.id == 0 || !edit.node.submesh) return fail("a new node needs an id and a submesh");
  if (!is_rigid(edit.node.T_world_node)) return fail("a new node's transform is not rigid");
  if (auto ok = validate(*edit.node.submesh); !ok) return ok;
  const auto it = position_of(model, edit.node.id);
  if (it != model.nodes.end() && it->id == edit.node.id) {
    return fail(fmt::format("the model has a node {} already", edit.node.id));
  }
  model.nodes.insert(it, edit.node);
  return {};
}

Status apply_one(Model& model, const ReplaceSubmesh& edit) {
  auto node = find_node(model, edit.id);
  if (!node) return fail(node.error());
  if (!edit.submesh) return fail("a replaced node needs a submesh");
  if (auto ok = validate(*edit.submesh); !ok) return ok;
  (*node)->submesh = edit.submesh;
  (*node)->hash = content_hash(*edit.submesh);
  (*node)->shape = nullptr;
  return {};
}

Status apply_one(Model& model, const RemoveNode& edit) {
  if (auto node = find_node(model, edit.id); !node) return fail(node.error());
  model.nodes.erase(position_of(model, edit.id));
  return {};
}

Status apply_one(Model& model, const MoveNode& edit) {
  auto node = find_node(model, edit.id);
  if (!node) return fail(node.error());
  if (!is_rigid(edit.T_world_node)) return fail("the transform is not rigid");
  (*node)->T_world_node = edit.T_world_node;
  return {};
}

}  // namespace

const Node* Model::find(NodeId id) const {
  const auto it = std::find_if(nodes.begin(), nodes.end(), [id](const Node& node) { return node.id == id; });
  return it == nodes.end() ? nullptr : &*it;
}

std::size_t Model::triangle_count() const {
  std::size_t count = 0;
  for (const auto& node : nodes) count += node.submesh->triangles.size();
  return count;
}

Node make_node(NodeId id, std::string name, Submesh submesh, const Pose& T_world_node) {
  const Hash hash = content_hash(submesh);
  return {id, std::move(name), T_world_node, std::make_shared<const Submesh>(std::move(submesh)), hash};
}

Result<Model> apply(const Model& model, const std::vector<Edit>& edits, Revision revision) {
  Model changed = model;
  changed.revision = revision;
  for (const auto& edit : edits) {
    const auto done = std::visit([&](const auto& one) { return apply_one(changed, one); }, edit);
    if (!done) return fail(done.error());
  }
  return changed;
}

}  // namespace meshloop
