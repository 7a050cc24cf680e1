// Scenes that earlier versions of the program made.
#include <sqlite3.h>

#include <map>

#include "scenes.h"
#include "textured_wall.h"

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

// What each version since then has more, with a row of its own: never to be edited, as scenes of it are about.
constexpr const char* kMoreInVersion2 = R"sql(
PRAGMA user_version=2;
CREATE TABLE calibration(hash BLOB PRIMARY KEY, rig TEXT NOT NULL) STRICT;
CREATE TABLE snapshot(
  revision INTEGER PRIMARY KEY REFERENCES revision, calibration BLOB NOT NULL REFERENCES calibration,
  timestamp_s REAL NOT NULL, state TEXT NOT NULL, pose BLOB NOT NULL, covariance BLOB NOT NULL, quality REAL NOT NULL,
  inliers INTEGER NOT NULL, refined_pose BLOB) STRICT;
INSERT INTO calibration VALUES(X'2C6890DF66CD0CF709B4CDF6E4B79629C4DFDA97A38C0B99C16EA1D3E89FB3D1', 'a rig');
INSERT INTO snapshot SELECT 2, hash, 12.5, 'tracking', IDENTITY, zeroblob(288), 0.75, 90, NULL FROM calibration;
)sql";
constexpr const char* kMoreInVersion3 = R"sql(
PRAGMA user_version=3;
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
UPDATE meta SET value = 2 WHERE key = 'next_proposal_id';
INSERT INTO proposal VALUES(1, 0, X'', zeroblob(48), 'a thing', 0.5, 0.25, NULL, 0, 10, 20, NULL, '', 0, '');
)sql";
constexpr const char* kMoreInVersion4 = R"sql(
PRAGMA user_version=4;
CREATE TABLE jpeg(hash BLOB PRIMARY KEY, bytes BLOB NOT NULL) STRICT;
CREATE TABLE texture(
  geometry BLOB PRIMARY KEY REFERENCES geometry, jpeg BLOB NOT NULL REFERENCES jpeg,
  projection BLOB NOT NULL) STRICT;
)sql";

constexpr int kPresentVersion = 4;

/// The statements that made the tables and indices of a scene, by name.
std::map<std::string, std::string> tables_of(const std::filesystem::path& scene) {
  std::map<std::string, std::string> tables;
  sqlite3* database = nullptr;
  EXPECT_EQ(sqlite3_open(scene.c_str(), &database), SQLITE_OK);
  const auto add_row = [](void* to, int, char** values, char**) {
    (*static_cast<std::map<std::string, std::string>*>(to))[values[0]] = values[1];
    return 0;
  };
  const char* query = "SELECT name, sql FROM sqlite_schema WHERE sql IS NOT NULL";
  EXPECT_EQ(sqlite3_exec(database, query, add_row, &tables, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
  sqlite3_close(database);
  EXPECT_FALSE(tables.empty());
  return tables;
}

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

TEST_F(EarlierSchema, OfVersion2BecomesOneOfThePresentVersionToo) {
  run_sql(with_identity(kMoreInVersion2));
  EXPECT_EQ(schema_version(), 2);
  const auto store = open_or_die(scene_, false);
  EXPECT_EQ(store->log().value().at(1).snapshot->calibration, "a rig");
  EXPECT_TRUE(store->proposals().value().empty());
  store->redo("anna").value();
  ProposalSighting sighting;
  sighting.content.box_m.extend(Eigen::Vector3d::Zero());
  EXPECT_EQ(store->remember({sighting}).value().at(0), 1u);
  EXPECT_EQ(store->log().value().size(), 4u);
}

TEST_F(EarlierSchema, OfVersion3GetsItsTexturesWithTheFirstChange) {
  run_sql(with_identity(std::string{kMoreInVersion2} + kMoreInVersion3));
  {
    const auto store = open_or_die(scene_, false);
    EXPECT_EQ(store->proposals().value().at(0).content.effect, "a thing");
    EXPECT_EQ(schema_version(), 3);
    ProposalSighting sighting;
    sighting.content.box_m.extend(Eigen::Vector3d::Zero());
    EXPECT_EQ(store->remember({sighting}).value().at(0), 2u);
    ASSERT_TRUE(store->commit({AddNode{make_node(3, "wall", test::textured_wall())}}, {}));
  }
  EXPECT_EQ(schema_version(), kPresentVersion);
  const auto store = open_or_die(scene_, false);
  EXPECT_EQ(store->model()->triangle_count(), 3u);
  EXPECT_TRUE(store->model()->find(3)->submesh->texture);
  EXPECT_EQ(store->undo("anna").value()->triangle_count(), 1u);
}

/// A step that is edited would leave scenes that were brought up to date before with other tables than those after.
TEST_F(EarlierSchema, OfEachVersionGetsTheTablesOfANewOne) {
  const auto present = folder_ / "new.scene";
  open_or_die(present);
  std::string more;
  for (const char* step : {kMoreInVersion2, kMoreInVersion3, kMoreInVersion4}) {
    std::filesystem::remove(scene_);
    run_sql(with_identity(kVersion1 + more));
    ASSERT_TRUE(open_or_die(scene_, false)->commit({add(3, 1)}, {}));
    EXPECT_EQ(tables_of(scene_), tables_of(present)) << more;
    more += step;
  }
  std::filesystem::remove(scene_);
  run_sql(with_identity(kVersion1 + more));
  EXPECT_EQ(tables_of(scene_), tables_of(present));
}

TEST_F(EarlierSchema, TheStationsStartLeavesItsTablesAsTheyAre) {
  EXPECT_EQ(open_or_die(scene_, false)->begin_epoch().value(), 1u);
  EXPECT_EQ(schema_version(), 1);
  EXPECT_EQ(open_or_die(scene_, false)->begin_epoch().value(), 2u);
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
