#pragma once
// The tables `snapshot` and `calibration`: what a revision was measured with.
#include <optional>

#include "server/store/scene_store.h"
#include "server/store/sqlite.h"

namespace meshloop {

/// Nothing for a revision without a snapshot. What comes from the file is checked, a calibration against its hash. The
/// scene must have the tables (has_snapshots).
[[nodiscard]] Result<std::optional<SnapshotInfo>> read_snapshot(Database& database, Revision revision);

/// In a transaction. Refuses a pose that is lost, not rigid, or whose covariance is not finite.
[[nodiscard]] Status append_snapshot(Database& database, Revision revision, const SnapshotInfo& snapshot);

}  // namespace meshloop
