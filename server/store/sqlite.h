#pragma once
// The little of SQLite's C interface that the store needs, with owners and Result values. Private to this folder.
#include <sqlite3.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/result.h"

namespace meshloop {

class Statement;

/// One connection. Not thread-safe.
class Database {
 public:
  /// unlogged: reads the file alone, without its log, locks and the files that these need; the caller makes sure that
  /// there is no log, and that nobody wrote to the file meanwhile.
  enum class Access { unlogged, read_only, read_write, create };
  [[nodiscard]] static Result<Database> open(const std::filesystem::path& file, Access access);

  /// Statements without results and parameters, separated by semicolons.
  [[nodiscard]] Status run(const char* sql);
  [[nodiscard]] Result<Statement> prepare(std::string_view sql);
  /// The single integer that a query or pragma gives.
  [[nodiscard]] Result<std::int64_t> integer(std::string_view sql);

  /// Whether each commit returns only when it is on the disk, and a long log is moved into the file by commits. Not
  /// within a transaction.
  [[nodiscard]] Status sync_commits(bool wanted);
  /// Brings to the disk what was committed while that was not wanted, and moves a long log into the file.
  [[nodiscard]] Status sync();
  /// Whether the last connection that closes moves the log into the file.
  void checkpoint_on_close(bool wanted);
  /// True between a BEGIN and its end.
  [[nodiscard]] bool in_transaction() const { return sqlite3_get_autocommit(connection_.get()) == 0; }
  /// The last error as one sentence that names the file.
  [[nodiscard]] Error error() const;
  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  [[nodiscard]] Access access() const { return access_; }

 private:
  struct Close {
    void operator()(sqlite3* connection) const { sqlite3_close(connection); }
  };
  Database(sqlite3* connection, std::filesystem::path file, Access access)
      : connection_{connection}, file_{std::move(file)}, access_{access} {}

  std::unique_ptr<sqlite3, Close> connection_;
  std::filesystem::path file_;
  Access access_;
};

/// A prepared statement. Bound memory must live until the next step. An error in binding shows at the next step.
class Statement {
 public:
  Statement(Database& database, sqlite3_stmt* statement) : database_{&database}, statement_{statement} {}

  /// Parameters in their order.
  Statement& bind(std::int64_t value);
  Statement& bind(double value);
  Statement& bind(std::string_view text);
  Statement& bind(std::span<const std::byte> blob);
  Statement& bind_null();

  /// True: a row is there. False: done.
  [[nodiscard]] Result<bool> step();
  /// For statements that give no rows.
  [[nodiscard]] Status run();
  /// Ready for other parameters.
  void reset();

  [[nodiscard]] bool is_null(int column) const;
  [[nodiscard]] std::int64_t integer(int column) const;
  [[nodiscard]] double real(int column) const;
  [[nodiscard]] std::string text(int column) const;
  /// Valid until the next step.
  [[nodiscard]] std::span<const std::byte> blob(int column) const;

 private:
  struct Finalize {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };
  Database* database_;
  std::unique_ptr<sqlite3_stmt, Finalize> statement_;
  int next_parameter_ = 1;
  bool bind_failed_ = false;
};

/// Takes back what was not committed.
class Transaction {
 public:
  /// `sql`: BEGIN (a snapshot for reading) or BEGIN IMMEDIATE (for writing).
  [[nodiscard]] static Result<Transaction> begin(Database& database, const char* sql);
  ~Transaction();
  Transaction(Transaction&& other) noexcept : database_{std::exchange(other.database_, nullptr)} {}
  Transaction& operator=(Transaction&&) = delete;

  /// Returns when the changes are on the disk (see Database::sync_commits).
  [[nodiscard]] Status commit();

 private:
  explicit Transaction(Database& database) : database_{&database} {}
  Database* database_;
};

}  // namespace meshloop
