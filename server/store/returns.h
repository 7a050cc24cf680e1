#pragma once
// What the journal says of revisions that show an earlier content again.
#include "server/store/scene_store.h"

namespace meshloop {

/// `change` is what undo takes back and redo brings again; its triangles count the other way round for undo.
[[nodiscard]] RevisionInfo info_of_undo(const RevisionInfo& change, const std::string& author);
[[nodiscard]] RevisionInfo info_of_redo(const RevisionInfo& change, const std::string& author);
/// Triangles: the net of each node, for of a submesh that became another one nobody knows which triangles are the same.
[[nodiscard]] RevisionInfo info_of_restore(Revision revision, const Model& before, const Model& after,
                                           const std::string& author);

}  // namespace meshloop
