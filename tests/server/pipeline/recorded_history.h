#pragma once
// What a scene must show, kept without the store: bytes of models, a list of steps, a position in it.
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "common/mesh/model.h"

namespace meshloop::test {

/// All bits of a node.
struct RecordedNode {
  std::string name;
  std::vector<std::byte> pose;
  std::vector<std::byte> positions;
  std::vector<std::byte> colors;
  std::vector<std::byte> triangles;
  Hash hash{};

  bool operator==(const RecordedNode&) const = default;
};
[[nodiscard]] RecordedNode record(const Node& node);

/// All bits of a model but its revision. Nodes that did not change are shared.
using RecordedModel = std::map<NodeId, std::shared_ptr<const RecordedNode>>;
/// What is different, in a few words; empty when nothing is.
[[nodiscard]] std::string difference(const RecordedModel& recorded, const Model& model);

/// The rules of accept, undo, redo and restore as an operator knows them: steps in a row, of which a change cuts off
/// those that were undone.
class RecordedHistory {
 public:
  [[nodiscard]] const RecordedModel& present() const { return revisions_.back(); }
  [[nodiscard]] Revision last() const { return revisions_.size() - 1; }
  [[nodiscard]] const RecordedModel& at(Revision revision) const { return revisions_.at(revision); }

  void accept(const std::vector<Edit>& edits);
  /// False, and nothing happens, when the store must refuse.
  [[nodiscard]] bool undo();
  [[nodiscard]] bool redo();
  [[nodiscard]] bool restore(Revision revision);

 private:
  void add_step(RecordedModel model);

  /// What each revision shows; revision 0 is the empty scene.
  std::vector<RecordedModel> revisions_{{}};
  std::vector<RecordedModel> steps_{{}};
  std::size_t position_ = 0;
};

}  // namespace meshloop::test
