#include "server/store/schema.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <system_error>

#include "common/base/file.h"
#include "server/store/proposal_schema.h"

namespace meshloop {
namespace {

namespace fs = std::filesystem;

/// "MLOP": how the file command and SQLite tell a scene from other SQLite files.
constexpr std::int64_t kApplicationId = 0x4d4c4f50;
constexpr std::int64_t kSchemaVersion = 4;
constexpr std::int64_t kVersionWithSnapshots = 2;
constexpr std::int64_t kVersionWithProposals = 3;
constexpr std::int64_t kVersionWithTextures = 4;

// README.md, "The file", describes the tables.
constexpr const char* kSchemaOfVersion1 = R"sql(
CREATE TABLE meta(key TEXT PRIMARY KEY, value INTEGER NOT NULL) STRICT, WITHOUT ROWID;
INSERT INTO meta VALUES('epoch', 0), ('next_node_id', 1);
CREATE TABLE revision(
  revision INTEGER PRIMARY KEY, parent INTEGER NOT NULL, content INTEGER NOT NULL, undo_content INTEGER,
  redo_revision INTEGER REFERENCES revision, accepted_ns INTEGER NOT NULL, author TEXT NOT NULL,
  summary TEXT NOT NULL, triangles_added INTEGER NOT NULL, triangles_removed INTEGER NOT NULL) STRICT;
CREATE TABLE picture(
  revision INTEGER NOT NULL REFERENCES revision, position INTEGER NOT NULL, png BLOB NOT NULL,
  PRIMARY KEY(revision, position)) STRICT;
CREATE TABLE geometry(
  hash BLOB PRIMARY KEY, positions BLOB NOT NULL, colors BLOB NOT NULL, triangles BLOB NOT NULL) STRICT;
CREATE TABLE node(
  node_id INTEGER NOT NULL, from_revision INTEGER NOT NULL REFERENCES revision,
  to_revision INTEGER REFERENCES revision, name TEXT NOT NULL, transform BLOB NOT NULL,
  geometry BLOB NOT NULL REFERENCES geometry, PRIMARY KEY(node_id, from_revision)) STRICT;
CREATE INDEX node_present ON node(node_id) WHERE to_revision IS NULL;
)sql";
constexpr const char* kFromVersion1To2 = R"sql(
CREATE TABLE calibration(hash BLOB PRIMARY KEY, rig TEXT NOT NULL) STRICT;
CREATE TABLE snapshot(
  revision INTEGER PRIMARY KEY REFERENCES revision, calibration BLOB NOT NULL REFERENCES calibration,
  timestamp_s REAL NOT NULL, state TEXT NOT NULL, pose BLOB NOT NULL, covariance BLOB NOT NULL, quality REAL NOT NULL,
  inliers INTEGER NOT NULL, refined_pose BLOB) STRICT;
)sql";
constexpr const char* kFromVersion3To4 = R"sql(
CREATE TABLE jpeg(hash BLOB PRIMARY KEY, bytes BLOB NOT NULL) STRICT;
CREATE TABLE texture(
  geometry BLOB PRIMARY KEY REFERENCES geometry, jpeg BLOB NOT NULL REFERENCES jpeg,
  projection BLOB NOT NULL) STRICT;
)sql";

/// What makes a scene of one version one of the next, from version 1 on.
constexpr std::array kSteps{kFromVersion1To2, kProposalTables, kFromVersion3To4};
static_assert(kSteps.size() == kSchemaVersion - 1);

Status take_steps(Database& database, std::int64_t from_version) {
  for (auto version = from_version; version < kSchemaVersion; ++version) {
    if (auto ok = database.run(kSteps[static_cast<std::size_t>(version - 1)]); !ok) return ok;
  }
  return database.run(fmt::format("PRAGMA user_version={}", kSchemaVersion).c_str());
}

tl::unexpected<Error> cannot_create(const fs::path& file, int error) {
  return fail(fmt::format("cannot make the scene '{}': {}", file.string(), std::generic_category().message(error)));
}

Status fill_new_file(const fs::path& file) {
  auto database = Database::open(file, Database::Access::create);
  if (!database) return fail(database.error());
  if (auto ok = database->run("PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; BEGIN"); !ok) return ok;
  if (auto ok = database->run(kSchemaOfVersion1); !ok) return ok;
  if (auto ok = take_steps(*database, 1); !ok) return ok;
  return database->run(fmt::format("PRAGMA application_id={}; COMMIT", kApplicationId).c_str());
}

void remove_with_companions(const fs::path& file) {
  std::error_code ignored;
  for (const char* ending : {"", "-wal", "-shm", "-journal"}) fs::remove(file.string() + ending, ignored);
}

/// Beside a new file of its name SQLite would take the log of a deleted one for that file's own.
Status check_no_log_is_left(const fs::path& file) {
  const fs::path log = file.string() + "-wal";
  std::error_code ignored;
  if (!fs::exists(log, ignored) || fs::exists(file, ignored)) return {};
  return fail(
      fmt::format("'{}' is left of a scene that was deleted or moved; put that back, or delete it too", log.string()));
}

Status check_identity(Database& database) {
  const auto id = database.integer("PRAGMA application_id");
  if (!id) return fail(id.error());
  const std::string file = database.file().string();
  if (*id != kApplicationId) return fail(fmt::format("'{}' is an SQLite file of another program, not a scene", file));
  const auto version = database.integer("PRAGMA user_version");
  if (!version) return fail(version.error());
  if (*version < 1 || *version > kSchemaVersion) {
    return fail(fmt::format("'{}' has schema version {}, and this program knows 1 to {}; use the program that wrote it",
                            file, *version, kSchemaVersion));
  }
  return {};
}

