// Scenes that earlier versions of the program made.
#include <sqlite3.h>

#include "scenes.h"

namespace meshloop {
namespace {

using test::add;
using test::expect_same_content;
using test::open_or_die;

// As version 0.1.0 wrote it: a triangle imported, then two, then an undo.
constexpr const char* kVersion1 = R"sql(
PRAGMA application_id=0x4d4c4f50;
PRAGMA user_version=1;
PRAGMA journal_mode=WAL;
CREATE TABLE meta(key TEXT PRIMARY KEY, value INTEGER NOT NULL) STRICT, WITHOUT ROWID;
INSERT INTO meta VALUES('epoch', 0), ('next_node_id', 3);
CREATE TABLE revision(
  revision INTEGER PRIMARY KEY, parent INTEGER NOT NULL, content INTEGER NOT NULL, undo_content INTEGER,
  redo_revision INTEGER REFERENCES revision, accepted_ns INTEGER NOT NULL, author TEXT NOT NULL,
  summary TEXT NOT NULL, triangles_added INTEGER NOT NULL, triangles_removed INTEGER NOT NULL) STRICT;
INSERT INTO revision VALUES
  (1, 0, 1, 0, NULL, 1795433513391444357, 'import', 'imported a.obj', 1, 0),
  (2, 1, 2, 1, NULL, 1795433513427930223, 'import', 'imported b.obj', 2, 0),
  (3, 2, 1, 0, 2, 1795433513449209735, 'operator', 'undo of revision 2', 0, 2);
CREATE TABLE picture(
  revision INTEGER NOT NULL REFERENCES revision, position INTEGER NOT NULL, png BLOB NOT NULL,
  PRIMARY KEY(revision, position)) STRICT;
CREATE TABLE geometry(
  hash BLOB PRIMARY KEY, positions BLOB NOT NULL, colors BLOB NOT NULL, triangles BLOB NOT NULL) STRICT;
INSERT INTO geometry VALUES
  (X'B785CAA5472BD7EE28100EDA671E95E09E7B4A4D06E5B1D16105C1B3B1B92BA9',
   X'0000000000000000000000000000803F0000000000000000000000000000803F0000003F', X'', X'000000000100000002000000'),
  (X'327755208CA6D5510570406DF193249045434BACB43F68C8DE47F057180842F6',
   X'00000000000000000000803F0000803F000000000000803F000000000000803F0000803F0000803F0000803F0000A03F', X'',
   X'000000000100000002000000010000000300000002000000');
CREATE TABLE node(
  node_id INTEGER NOT NULL, from_revision INTEGER NOT NULL REFERENCES revision,
  to_revision INTEGER REFERENCES revision, name TEXT NOT NULL, transform BLOB NOT NULL,
  geometry BLOB NOT NULL REFERENCES geometry, PRIMARY KEY(node_id, from_revision)) STRICT;
INSERT INTO node VALUES
  (1, 1, NULL, 'defaultobject', IDENTITY, X'B785CAA5472BD7EE28100EDA671E95E09E7B4A4D06E5B1D16105C1B3B1B92BA9'),
  (2, 2, 3, 'defaultobject', IDENTITY, X'327755208CA6D5510570406DF193249045434BACB43F68C8DE47F057180842F6');
CREATE INDEX node_present ON node(node_id) WHERE to_revision IS NULL;
)sql";

constexpr int kPresentVersion = 4;

/// The identity as SQLite takes a blob: a column of the matrix is 1 and four zeros on.
std::string with_identity(std::string sql) {
  std::string zeros(64, '0');
  const std::string one = "000000000000F03F";
  const std::string identity = "X'" + one + zeros + one + zeros + one + zeros + one + "'";
  for (std::size_t at; (at = sql.find("IDENTITY")) != std::string::npos;) sql.replace(at, 8, identity);
  return sql;
}

class EarlierSchema : public test::SceneFolder {
 protected:
  EarlierSchema() { run_sql(with_identity(kVersion1)); }
  void run_sql(const std::string& sql) const {
    sqlite3* database = nullptr;
    EXPECT_EQ(sqlite3_open(scene_.c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
    sqlite3_close(database);
  }
  /// A number in the header of the file: nothing reads the log here, so that the store must have closed it.
  int schema_version() const {
    constexpr std::size_t kOffset = 60;
    int version = 0;
    for (std::size_t i = 0; i < 4; ++i) version = version << 8 | static_cast<unsigned char>(content()[kOffset + i]);
    return version;
  }
  std::string content() const { return test::content_of(scene_); }
};

TEST_F(EarlierSchema, IsReadAndLeftAsItIs) {
  const std::string before = content();
  {
    const auto store = open_or_die(scene_, false);
    EXPECT_EQ(store->model()->revision, 3u);
    EXPECT_EQ(store->model()->triangle_count(), 1u);
    EXPECT_EQ(store->model_at(2).value()->triangle_count(), 3u);
    const auto log = store->log().value();
    ASSERT_EQ(log.size(), 3u);
    EXPECT_EQ(log[1].summary, "imported b.obj");
    EXPECT_FALSE(log[1].snapshot);
  }
  EXPECT_TRUE(content() == before);
}

TEST_F(EarlierSchema, TheFirstChangeMakesItOneOfThePresentVersion) {
  EXPECT_EQ(schema_version(), 1);
  {
    const auto store = open_or_die(scene_, false);
    RevisionInfo info;
    info.snapshot.emplace().depth_pose.state = TrackState::tracking;
    info.snapshot->calibration = "a rig";
    store->commit({add(3, 1)}, info).value();
  }
  EXPECT_EQ(schema_version(), kPresentVersion);
  const auto store = open_or_die(scene_, false);
  const auto log = store->log().value();
  ASSERT_EQ(log.size(), 4u);
  EXPECT_FALSE(log[2].snapshot);
  ASSERT_TRUE(log[3].snapshot);
  EXPECT_EQ(log[3].snapshot->calibration, "a rig");
  EXPECT_EQ(store->restore(2, "anna").value()->triangle_count(), 3u);
}

TEST_F(EarlierSchema, HasNoProposalsAndTakesThemInWithTheFirst) {
  EXPECT_TRUE(open_or_die(scene_, false)->proposals().value().empty());
  EXPECT_EQ(schema_version(), 1);
  ProposalSighting sighting;
  sighting.content.box_m.extend(Eigen::Vector3d::Zero());
  EXPECT_EQ(open_or_die(scene_, false)->remember({sighting}).value().at(0), 1u);
  EXPECT_EQ(schema_version(), kPresentVersion);
  const auto store = open_or_die(scene_, false);
  EXPECT_EQ(store->proposals().value().size(), 1u);
  EXPECT_EQ(store->model()->revision, 3u);
  EXPECT_TRUE(store->log().value().at(2).proposals.empty());
}

/// As the versions between wrote it: with snapshots, without proposals.
TEST_F(EarlierSchema, OfVersion2BecomesOneOfThePresentVersionToo) {
  {
    const auto store = open_or_die(scene_, false);
    RevisionInfo info;
    info.snapshot.emplace().depth_pose.state = TrackState::tracking;
    info.snapshot->calibration = "a rig";
    store->commit({add(3, 1)}, info).value();
  }
  run_sql(
      "DROP TABLE texture; DROP TABLE jpeg; DROP TABLE accepted_proposal; DROP TABLE proposal; DELETE FROM meta WHERE "
      "key = 'next_proposal_id';"
      "PRAGMA user_version=2; PRAGMA wal_checkpoint(TRUNCATE)");
  EXPECT_EQ(schema_version(), 2);
  const auto store = open_or_die(scene_, false);
  EXPECT_EQ(store->log().value().at(3).snapshot->calibration, "a rig");
  EXPECT_TRUE(store->proposals().value().empty());
  store->undo("anna").value();
  ProposalSighting sighting;
  sighting.content.box_m.extend(Eigen::Vector3d::Zero());
  EXPECT_EQ(store->remember({sighting}).value().at(0), 1u);
  EXPECT_EQ(store->log().value().size(), 5u);
}

TEST_F(EarlierSchema, UndoAndRedoGoOnWhereTheyWere) {
  const auto store = open_or_die(scene_, false);
  const auto two = store->model_at(2).value();
  expect_same_content(*store->redo("anna").value(), *two);
  EXPECT_EQ(store->undo("anna").value()->triangle_count(), 1u);
  EXPECT_TRUE(store->undo("anna").value()->nodes.empty());
}

TEST_F(EarlierSchema, AChangeThatIsRefusedLeavesItAsItIs) {
  {
    const auto store = open_or_die(scene_, false);
    EXPECT_FALSE(store->restore(9, "anna"));
    EXPECT_FALSE(store->commit({RemoveNode{9}}, {}));
  }
  EXPECT_EQ(schema_version(), 1);
  EXPECT_EQ(open_or_die(scene_, false)->log().value().size(), 3u);
}

}  // namespace
}  // namespace meshloop
