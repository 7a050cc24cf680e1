#pragma once

namespace meshloop {

/// The tables of proposals (README.md, "The file"), and the counter of their ids.
inline constexpr const char* kProposalTables = R"sql(
INSERT INTO meta VALUES('next_proposal_id', 1);
CREATE TABLE proposal(
  proposal_id INTEGER PRIMARY KEY, kind INTEGER NOT NULL, nodes BLOB NOT NULL, box BLOB NOT NULL, effect TEXT NOT NULL,
  confidence REAL NOT NULL, largest_change_m REAL NOT NULL, transform BLOB, state INTEGER NOT NULL,
  first_seen_ns INTEGER NOT NULL, last_seen_ns INTEGER NOT NULL, revision INTEGER REFERENCES revision,
  author TEXT NOT NULL, decided_ns INTEGER NOT NULL, reason TEXT NOT NULL) STRICT;
CREATE TABLE accepted_proposal(
  revision INTEGER NOT NULL REFERENCES revision, proposal_id INTEGER NOT NULL REFERENCES proposal,
  kind INTEGER NOT NULL, nodes BLOB NOT NULL, box BLOB NOT NULL, effect TEXT NOT NULL, confidence REAL NOT NULL,
  largest_change_m REAL NOT NULL, transform BLOB, PRIMARY KEY(revision, proposal_id)) STRICT;
)sql";

}  // namespace meshloop
