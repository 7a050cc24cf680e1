// What happens to a scene outside the plan: a full disk, a second program, a damaged file. killed_test.cpp: a killed
// process.
// damaged file.
#include <fmt/format.h>
#include <signal.h>
#include <sqlite3.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <functional>
#include <random>
#include <thread>

#include "scenes.h"

namespace meshloop {
namespace {
int counted_sync(long number, int fd);
}
}  // namespace meshloop

// In place of the C library's, for this program and the libraries that it uses.
extern "C" int fsync(int fd) {
  return meshloop::counted_sync(SYS_fsync, fd);
}
extern "C" int fdatasync(int fd) {
  return meshloop::counted_sync(SYS_fdatasync, fd);
}

namespace meshloop {
namespace {

using test::add;
using test::content_of;
using test::expect_same_content;
using test::open_or_die;
using test::write_content;

/// How often a log was brought to the disk, by any store of this program.
std::atomic<int> syncs_of_logs{0};
std::atomic<bool> syncs_fail{false};

int counted_sync(long number, int fd) {
  std::error_code error;
  const auto file = std::filesystem::read_symlink(fmt::format("/proc/self/fd/{}", fd), error);
  if (file.string().ends_with("-wal")) ++syncs_of_logs;
  if (syncs_fail) {
    errno = EIO;
    return -1;
  }
  return static_cast<int>(::syscall(number, fd));
}

class HardTimes : public test::SceneFolder {
 protected:
  std::string refusal(const std::filesystem::path& file) const {
    const auto store = SceneStore::open(file, true);
    return store ? std::string{} : store.error().message;
  }
  void run_sql(const std::string& sql) const {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(scene_.c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
    sqlite3_close(database);
  }
};

/// What the child says while the folder has these rights; for root, who may write everywhere, as nobody.
int exit_code_with_rights(int rights, const std::filesystem::path& folder, const std::function<bool()>& is_as_wanted) {
  std::filesystem::permissions(folder, static_cast<std::filesystem::perms>(rights));
  const pid_t child = ::fork();
  if (child == 0) {
    constexpr uid_t kNobody = 65534;
    if (::geteuid() == 0 && ::setuid(kNobody) != 0) ::_exit(2);
    ::_exit(is_as_wanted() ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  std::filesystem::permissions(folder, std::filesystem::perms{0755});
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST_F(HardTimes, AFolderThatMayNotBeWrittenCanBeRead) {
  const auto strange = folder_ / "a ?#%20 scene.db";
  {
    const auto store = open_or_die(strange);
    store->commit({add(1, 1)}, {}).value();
    store->commit({add(2, 2)}, {}).value();
  }
  EXPECT_EQ(exit_code_with_rights(0555, folder_,
                                  [&] {
                                    const auto store = SceneStore::open(strange, false);
                                    if (!store || (*store)->model()->nodes.size() != 2) return false;
                                    const auto first = (*store)->model_at(1);
                                    const auto log = (*store)->log();
                                    const bool reads = first && (*first)->nodes.size() == 1 && log && log->size() == 2;
                                    const auto undone = (*store)->undo("anna");
                                    return reads && !undone &&
                                           undone.error().message.find("cannot be written") != std::string::npos;
                                  }),
            0);
  EXPECT_EQ(open_or_die(strange)->model()->revision, 2u);
}

TEST_F(HardTimes, ReadingAFileThatMayNotBeWrittenLeavesNothingBesideIt) {
  open_or_die(scene_)->commit({add(1, 1)}, {}).value();
  std::filesystem::permissions(scene_, std::filesystem::perms{0444});
  EXPECT_EQ(exit_code_with_rights(0777, folder_,
                                  [&] {
                                    const auto store = SceneStore::open(scene_, false);
                                    return store && (*store)->model()->revision == 1 && (*store)->log();
                                  }),
            0);
  EXPECT_FALSE(std::filesystem::exists(scene_.string() + "-wal"));
  EXPECT_FALSE(std::filesystem::exists(scene_.string() + "-shm"));
  std::filesystem::permissions(scene_, std::filesystem::perms{0644});
  EXPECT_TRUE(open_or_die(scene_)->commit({add(2, 2)}, {}));
}

TEST_F(HardTimes, AReadingWithoutALogNoticesAWriter) {
  open_or_die(scene_)->commit({add(1, 1)}, {}).value();
  int ends[2];
  int answers[2];
  ASSERT_EQ(::pipe(ends), 0);
  ASSERT_EQ(::pipe(answers), 0);
  std::thread writer{[&] {
    char c = 0;
    if (::read(ends[0], &c, 1) != 1) return;
    std::filesystem::last_write_time(scene_, std::filesystem::file_time_type::clock::now());
    if (::write(answers[1], &c, 1) != 1) return;
  }};
  EXPECT_EQ(exit_code_with_rights(0555, folder_,
                                  [&] {
                                    const auto store = SceneStore::open(scene_, false);
                                    char c = 'x';
                                    if (::write(ends[1], &c, 1) != 1 || ::read(answers[0], &c, 1) != 1) return false;
                                    if (!store || !(*store)->model()) return false;
                                    const auto log = (*store)->log();
                                    return !log && log.error().message.find("try again") != std::string::npos;
                                  }),
            0);
  ::close(ends[1]);  // a child that did not ask must not keep the writer waiting
  writer.join();
  for (const int fd : {ends[0], answers[0], answers[1]}) ::close(fd);
}

TEST_F(HardTimes, SyncWaitsForTheDiskAndACommitWithoutItDoesNot) {
  const auto store = open_or_die(scene_);
  syncs_of_logs = 0;
  store->commit({add(1, 1)}, {}).value();
  EXPECT_GT(syncs_of_logs.exchange(0), 0);
  ASSERT_TRUE(store->commit_unsynced({add(2, 2, 80)}, {}));
  ASSERT_TRUE(store->commit_unsynced({add(3, 3, 80)}, {}));
  EXPECT_EQ(syncs_of_logs, 0);
  ASSERT_TRUE(store->sync());
  EXPECT_EQ(syncs_of_logs.exchange(0), 1);
  ASSERT_TRUE(store->sync());
  EXPECT_EQ(syncs_of_logs, 0) << "nothing was left to bring to the disk";
  EXPECT_TRUE(store->undo("anna"));
  EXPECT_GT(syncs_of_logs, 0) << "a later change waits again";
}

TEST_F(HardTimes, WhatAProcessThatDiedLeftUnsyncedIsSyncedByTheNext) {
  open_or_die(scene_)->commit({add(1, 1)}, {}).value();
  const pid_t child = ::fork();
  if (child == 0) {
    const auto store = SceneStore::open(scene_, false);
    (void)(*store)->commit_unsynced({add(2, 2)}, {});
    ::_exit(0);  // without closing the store
  }
  ::waitpid(child, nullptr, 0);
  const auto store = open_or_die(scene_, false);
  EXPECT_EQ(store->model()->revision, 2u);
  syncs_of_logs = 0;
  EXPECT_TRUE(store->sync());
  EXPECT_EQ(syncs_of_logs, 1);
}

TEST_F(HardTimes, ALongLogIsMovedIntoTheFileAndCut) {
  const auto store = open_or_die(scene_);
  std::filesystem::path log = scene_;
  log += "-wal";
  NodeId id = 1;
  std::uintmax_t longest = 0;
  // 2.5 MB each.
  for (; id <= 40; ++id) {
    ASSERT_TRUE(store->commit_unsynced({add(id, static_cast<int>(id), 250)}, {}));
    ASSERT_TRUE(store->sync());
    longest = std::max(longest, std::filesystem::file_size(log));
  }
  EXPECT_LT(longest, 40u << 20);
  EXPECT_GT(std::filesystem::file_size(scene_), 60u << 20);
  // Of some changes on, one at most is the first of a new log, which waits.
  syncs_of_logs = 0;
  for (const NodeId end = id + 4; id < end; ++id) ASSERT_TRUE(store->commit_unsynced({add(id, 1)}, {}));
  EXPECT_LE(syncs_of_logs, 1);
}

TEST_F(HardTimes, AReaderDoesNotKeepASyncFromItsWork) {
  const auto store = open_or_die(scene_);
  store->commit({add(1, 1)}, {}).value();
  sqlite3* reader = nullptr;
  ASSERT_EQ(sqlite3_open(scene_.c_str(), &reader), SQLITE_OK);
  ASSERT_EQ(sqlite3_exec(reader, "BEGIN; SELECT * FROM meta", nullptr, nullptr, nullptr), SQLITE_OK);
  ASSERT_TRUE(store->commit_unsynced({add(2, 2)}, {}));
  syncs_of_logs = 0;
  EXPECT_TRUE(store->sync());
  EXPECT_EQ(syncs_of_logs, 1);
  sqlite3_close(reader);
}

TEST_F(HardTimes, AFailedSyncIsFinal) {
  const auto store = open_or_die(scene_);
  store->commit({add(1, 1)}, {}).value();
  ASSERT_TRUE(store->commit_unsynced({add(2, 2)}, {}));
  syncs_fail = true;
  const auto failed = store->sync();
  syncs_fail = false;
  ASSERT_FALSE(failed);
  EXPECT_NE(failed.error().message.find("the disk refused"), std::string::npos) << failed.error().message;
  EXPECT_FALSE(store->sync()) << "the kernel reports a lost page once, and forgets it";
  EXPECT_FALSE(store->commit({add(3, 3)}, {}));
  EXPECT_FALSE(store->undo("anna"));
  EXPECT_EQ(store->model()->revision, 2u);
}

TEST_F(HardTimes, AFileThatWasDeletedOrReplacedTakesNoMoreChanges) {
  const auto away = scene_.parent_path() / "away.db";
  const auto store = open_or_die(scene_);
  store->commit({add(1, 1)}, {}).value();
  std::filesystem::rename(scene_, away);
  const auto moved = store->commit_unsynced({add(2, 2)}, {});
  ASSERT_FALSE(moved);
  EXPECT_NE(moved.error().message.find("deleted or moved"), std::string::npos) << moved.error().message;
  // Its log is still there, and would be taken for that of a new scene.
  EXPECT_NE(refusal(scene_).find("is left of a scene"), std::string::npos) << refusal(scene_);
  std::filesystem::copy_file(away, scene_);
  const auto replaced = store->undo("anna");
  ASSERT_FALSE(replaced);
  EXPECT_NE(replaced.error().message.find("replaced"), std::string::npos) << replaced.error().message;
  std::filesystem::rename(away, scene_);
  EXPECT_TRUE(store->commit({add(2, 2)}, {})) << "put back, it goes on";
}

TEST_F(HardTimes, ASymbolicLinkLeadsToTheSameLock) {
  const auto link = scene_.parent_path() / "link.db";
  const auto writer = open_or_die(scene_);
  writer->commit({add(1, 1)}, {}).value();
  std::filesystem::create_symlink(scene_, link);
  const auto refused = open_or_die(link, false)->undo("anna");
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("another program is writing"), std::string::npos) << refused.error().message;
}

TEST_F(HardTimes, ASceneWithoutALogGetsOne) {
  open_or_die(scene_)->commit({add(1, 1)}, {}).value();
  run_sql("PRAGMA journal_mode=DELETE");
  const auto store = open_or_die(scene_, false);
  ASSERT_TRUE(store->commit_unsynced({add(2, 2)}, {}));
  syncs_of_logs = 0;
  EXPECT_TRUE(store->sync());
  EXPECT_EQ(syncs_of_logs, 1);
}

TEST_F(HardTimes, AFullDiskKeepsTheLastRevision) {
  const auto committed = open_or_die(scene_)->commit({add(1, 1)}, {}).value();
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{400'000, 400'000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    auto store = SceneStore::open(scene_, false);
    if (!store) ::_exit(2);
    const auto too_large = (*store)->commit({add(2, 2, 150)}, {});
    if (too_large || too_large.error().message.find("full") == std::string::npos) ::_exit(3);
    if ((*store)->model()->revision != 1) ::_exit(4);
    ::_exit((*store)->commit({add(2, 2)}, {}) ? 0 : 5);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 0);
  const auto store = open_or_die(scene_, false);
  EXPECT_EQ(store->model()->revision, 2u);
  expect_same_content(*store->model_at(1).value(), *committed);
}

TEST_F(HardTimes, OneProgramWritesAndOthersRead) {
  const auto writer = open_or_die(scene_);
  writer->commit({add(1, 1)}, {}).value();
  {
    const auto other = open_or_die(scene_, false);
    EXPECT_EQ(other->log().value().size(), 1u);
    EXPECT_EQ(other->model()->nodes.size(), 1u);
    const auto refused = other->undo("anna");
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("another program is writing"), std::string::npos) << refused.error().message;
  }
  EXPECT_TRUE(writer->commit({add(2, 2)}, {}));
}

TEST_F(HardTimes, AStaleReaderMayNotWriteOverNewerRevisions) {
  const auto stale = open_or_die(scene_);
  open_or_die(scene_)->commit({add(1, 1)}, {}).value();
  const auto refused = stale->commit({add(1, 2)}, {});
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("open it again"), std::string::npos) << refused.error().message;
  EXPECT_EQ(stale->log().value().size(), 1u);
}

TEST_F(HardTimes, ForeignFilesAreRefusedUnchanged) {
  const auto refused_unchanged = [this](const std::string& content) {
    write_content(scene_, content);
    const auto message = refusal(scene_);
    EXPECT_EQ(content_of(scene_), content);
    return message;
  };
  EXPECT_NE(refused_unchanged("").find("empty"), std::string::npos);
  EXPECT_NE(refused_unchanged("# a text\n").find("not a scene"), std::string::npos);
  EXPECT_NE(refused_unchanged(std::string(5000, '\xff')).find("not a scene"), std::string::npos);
  std::filesystem::remove(scene_);
  run_sql("CREATE TABLE revision(revision INTEGER PRIMARY KEY)");
  EXPECT_NE(refused_unchanged(content_of(scene_)).find("another program"), std::string::npos);
  EXPECT_NE(refusal(folder_).find("folder"), std::string::npos);
  EXPECT_NE(refusal("/dev/null").find("regular file"), std::string::npos);
}

TEST_F(HardTimes, ASceneOfANewerSchemaIsRefused) {
  open_or_die(scene_);
  run_sql("PRAGMA user_version=99");
  EXPECT_NE(refusal(scene_).find("schema version 99"), std::string::npos) << refusal(scene_);
}

TEST_F(HardTimes, RowsThatContradictEachOtherAreRefused) {
  {
    const auto store = open_or_die(scene_);
    store->commit({add(1, 1), add(2, 2)}, {}).value();
    store->commit({RemoveNode{2}}, {}).value();
  }
  const std::string whole = content_of(scene_);
  const auto damaged_by = [&](const std::string& sql) {
    for (const char* companion : {"-wal", "-shm"}) std::filesystem::remove(scene_.string() + companion);
    write_content(scene_, whole);
    run_sql(sql);
    return refusal(scene_);
  };
  EXPECT_EQ(damaged_by("SELECT 1"), "");
  for (const char* sql :
       {"DELETE FROM geometry", "UPDATE geometry SET positions = x'00'",
        "UPDATE geometry SET triangles = zeroblob(length(triangles))", "UPDATE geometry SET colors = x'010203'",
        "UPDATE node SET transform = zeroblob(128)", "UPDATE node SET transform = x''",
        "UPDATE node SET geometry = x''", "UPDATE node SET node_id = -node_id",
        "UPDATE meta SET value = 1 WHERE key = 'next_node_id'", "DELETE FROM meta", "DROP TABLE node",
        "UPDATE revision SET undo_content = 7", "UPDATE revision SET content = 9",
        "UPDATE revision SET redo_revision = revision", "PRAGMA user_version=0"}) {
    EXPECT_NE(damaged_by(sql), "") << sql;
  }
  EXPECT_NE(damaged_by("CREATE TRIGGER t AFTER INSERT ON revision BEGIN DELETE FROM node; END"), "");
}

TEST_F(HardTimes, TruncatedScenesAreRefusedUnchanged) {
  open_or_die(scene_)->commit({add(1, 1, 40)}, {}).value();
  const std::string whole = content_of(scene_);
  for (std::size_t i = 1; i < 16; ++i) {
    const std::string part = whole.substr(0, whole.size() * i / 16);
    write_content(scene_, part);
    EXPECT_NE(refusal(scene_), "") << part.size() << " of " << whole.size() << " bytes";
    EXPECT_TRUE(content_of(scene_) == part);
  }
}

TEST_F(HardTimes, FlippedBytesNeverCrashAndNeverChangeAnything) {
  {
    const auto store = open_or_die(scene_);
    for (int i = 1; i <= 6; ++i) store->commit({add(static_cast<NodeId>(i), i, 8)}, {}).value();
    store->undo("anna").value();
  }
  const std::string whole = content_of(scene_);
  std::mt19937 random{31};
  int refused = 0;
  for (int round = 0; round < 60; ++round) {
    std::string damaged = whole;
    for (std::size_t i = 0, count = 1 + random() % 8; i < count; ++i) {
      damaged[random() % (round % 3 == 0 ? 4096 : damaged.size())] = static_cast<char>(random());
    }
    write_content(scene_, damaged);
    const auto store = SceneStore::open(scene_, false);
    if (!store) {
      ++refused;
      EXPECT_FALSE(store.error().message.empty());
      EXPECT_EQ(store.error().message.find('\n'), std::string::npos);
      EXPECT_TRUE(content_of(scene_) == damaged);
      continue;
    }
    // A flip where nothing is stored, or in the journal's text. What is read later is an answer or an error too.
    (void)(*store)->log();
    for (Revision revision = 0; revision < 8; ++revision) (void)(*store)->model_at(revision);
  }
  EXPECT_GT(refused, 30);
}

}  // namespace
}  // namespace meshloop
