#include "server/store/returns.h"

#include <fmt/format.h>

namespace meshloop {
namespace {

std::size_t triangles_of(const Node* node) {
  return node == nullptr ? 0 : node->submesh->triangles.size();
}

/// Triangles that nodes of `more` have above what the same nodes of `less` have.
std::size_t triangles_above(const Model& more, const Model& less) {
  std::size_t above = 0;
  for (const auto& node : more.nodes) {
    const std::size_t here = triangles_of(&node);
    const std::size_t there = triangles_of(less.find(node.id));
    if (here > there) above += here - there;
  }
  return above;
}

RevisionInfo info(std::string summary, const std::string& author, std::size_t added, std::size_t removed) {
  RevisionInfo info;
  info.author = author;
  info.summary = std::move(summary);
  info.triangles_added = added;
  info.triangles_removed = removed;
  return info;
}

}  // namespace

RevisionInfo info_of_undo(const RevisionInfo& change, const std::string& author) {
  return info(fmt::format("undo of revision {}", change.revision), author, change.triangles_removed,
              change.triangles_added);
}

RevisionInfo info_of_redo(const RevisionInfo& change, const std::string& author) {
  return info(fmt::format("redo of revision {}", change.revision), author, change.triangles_added,
              change.triangles_removed);
}

RevisionInfo info_of_restore(Revision revision, const Model& before, const Model& after, const std::string& author) {
  return info(fmt::format("revision {} restored", revision), author, triangles_above(after, before),
              triangles_above(before, after));
}

}  // namespace meshloop