/// The check's answer without the line that only names the database.
std::string last_line(const std::string& text) {
  return text.substr(text.rfind('\n') + 1);
}

Status check_pages(Database& database) {
  auto check = database.prepare("PRAGMA quick_check(1)");
  if (!check) return fail(check.error());
  const auto row = check->step();
  if (!row) return fail(row.error());
  const std::string verdict = *row ? last_line(check->text(0)) : "no answer";
  if (verdict != "ok") {
    return fail(fmt::format("'{}' is damaged ({}); restore it from a copy", database.file().string(), verdict));
  }
  // A scene has neither, and what they would do is somebody else's will.
  const auto foreign = database.integer("SELECT count(*) FROM sqlite_schema WHERE type IN ('trigger', 'view')");
  if (!foreign) return fail(foreign.error());
  if (*foreign != 0) return fail(fmt::format("'{}' is not a scene this program made", database.file().string()));
  return {};
}

bool may_write(const fs::path& file) {
  return ::faccessat(AT_FDCWD, file.c_str(), W_OK, AT_EACCESS) == 0;
}

/// A log needs files beside the scene. Where none can be made, and none is left, nothing is lost without. Beside a
/// scene that may only be read none shall be made either: they would be the reader's, and keep the owner from writing.
bool must_be_read_unlogged(const fs::path& file) {
  // SQLite's files lie beside the file that symbolic links lead to.
  std::error_code unknown;
  const auto real = fs::canonical(file, unknown);
  if (unknown) return false;
  if (may_write(real.parent_path()) && may_write(real)) return false;
  std::error_code no_log;
  const auto log_bytes = fs::file_size(real.string() + "-wal", no_log);
  return no_log || log_bytes == 0;
}

Result<Database> open_unlogged(const fs::path& file) {
  auto database = Database::open(file, Database::Access::unlogged);
  if (!database) return fail(database.error());
  if (auto ok = check_identity(*database); !ok) return fail(ok.error());
  if (auto ok = database->run("PRAGMA cell_size_check=ON"); !ok) return fail(ok.error());
  if (auto ok = check_pages(*database); !ok) return fail(ok.error());
  return database;
}

Result<bool> has_version(Database& database, std::int64_t wanted) {
  const auto version = database.integer("PRAGMA user_version");
  if (!version) return fail(version.error());
  return *version >= wanted;
}

}  // namespace

Status create_scene_file(const fs::path& file) {
  if (auto ok = check_no_log_is_left(file); !ok) return ok;
  const auto folder = file.has_parent_path() ? file.parent_path() : fs::path{"."};
  const fs::path temporary = folder / fmt::format(".{}.{}.new", file.filename().string(), ::getpid());
  remove_with_companions(temporary);
  auto filled = fill_new_file(temporary);
  int error = 0;
  // A link, unlike a rename, never replaces a scene that appeared meanwhile.
  if (filled && ::link(temporary.c_str(), file.c_str()) != 0 && errno != EEXIST) error = errno;
  // Some file systems have no links.
  if (error == EPERM || error == ENOTSUP) error = ::rename(temporary.c_str(), file.c_str()) == 0 ? 0 : errno;
  remove_with_companions(temporary);
  if (!filled) return fail(fmt::format("cannot make the scene '{}'", file.string()), filled.error());
  if (error != 0) return cannot_create(file, error);
  sync_folder(folder);
  return {};
}

Status make_sure_it_is_there(const fs::path& file, bool create) {
  std::error_code error;
  const auto status = fs::status(file, error);
  if (fs::is_directory(status)) return fail(fmt::format("'{}' is a folder, not a scene", file.string()));
  if (!fs::exists(status)) {
    return create ? create_scene_file(file)
                  : fail(fmt::format("the scene '{}' does not exist; `scene import` makes one", file.string()));
  }
  if (!fs::is_regular_file(status)) {
    return fail(fmt::format("'{}' is not a regular file, hence not a scene", file.string()));
  }
  // SQLite would take an empty file for an empty database.
  if (fs::file_size(file, error) == 0) return fail(fmt::format("'{}' is empty, not a scene", file.string()));
  return {};
}

Result<Database> open_scene_file(const fs::path& file) {
  if (must_be_read_unlogged(file)) return open_unlogged(file);
  {
    // A connection that cannot write does not touch what turns out to be somebody else's.
    auto foreign = Database::open(file, Database::Access::read_only);
    if (!foreign) return fail(foreign.error());
    if (auto ok = check_identity(*foreign); !ok) return fail(ok.error());
  }
  auto database = Database::open(file, Database::Access::read_write);
  if (!database) return fail(database.error());
  database->checkpoint_on_close(false);
  // A log that was long once is cut when it begins anew.
  if (auto ok = database->run("PRAGMA synchronous=FULL; PRAGMA foreign_keys=ON; PRAGMA cell_size_check=ON; "
                              "PRAGMA journal_mode=WAL; PRAGMA journal_size_limit=0");
      !ok) {
    return fail(ok.error());
  }
  if (auto ok = check_pages(*database); !ok) return fail(ok.error());
  return database;
}

Result<bool> has_snapshots(Database& database) {
  return has_version(database, kVersionWithSnapshots);
}

Result<bool> has_proposals(Database& database) {
  return has_version(database, kVersionWithProposals);
}

Result<bool> has_textures(Database& database) {
  return has_version(database, kVersionWithTextures);
}

Status bring_up_to_date(Database& database) {
  const auto version = database.integer("PRAGMA user_version");
  if (!version) return fail(version.error());
  return *version < kSchemaVersion ? take_steps(database, *version) : Status{};
}

}  // namespace meshloop
