#pragma once
// What a scene remembers: `scene log` and `scene proposals`.
#include <optional>
#include <string>

#include "server/store/scene_store.h"

namespace meshloop {

/// How the summary of an import begins in the journal.
inline constexpr const char* kImported = "imported ";
/// Why the running station does not take this change back: an import is what its devices place themselves by.
[[nodiscard]] std::optional<std::string> why_not_undone_live(const RevisionInfo& change);

/// The journal on stdout; with a folder the snapshots' pictures are written there, as they are stored:
/// "revision_0002_1.png". Nothing else in the folder is touched. A picture that cannot be read as a PNG is named in a
/// warning and not written; the rest is, and the journal told, before that is an error.
[[nodiscard]] Status print_log(const SceneStore& store, bool json, const std::string& pictures_folder);

/// All proposals, or those of one state, on stdout.
[[nodiscard]] Status print_proposals(const SceneStore& store, bool json, std::optional<ProposalState> state);

}  // namespace meshloop
