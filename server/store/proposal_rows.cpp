#include "server/store/proposal_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "server/store/blobs.h"
#include "server/store/journal.h"

namespace meshloop {
namespace {

constexpr std::string_view kNextProposalId = "next_proposal_id";
/// From kAcceptedContent on what the revision accepted, null unless the proposal is an accepted one.
constexpr std::string_view kColumns =
    "SELECT p.proposal_id, p.kind, p.nodes, p.box, p.effect, p.confidence, p.largest_change_m, p.transform, p.state, "
    "p.first_seen_ns, p.last_seen_ns, p.revision, p.author, p.decided_ns, p.reason, "
    "a.kind, a.nodes, a.box, a.effect, a.confidence, a.largest_change_m, a.transform FROM proposal p "
    "LEFT JOIN accepted_proposal a "
    "ON p.state = 1 AND a.revision = p.revision AND a.proposal_id = p.proposal_id ";
constexpr int kAcceptedContent = 15;

tl::unexpected<Error> damaged(const Database& database) {
  return fail(fmt::format("'{}' is damaged (a proposal is none); restore it from a copy", database.file().string()));
}

std::vector<double> box_values(const Eigen::AlignedBox3d& box) {
  return {box.min().x(), box.min().y(), box.min().z(), box.max().x(), box.max().y(), box.max().z()};
}

bool is_box(const Eigen::AlignedBox3d& box) {
  return !box.isEmpty() && box.min().allFinite() && box.max().allFinite();
}

std::int64_t number(std::uint64_t id) {
  return static_cast<std::int64_t>(id);
}

/// Blobs that a statement reads while it runs.
struct Blobs {
  std::vector<double> box;
  std::vector<double> transform;
};

void bind_content(Statement& statement, const ProposalContent& content, Blobs& blobs) {
  blobs.box = box_values(content.box_m);
  statement.bind(static_cast<std::int64_t>(content.kind))
      .bind(blob_of(content.nodes))
      .bind(blob_of(blobs.box))
      .bind(std::string_view{content.effect})
      .bind(content.confidence)
      .bind(content.largest_change_m);
  if (content.T_world_new_old) {
    blobs.transform = pose_values(*content.T_world_new_old);
    statement.bind(blob_of(blobs.transform));
  } else {
    statement.bind_null();
  }
}

/// Columns from `first` on, in the order of bind_content; nothing when the file contradicts itself.
std::optional<ProposalContent> content_of(const Statement& row, int first) {
  const auto kind = row.integer(first);
  const auto nodes = from_blob<NodeId>(row.blob(first + 1));
  const auto box = from_blob<double>(row.blob(first + 2));
  if (kind < 0 || kind > static_cast<std::int64_t>(ProposalKind::move) || !nodes || !box || box->size() != 6) {
    return std::nullopt;
  }
  ProposalContent content;
  content.kind = static_cast<ProposalKind>(kind);
  content.nodes = *nodes;
  const auto& b = *box;
  content.box_m = {Eigen::Vector3d{b[0], b[1], b[2]}, Eigen::Vector3d{b[3], b[4], b[5]}};
  content.effect = row.text(first + 3);
  content.confidence = row.real(first + 4);
  content.largest_change_m = row.real(first + 5);
  if (!row.is_null(first + 6)) {
    content.T_world_new_old = pose_from_blob(row.blob(first + 6));
    if (!content.T_world_new_old) return std::nullopt;
  }
  return is_box(content.box_m) ? std::optional{std::move(content)} : std::nullopt;
}

std::optional<ProposalRecord> record_of(const Statement& row) {
  const auto state = row.integer(8);
  auto content = content_of(row, 1);
  // The table keeps what the proposal is recognised by; what was accepted may have been measured from elsewhere.
  if (content && !row.is_null(kAcceptedContent)) content = content_of(row, kAcceptedContent);
  if (!content || row.integer(0) < 1 || state < 0 || state > static_cast<std::int64_t>(ProposalState::rejected)) {
    return std::nullopt;
  }
  ProposalRecord record;
  record.id = static_cast<ProposalId>(row.integer(0));
  record.content = std::move(*content);
  record.state = static_cast<ProposalState>(state);
  record.first_seen_ns = row.integer(9);
  record.last_seen_ns = row.integer(10);
  if (!row.is_null(11)) record.revision = static_cast<Revision>(row.integer(11));
  record.author = row.text(12);
  record.decided_ns = row.integer(13);
  record.reason = row.text(14);
  if (record.state == ProposalState::accepted && !record.revision) return std::nullopt;
  return record;
}

Result<ProposalRecord> read_one(Database& database, ProposalId id) {
  auto query = database.prepare(fmt::format("{}WHERE p.proposal_id = ?", kColumns));
  if (!query) return fail(query.error());
  const auto row = query->bind(number(id)).step();
  if (!row) return fail(row.error());
  if (!*row) return fail(fmt::format("'{}' has no proposal {}", database.file().string(), id));
  auto record = record_of(*query);
  if (!record) return damaged(database);
  return std::move(*record);
}

Result<ProposalRecord> read_undecided(Database& database, ProposalId id) {
  auto record = read_one(database, id);
  if (record && record->state == ProposalState::accepted) {
    return fail(fmt::format("proposal {} was accepted by revision {}", id, *record->revision));
  }
  return record;
}

Status insert_new(Database& database, ProposalId id, const ProposalSighting& sighting, std::int64_t now_ns) {
  ProposalRecord decision;
  if (sighting.piece_of_rejected) {
    auto rejected = read_undecided(database, *sighting.piece_of_rejected);
    if (!rejected) return fail(rejected.error());
    decision = std::move(*rejected);
    decision.reason = fmt::format("a piece of proposal {}", decision.id);
  }
  auto insert = database.prepare("INSERT INTO proposal VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, NULL, ?, ?, ?)");
  if (!insert) return fail(insert.error());
  Blobs blobs;
  insert->bind(number(id));
  bind_content(*insert, sighting.content, blobs);
  const auto state = sighting.piece_of_rejected ? decision.state : ProposalState::open;
  return insert->bind(static_cast<std::int64_t>(state))
      .bind(now_ns)
      .bind(now_ns)
      .bind(std::string_view{decision.author})
      .bind(decision.decided_ns)
      .bind(std::string_view{decision.reason})
      .run();
}

Status see_again(Database& database, const ProposalSighting& sighting, std::int64_t now_ns) {
  const auto known = read_undecided(database, *sighting.known);
  if (!known) return fail(known.error());
  auto update = database.prepare(
      "UPDATE proposal SET kind = ?, nodes = ?, box = ?, effect = ?, confidence = ?, largest_change_m = ?, "
      "transform = ?, last_seen_ns = ? WHERE proposal_id = ?");
  if (!update) return fail(update.error());
  Blobs blobs;
  // What was rejected is what later measurements are compared with: it must not creep away.
  bind_content(*update, known->state == ProposalState::open ? sighting.content : known->content, blobs);
  return update->bind(std::max(now_ns, known->last_seen_ns)).bind(number(known->id)).run();
}

Status decide(Database& database, ProposalId id, ProposalState state, const std::optional<Revision>& revision,
              const std::string& author, const std::string& reason, std::int64_t now_ns) {
  auto update = database.prepare(
      "UPDATE proposal SET state = ?, revision = coalesce(?, revision), author = ?, reason = ?, decided_ns = ? "
      "WHERE proposal_id = ?");
  if (!update) return fail(update.error());
  update->bind(static_cast<std::int64_t>(state));
  if (revision) {
    update->bind(number(*revision));
  } else {
    update->bind_null();
  }
  return update->bind(std::string_view{author}).bind(std::string_view{reason}).bind(now_ns).bind(number(id)).run();
}

/// Redo brings back what was accepted; it does not take back what somebody decided since.
Status check_not_rejected(Database& database, ProposalId id) {
  const auto record = read_one(database, id);
  if (!record) return fail(record.error());
  if (record->state != ProposalState::rejected) return {};
  return fail(
      fmt::format("redo would accept proposal {}, which was rejected by {} since; accept by their ids what shall "
                  "be there again",
                  id, record->author));
}

/// What this revision accepted is in that state from now on, decided by this author at this time.
Status decide_all_of(Database& database, Revision revision, ProposalState state, const std::string& author,
                     std::int64_t decided_ns) {
  auto query = database.prepare("SELECT proposal_id FROM proposal WHERE revision = ? ORDER BY proposal_id");
  if (!query) return fail(query.error());
  query->bind(number(revision));
  std::vector<ProposalId> ids;
  for (;;) {
    const auto row = query->step();
    if (!row) return fail(row.error());
    if (!*row) break;
    ids.push_back(static_cast<ProposalId>(query->integer(0)));
  }
  for (const auto id : ids) {
    if (state == ProposalState::accepted) {
      if (auto ok = check_not_rejected(database, id); !ok) return ok;
    }
    if (auto ok = decide(database, id, state, revision, author, {}, decided_ns); !ok) return ok;
  }
  return {};
}

}  // namespace

Result<std::vector<ProposalRecord>> read_proposals(Database& database) {
  auto query = database.prepare(fmt::format("{}ORDER BY p.proposal_id", kColumns));
  if (!query) return fail(query.error());
  std::vector<ProposalRecord> records;
  for (;;) {
    const auto row = query->step();
    if (!row) return fail(row.error());
    if (!*row) return records;
    auto record = record_of(*query);
    if (!record) return damaged(database);
    records.push_back(std::move(*record));
  }
}

Result<std::vector<ProposalId>> remember_proposals(Database& database, const std::vector<ProposalSighting>& seen,
                                                   std::int64_t now_ns) {
  auto next_id = read_counter(database, kNextProposalId);
  if (!next_id) return fail(next_id.error());
  if (*next_id == 0) return damaged(database);
  std::vector<ProposalId> ids;
  for (const auto& sighting : seen) {
    if (!is_box(sighting.content.box_m)) return fail("a proposal needs a box in the world");
    ids.push_back(sighting.known ? *sighting.known : (*next_id)++);
    const auto done =
        sighting.known ? see_again(database, sighting, now_ns) : insert_new(database, ids.back(), sighting, now_ns);
    if (!done) return fail(done.error());
  }
  if (auto ok = write_counter(database, kNextProposalId, *next_id); !ok) return fail(ok.error());
  return ids;
}

Status reject_proposals(Database& database, const std::vector<ProposalId>& ids, const std::string& author,
                        const std::string& reason, std::int64_t now_ns) {
  for (const auto id : ids) {
    if (const auto there = read_undecided(database, id); !there) return fail(there.error());
    if (auto ok = decide(database, id, ProposalState::rejected, std::nullopt, author, reason, now_ns); !ok) return ok;
  }
  return {};
}

Status accept_proposals(Database& database, Revision revision, const std::string& author, std::int64_t now_ns,
                        const std::vector<AcceptedProposal>& accepted) {
  auto insert = database.prepare("INSERT INTO accepted_proposal VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?)");
  if (!insert) return fail(insert.error());
  for (const auto& [id, content] : accepted) {
    if (const auto there = read_undecided(database, id); !there) return fail(there.error());
    if (!is_box(content.box_m)) return fail("a proposal needs a box in the world");
    if (auto ok = decide(database, id, ProposalState::accepted, revision, author, {}, now_ns); !ok) return ok;
    insert->reset();
    Blobs blobs;
    insert->bind(number(revision)).bind(number(id));
    bind_content(*insert, content, blobs);
    if (auto ok = insert->run(); !ok) return ok;
  }
  return {};
}

Status reopen_proposals(Database& database, Revision revision, const std::string& author, std::int64_t now_ns) {
  return decide_all_of(database, revision, ProposalState::open, author, now_ns);
}

Status close_proposals_again(Database& database, Revision revision) {
  const auto accepting = read_info(database, revision);
  if (!accepting) return fail(accepting.error());
  return decide_all_of(database, revision, ProposalState::accepted, accepting->author, accepting->accepted_ns);
}

Result<std::vector<AcceptedProposal>> read_accepted(Database& database, Revision revision) {
  auto query = database.prepare(
      "SELECT proposal_id, kind, nodes, box, effect, confidence, largest_change_m, transform FROM accepted_proposal "
      "WHERE revision = ? ORDER BY proposal_id");
  if (!query) return fail(query.error());
  query->bind(number(revision));
  std::vector<AcceptedProposal> accepted;
  for (;;) {
    const auto row = query->step();
    if (!row) return fail(row.error());
    if (!*row) return accepted;
    auto content = content_of(*query, 1);
    if (!content || query->integer(0) < 1) return damaged(database);
    accepted.push_back({static_cast<ProposalId>(query->integer(0)), std::move(*content)});
  }
}

}  // namespace meshloop
