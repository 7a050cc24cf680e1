#include "server/store/journal.h"

#include <fmt/format.h>

#include <limits>

#include "server/store/blobs.h"
#include "server/store/proposal_rows.h"
#include "server/store/schema.h"
#include "server/store/snapshot_rows.h"

namespace meshloop {
namespace {

tl::unexpected<Error> damaged(const Database& database) {
  return fail(fmt::format("'{}' is damaged (its journal contradicts itself); restore it from a copy",
                          database.file().string()));
}

std::optional<Revision> optional_revision(const Statement& row, int column) {
  if (row.is_null(column)) return std::nullopt;
  return static_cast<Revision>(row.integer(column));
}

void bind_optional(Statement& statement, const std::optional<Revision>& value) {
  if (value) {
    statement.bind(static_cast<std::int64_t>(*value));
  } else {
    statement.bind_null();
  }
}

/// Undo and redo must lead to earlier revisions only, or they could run in circles.
Result<Place> checked(const Database& database, const Place& place) {
  const bool content_ok = place.content >= 1 ? place.content <= place.revision : place.revision > 0;
  const bool undo_ok = !place.undo_content || *place.undo_content < place.content;
  const bool redo_ok = !place.redo_revision || *place.redo_revision < place.revision;
  if (!content_ok || !undo_ok || !redo_ok || place.undo_content.has_value() != (place.content > 0)) {
    return damaged(database);
  }
  return place;
}

Result<Place> query_place(Database& database, Statement& query) {
  const auto row = query.step();
  if (!row) return fail(row.error());
  if (!*row) return Place{};
  return checked(database, {static_cast<Revision>(query.integer(0)), static_cast<Revision>(query.integer(1)),
                            optional_revision(query, 2), optional_revision(query, 3)});
}

RevisionInfo info_of(const Statement& row) {
  RevisionInfo info;
  info.revision = static_cast<Revision>(row.integer(0));
  info.parent = static_cast<Revision>(row.integer(1));
  info.accepted_ns = row.integer(2);
  info.author = row.text(3);
  if (info.author.empty()) info.author = "operator";  // as undo wrote it once
  info.summary = row.text(4);
  info.triangles_added = static_cast<std::size_t>(row.integer(5));
  info.triangles_removed = static_cast<std::size_t>(row.integer(6));
  return info;
}

Status read_pictures(Database& database, RevisionInfo& info) {
  auto query = database.prepare("SELECT png FROM picture WHERE revision = ? ORDER BY position");
  if (!query) return fail(query.error());
  query->bind(static_cast<std::int64_t>(info.revision));
  for (;;) {
    const auto row = query->step();
    if (!row) return fail(row.error());
    if (!*row) return {};
    const auto png = query->blob(0);
    info.pictures.emplace_back(png.begin(), png.end());
  }
}

Status append_pictures(Database& database, const RevisionInfo& info) {
  auto insert = database.prepare("INSERT INTO picture VALUES(?, ?, ?)");
  if (!insert) return fail(insert.error());
  for (std::size_t i = 0; i < info.pictures.size(); ++i) {
    insert->reset();
    insert->bind(static_cast<std::int64_t>(info.revision))
        .bind(static_cast<std::int64_t>(i))
        .bind(blob_of(info.pictures[i]));
    if (auto ok = insert->run(); !ok) return ok;
  }
  return {};
}

constexpr std::string_view kInfoColumns =
    "SELECT revision, parent, accepted_ns, author, summary, triangles_added, triangles_removed FROM revision ";
constexpr std::string_view kPlaceColumns = "SELECT revision, content, undo_content, redo_revision FROM revision ";

}  // namespace

Result<Place> last_place(Database& database) {
  auto query = database.prepare(fmt::format("{}ORDER BY revision DESC LIMIT 1", kPlaceColumns));
  if (!query) return fail(query.error());
  return query_place(database, *query);
}

Result<Place> place_of(Database& database, Revision revision) {
  if (revision == 0) return Place{};
  const auto unknown = fail(fmt::format("'{}' has no revision {}", database.file().string(), revision));
  if (revision > static_cast<Revision>(std::numeric_limits<std::int64_t>::max())) return unknown;
  auto query = database.prepare(fmt::format("{}WHERE revision = ?", kPlaceColumns));
  if (!query) return fail(query.error());
  query->bind(static_cast<std::int64_t>(revision));
  const auto place = query_place(database, *query);
  if (place && place->revision != revision) return unknown;
  return place;
}

Result<std::vector<RevisionInfo>> read_journal(Database& database) {
  auto query = database.prepare(fmt::format("{}ORDER BY revision", kInfoColumns));
  if (!query) return fail(query.error());
  const auto with_snapshots = has_snapshots(database);
  if (!with_snapshots) return fail(with_snapshots.error());
  const auto with_proposals = has_proposals(database);
  if (!with_proposals) return fail(with_proposals.error());
  std::vector<RevisionInfo> journal;
  for (;;) {
    const auto row = query->step();
    if (!row) return fail(row.error());
    if (!*row) return journal;
    RevisionInfo& info = journal.emplace_back(info_of(*query));
    if (auto ok = read_pictures(database, info); !ok) return fail(ok.error());
    if (!*with_snapshots) continue;
    auto snapshot = read_snapshot(database, info.revision);
    if (!snapshot) return fail(snapshot.error());
    info.snapshot = std::move(*snapshot);
    if (!*with_proposals) continue;
    auto proposals = read_accepted(database, info.revision);
    if (!proposals) return fail(proposals.error());
    info.proposals = std::move(*proposals);
  }
}

Result<RevisionInfo> read_info(Database& database, Revision revision) {
  auto query = database.prepare(fmt::format("{}WHERE revision = ?", kInfoColumns));
  if (!query) return fail(query.error());
  const auto row = query->bind(static_cast<std::int64_t>(revision)).step();
  if (!row) return fail(row.error());
  if (!*row) return damaged(database);
  return info_of(*query);
}

Status append_entry(Database& database, const JournalEntry& entry) {
  auto insert = database.prepare("INSERT INTO revision VALUES(?, ?, ?, ?, ?, ?, ?, ?, ?, ?)");
  if (!insert) return fail(insert.error());
  const auto& info = entry.info;
  const auto& place = entry.place;
  insert->bind(static_cast<std::int64_t>(info.revision))
      .bind(static_cast<std::int64_t>(info.parent))
      .bind(static_cast<std::int64_t>(place.content));
  bind_optional(*insert, place.undo_content);
  bind_optional(*insert, place.redo_revision);
  insert->bind(info.accepted_ns)
      .bind(std::string_view{info.author})
      .bind(std::string_view{info.summary})
      .bind(static_cast<std::int64_t>(info.triangles_added))
      .bind(static_cast<std::int64_t>(info.triangles_removed));
  if (auto ok = insert->run(); !ok) return ok;
  if (auto ok = append_pictures(database, info); !ok) return ok;
  return info.snapshot ? append_snapshot(database, info.revision, *info.snapshot) : Status{};
}

Result<std::uint64_t> read_counter(Database& database, std::string_view name) {
  auto query = database.prepare("SELECT value FROM meta WHERE key = ?");
  if (!query) return fail(query.error());
  const auto row = query->bind(name).step();
  if (!row) return fail(row.error());
  if (!*row || query->integer(0) < 0) return damaged(database);
  return static_cast<std::uint64_t>(query->integer(0));
}

Status write_counter(Database& database, std::string_view name, std::uint64_t value) {
  auto update = database.prepare("UPDATE meta SET value = ? WHERE key = ?");
  if (!update) return fail(update.error());
  return update->bind(static_cast<std::int64_t>(value)).bind(name).run();
}

}  // namespace meshloop
