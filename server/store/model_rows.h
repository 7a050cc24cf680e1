#pragma once
// Models in the tables `node` and `geometry`. A node's row holds from one revision up to another, so that a change
// costs rows for the changed nodes only, and a model at any revision is one query.
#include <memory>

#include "common/mesh/model.h"
#include "server/store/sqlite.h"

namespace meshloop {

/// The model at a revision. Nodes whose geometry `known` has too share it. Everything that comes from the file is
/// checked, geometry against its hash.
[[nodiscard]] Result<Model> read_model(Database& database, Revision revision, const Model& known);

/// Bit for bit the same nodes, whatever the revisions.
[[nodiscard]] bool same_content(const Model& a, const Model& b);

/// Ends the rows of nodes that differ in `after`, and adds their new ones, as of after.revision. In a transaction.
[[nodiscard]] Status write_difference(Database& database, const Model& before, const Model& after);

}  // namespace meshloop
