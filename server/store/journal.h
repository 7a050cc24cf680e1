#pragma once
// The tables `revision`, `picture` and `meta`, and what snapshot_rows.h adds to a revision.
#include <optional>

#include "server/store/scene_store.h"
#include "server/store/sqlite.h"

namespace meshloop {

/// What undo and redo need to know about a revision.
struct Place {
  Revision revision = 0;
  /// The accepted change whose result this revision shows: itself, or for an undo or redo an earlier revision.
  Revision content = 0;
  /// What undo shows. Nothing before the first change.
  std::optional<Revision> undo_content;
  /// The revision that redo goes back to. Nothing unless changes are undone.
  std::optional<Revision> redo_revision;
};

struct JournalEntry {
  RevisionInfo info;
  Place place;
  /// The change that an undo takes back, or a redo brings again.
  std::optional<Revision> undoes = std::nullopt;
  std::optional<Revision> redoes = std::nullopt;
};

/// The last revision; an empty scene is revision 0.
[[nodiscard]] Result<Place> last_place(Database& database);
/// Refuses a revision that is not in the journal. Revision 0 always is.
[[nodiscard]] Result<Place> place_of(Database& database, Revision revision);

/// Oldest first, with pictures, snapshots and accepted proposals.
[[nodiscard]] Result<std::vector<RevisionInfo>> read_journal(Database& database);
/// One entry, without pictures and snapshot.
[[nodiscard]] Result<RevisionInfo> read_info(Database& database, Revision revision);
/// In a transaction. Refuses a snapshot without a pose. The info's proposals are accept_proposals' (proposal_rows.h).
[[nodiscard]] Status append_entry(Database& database, const JournalEntry& entry);

[[nodiscard]] Result<std::uint64_t> read_counter(Database& database, std::string_view name);
[[nodiscard]] Status write_counter(Database& database, std::string_view name, std::uint64_t value);

}  // namespace meshloop
