#pragma once
// What a scene remembers: `scene log` and `scene proposals`.
#include <optional>
#include <string>

#include "server/store/scene_store.h"

namespace meshloop {

/// Whether undo (`back`) or redo would leave nothing of a model. Devices place themselves by it, so the running station
/// refuses that.
[[nodiscard]] Result<bool> would_empty(const SceneStore& store, bool back);

/// The journal on stdout; with a folder the snapshots' pictures are written there, as they are stored:
/// "revision_0002_1.png". Nothing else in the folder is touched. A picture that cannot be read as a PNG is named in a
/// warning and not written; the rest is, and the journal told, before that is an error.
[[nodiscard]] Status print_log(const SceneStore& store, bool json, const std::string& pictures_folder);

/// All proposals, or those of one state, on stdout.
[[nodiscard]] Status print_proposals(const SceneStore& store, bool json, std::optional<ProposalState> state);

}  // namespace meshloop
