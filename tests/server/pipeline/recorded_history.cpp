#include "recorded_history.h"

#include <fmt/format.h>

#include <cstring>
#include <span>

namespace meshloop::test {
namespace {

template <class T>
std::vector<std::byte> bytes_of(std::span<const T> values) {
  std::vector<std::byte> bytes(values.size_bytes());
  if (!bytes.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

std::vector<std::byte> bytes_of(const Pose& pose) {
  return bytes_of(std::span<const double>{pose.data(), 16});
}

void set_geometry(RecordedNode& node, const Submesh& submesh) {
  node.positions = bytes_of(std::span<const Eigen::Vector3f>{submesh.positions});
  node.colors = bytes_of(std::span<const Rgb8>{submesh.colors});
  node.triangles = bytes_of(std::span<const Triangle>{submesh.triangles});
  node.hash = content_hash(submesh);
}

struct Apply {
  RecordedModel& model;

  RecordedNode& changed(NodeId id) const {
    auto copy = std::make_shared<RecordedNode>(*model.at(id));
    RecordedNode& node = *copy;
    model[id] = std::move(copy);
    return node;
  }
  void operator()(const AddNode& edit) const {
    model[edit.node.id] = std::make_shared<const RecordedNode>(record(edit.node));
  }
  void operator()(const ReplaceSubmesh& edit) const { set_geometry(changed(edit.id), *edit.submesh); }
  void operator()(const RemoveNode& edit) const { model.erase(edit.id); }
  void operator()(const MoveNode& edit) const { changed(edit.id).pose = bytes_of(edit.T_world_node); }
};

bool same(const RecordedModel& a, const RecordedModel& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const auto& one, const auto& other) {
    return one.first == other.first && *one.second == *other.second;
  });
}

}  // namespace

RecordedNode record(const Node& node) {
  RecordedNode recorded;
  recorded.name = node.name;
  recorded.pose = bytes_of(node.T_world_node);
  set_geometry(recorded, *node.submesh);
  return recorded;
}

std::string difference(const RecordedModel& recorded, const Model& model) {
  if (recorded.size() != model.nodes.size())
    return fmt::format("{} nodes, not {}", model.nodes.size(), recorded.size());
  for (const auto& node : model.nodes) {
    const auto there = recorded.find(node.id);
    if (there == recorded.end()) return fmt::format("node {} should not be there", node.id);
    RecordedNode now = record(node);
    if (now != *there->second) return fmt::format("node {} has other bits", node.id);
    if (node.hash != now.hash) return fmt::format("node {} has another hash than its submesh", node.id);
  }
  return {};
}

void RecordedHistory::add_step(RecordedModel model) {
  steps_.resize(position_ + 1);
  steps_.push_back(model);
  ++position_;
  revisions_.push_back(std::move(model));
}

void RecordedHistory::accept(const std::vector<Edit>& edits) {
  RecordedModel model = present();
  for (const auto& edit : edits) std::visit(Apply{model}, edit);
  add_step(std::move(model));
}

bool RecordedHistory::undo() {
  if (position_ == 0) return false;
  revisions_.push_back(steps_[--position_]);
  return true;
}

bool RecordedHistory::redo() {
  if (position_ + 1 == steps_.size()) return false;
  revisions_.push_back(steps_[++position_]);
  return true;
}

bool RecordedHistory::restore(Revision revision) {
  if (revision > last() || same(at(revision), present())) return false;
  add_step(at(revision));
  return true;
}

}  // namespace meshloop::test
