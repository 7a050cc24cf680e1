#include "server/store/sqlite.h"

#include <fmt/format.h>

#include <cctype>
#include <cstring>

namespace meshloop {
namespace {

constexpr int kBusyTimeout_ms = 2000;
/// Pages that the log may grow to before a commit moves them into the file: SQLite's own default.
constexpr int kCheckpointPages = 1000;
/// The same where commits do not wait for the disk. Rare, since the commit after it begins the log anew and waits.
constexpr sqlite3_int64 kLongestLog_bytes = 32 << 20;

/// What a result code means for the owner of the file.
std::string sentence(int code, const std::string& file, const char* detail) {
  switch (code & 0xff) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return fmt::format("'{}' is being written by another program; try again when it has finished", file);
    case SQLITE_FULL:
      return fmt::format("the disk is full: '{}' stays at its last revision", file);
    case SQLITE_IOERR:
      return fmt::format("the disk refused to read or write '{}' ({}); is it full or failing?", file, detail);
    case SQLITE_NOTADB:
      return fmt::format("'{}' is not a scene file", file);
    case SQLITE_CORRUPT:
      return fmt::format("'{}' is damaged ({}); restore it from a copy", file, detail);
    case SQLITE_READONLY:
    case SQLITE_PERM:
      return fmt::format("'{}' may not be written by this user", file);
    case SQLITE_CANTOPEN:
      return fmt::format("'{}' cannot be opened; check the permissions of the file and its folder", file);
    default:
      return fmt::format("'{}' cannot be used as a scene ({})", file, detail);
  }
}

int flags_of(Database::Access access) {
  switch (access) {
    case Database::Access::unlogged:
      return SQLITE_OPEN_READONLY | SQLITE_OPEN_URI;
    case Database::Access::read_only:
      return SQLITE_OPEN_READONLY;
    case Database::Access::read_write:
      return SQLITE_OPEN_READWRITE;
    case Database::Access::create:
      break;
  }
  return SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE;
}

/// The name as SQLite takes it with parameters.
std::string unlogged_uri(const std::filesystem::path& file) {
  std::string uri = "file://";  // without these two, a path that begins with two slashes names a host
  for (const char c : std::filesystem::absolute(file).string()) {
    const bool is_plain = std::isalnum(static_cast<unsigned char>(c)) != 0 || std::strchr("/._-", c) != nullptr;
    uri += is_plain ? std::string{c} : fmt::format("%{:02x}", static_cast<unsigned char>(c));
  }
  return uri + "?immutable=1";
}

}  // namespace

