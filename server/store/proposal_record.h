#pragma once
// What a scene remembers of proposals: one id for one proposed change, and what became of it.
#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/geometry/pose.h"
#include "common/mesh/model.h"

namespace meshloop {

/// From 1; never given to another proposal, in no revision and no run.
using ProposalId = std::uint64_t;

/// The numbers are those in the file.
enum class ProposalKind : std::uint8_t { insertion = 0, removal = 1, move = 2 };
enum class ProposalState : std::uint8_t { open = 0, accepted = 1, rejected = 2 };

[[nodiscard]] constexpr std::string_view name_of(ProposalKind kind) {
  return kind == ProposalKind::insertion ? "insertion" : kind == ProposalKind::removal ? "removal" : "move";
}
[[nodiscard]] constexpr std::string_view name_of(ProposalState state) {
  return state == ProposalState::open ? "open" : state == ProposalState::accepted ? "accepted" : "rejected";
}

/// What is proposed, as far as it is remembered.
struct ProposalContent {
  ProposalKind kind = ProposalKind::insertion;
  /// Nodes of the model that change; none for an insertion.
  std::vector<NodeId> nodes;
  /// Around what comes, goes or moves (where it was and where it is), in the world, metres; not empty.
  Eigen::AlignedBox3d box_m;
  /// A sentence for people.
  std::string effect;
  /// 0 to 1.
  double confidence = 0;
  double largest_change_m = 0;
  /// Of a move: from where it was to where it is, in the world.
  std::optional<Pose> T_world_new_old;
};

/// One proposal as it was seen in a snapshot.
struct ProposalSighting {
  /// The id that it has already; a new one is given otherwise.
  std::optional<ProposalId> known;
  /// A new one that is a piece of this rejected one is rejected with it.
  std::optional<ProposalId> piece_of_rejected;
  ProposalContent content;
};

struct ProposalRecord {
  ProposalId id = 0;
  /// As last seen while it was open; of a rejected one as it was when it was rejected, of an accepted one as the
  /// revision accepted it.
  ProposalContent content;
  ProposalState state = ProposalState::open;
  /// Since 1970 (UTC).
  std::int64_t first_seen_ns = 0;
  std::int64_t last_seen_ns = 0;
  /// That accepted it; of an open one: that accepted it and was undone.
  std::optional<Revision> revision;
  /// Who decided, when and why; empty and 0 when nobody has. Of an accepted one who made `revision`, and when, also
  /// after a redo; of an undone one who undid it.
  std::string author;
  std::int64_t decided_ns = 0;
  std::string reason;

  /// It was accepted, and somebody took that back.
  [[nodiscard]] bool was_undone() const { return state == ProposalState::open && revision.has_value(); }
};

/// A proposal that a revision accepted, as the journal keeps it.
struct AcceptedProposal {
  ProposalId id = 0;
  ProposalContent content;
};

}  // namespace meshloop