Result<Database> Database::open(const std::filesystem::path& file, Access access) {
  const std::string name = access == Access::unlogged ? unlogged_uri(file) : file.string();
  sqlite3* connection = nullptr;
  const int code = sqlite3_open_v2(name.c_str(), &connection, flags_of(access) | SQLITE_OPEN_EXRESCODE, nullptr);
  Database database{connection, file, access};
  if (code != SQLITE_OK) return fail(sentence(code, file.string(), sqlite3_errstr(code)));
  sqlite3_busy_timeout(connection, kBusyTimeout_ms);
  // The file may come from anywhere: its schema gets no rights.
  sqlite3_db_config(connection, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
  sqlite3_db_config(connection, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
  return database;
}

Error Database::error() const {
  return {ErrorKind::failed,
          sentence(sqlite3_extended_errcode(connection_.get()), file_.string(), sqlite3_errmsg(connection_.get()))};
}

Status Database::run(const char* sql) {
  if (sqlite3_exec(connection_.get(), sql, nullptr, nullptr, nullptr) != SQLITE_OK) return fail(error());
  return {};
}

Result<Statement> Database::prepare(std::string_view sql) {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(connection_.get(), sql.data(), static_cast<int>(sql.size()), &statement, nullptr) !=
      SQLITE_OK) {
    return fail(error());
  }
  return Statement{*this, statement};
}

Result<std::int64_t> Database::integer(std::string_view sql) {
  auto query = prepare(sql);
  if (!query) return fail(query.error());
  const auto row = query->step();
  if (!row) return fail(row.error());
  if (!*row) return fail(fmt::format("'{}' is damaged (a value is missing); restore it from a copy", file_.string()));
  return query->integer(0);
}

Status Database::sync_commits(bool wanted) {
  // A checkpoint would wait for the disk twice.
  sqlite3_wal_autocheckpoint(connection_.get(), wanted ? kCheckpointPages : 0);
  return run(wanted ? "PRAGMA synchronous=FULL" : "PRAGMA synchronous=NORMAL");
}

Status Database::sync() {
  // A checkpoint alone would not do: it leaves out what a reader still holds back.
  sqlite3_file* log = nullptr;
  sqlite3_file_control(connection_.get(), "main", SQLITE_FCNTL_JOURNAL_POINTER, static_cast<void*>(&log));
  if (log == nullptr || log->pMethods == nullptr) return {};  // nothing was written since the file was opened
  const int code = log->pMethods->xSync(log, SQLITE_SYNC_NORMAL);
  if (code != SQLITE_OK) return fail(sentence(code, file_.string(), sqlite3_errstr(code)));
  sqlite3_int64 log_bytes = 0;
  if (log->pMethods->xFileSize(log, &log_bytes) != SQLITE_OK || log_bytes < kLongestLog_bytes) return {};
  // Not moved into the file this time is no loss: the log has it, and a later one takes it along.
  sqlite3_wal_checkpoint_v2(connection_.get(), nullptr, SQLITE_CHECKPOINT_PASSIVE, nullptr, nullptr);
  return {};
}

void Database::checkpoint_on_close(bool wanted) {
  sqlite3_db_config(connection_.get(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, wanted ? 0 : 1, nullptr);
}

Statement& Statement::bind(std::int64_t value) {
  bind_failed_ |= sqlite3_bind_int64(statement_.get(), next_parameter_++, value) != SQLITE_OK;
  return *this;
}

Statement& Statement::bind(double value) {
  bind_failed_ |= sqlite3_bind_double(statement_.get(), next_parameter_++, value) != SQLITE_OK;
  return *this;
}

Statement& Statement::bind(std::string_view text) {
  bind_failed_ |= sqlite3_bind_text64(statement_.get(), next_parameter_++, text.data(), text.size(), SQLITE_STATIC,
                                      SQLITE_UTF8) != SQLITE_OK;
  return *this;
}

Statement& Statement::bind(std::span<const std::byte> blob) {
  // A null pointer would be NULL, not an empty blob.
  const void* data = blob.empty() ? "" : static_cast<const void*>(blob.data());
  bind_failed_ |=
      sqlite3_bind_blob64(statement_.get(), next_parameter_++, data, blob.size(), SQLITE_STATIC) != SQLITE_OK;
  return *this;
}

Statement& Statement::bind_null() {
  bind_failed_ |= sqlite3_bind_null(statement_.get(), next_parameter_++) != SQLITE_OK;
  return *this;
}

Result<bool> Statement::step() {
  if (bind_failed_) return fail(database_->error());
  const int code = sqlite3_step(statement_.get());
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  return fail(database_->error());
}

Status Statement::run() {
  const auto row = step();
  if (!row) return fail(row.error());
  return {};
}

void Statement::reset() {
  sqlite3_reset(statement_.get());
  sqlite3_clear_bindings(statement_.get());
  next_parameter_ = 1;
}

bool Statement::is_null(int column) const {
  return sqlite3_column_type(statement_.get(), column) == SQLITE_NULL;
}

std::int64_t Statement::integer(int column) const {
  return sqlite3_column_int64(statement_.get(), column);
}

double Statement::real(int column) const {
  return sqlite3_column_double(statement_.get(), column);
}

std::string Statement::text(int column) const {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_.get(), column));
  const int size = sqlite3_column_bytes(statement_.get(), column);
  return text == nullptr ? std::string{} : std::string{text, static_cast<std::size_t>(size)};
}

std::span<const std::byte> Statement::blob(int column) const {
  const auto* data = static_cast<const std::byte*>(sqlite3_column_blob(statement_.get(), column));
  const int size = sqlite3_column_bytes(statement_.get(), column);
  if (data == nullptr) return {};
  return {data, static_cast<std::size_t>(size)};
}

Result<Transaction> Transaction::begin(Database& database, const char* sql) {
  if (auto ok = database.run(sql); !ok) return fail(ok.error());
  return Transaction{database};
}

Transaction::~Transaction() {
  if (database_ != nullptr && database_->in_transaction()) (void)database_->run("ROLLBACK");
}

Status Transaction::commit() {
  return database_->run("COMMIT");
}

}  // namespace meshloop
