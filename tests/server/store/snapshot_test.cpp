// What a revision was measured with.
#include <gmock/gmock.h>
#include <sqlite3.h>

#include <functional>
#include <limits>

#include "scenes.h"

namespace meshloop {
namespace {

using test::add;
using test::open_or_die;

Pose some_pose(double x) {
  return make_pose({x, -1.0 / 3, 2e-300},
                   Eigen::Quaterniond{Eigen::AngleAxisd{0.3, Eigen::Vector3d(1, 2, 3).normalized()}});
}

RevisionInfo with_snapshot(const std::string& calibration) {
  RevisionInfo info;
  info.snapshot = SnapshotInfo{
      calibration,
      {1234567890.123456, TrackState::relocalised, some_pose(1), PoseCovariance::Random() / 3, 2.0 / 3, 417},
      some_pose(2)};
  return info;
}

class Snapshots : public test::SceneFolder {
 protected:
  void run_sql(const std::string& sql) const {
    sqlite3* database = nullptr;
    ASSERT_EQ(sqlite3_open(scene_.c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(database);
    sqlite3_close(database);
  }
};

TEST_F(Snapshots, ComeBackBitForBit) {
  const RevisionInfo info = with_snapshot("color: {width: 640}\n\xc3\xa4\n");
  open_or_die(scene_)->commit({add(1, 1)}, info).value();
  const auto log = open_or_die(scene_)->log().value();
  ASSERT_TRUE(log.at(0).snapshot);
  const SnapshotInfo& read = *log[0].snapshot;
  const SnapshotInfo& told = *info.snapshot;
  EXPECT_EQ(read.calibration, told.calibration);
  EXPECT_EQ(read.depth_pose.timestamp_s, told.depth_pose.timestamp_s);
  EXPECT_EQ(read.depth_pose.state, TrackState::relocalised);
  EXPECT_EQ(read.depth_pose.T_camera_world.matrix(), told.depth_pose.T_camera_world.matrix());
  EXPECT_EQ(read.depth_pose.covariance, told.depth_pose.covariance);
  EXPECT_EQ(read.depth_pose.quality, told.depth_pose.quality);
  EXPECT_EQ(read.depth_pose.inliers, 417);
  ASSERT_TRUE(read.refined_T_camera_world);
  EXPECT_EQ(read.refined_T_camera_world->matrix(), told.refined_T_camera_world->matrix());
}

TEST_F(Snapshots, AreThereForMeasuredChangesOnly) {
  const auto store = open_or_die(scene_);
  store->commit({add(1, 1)}, {}).value();
  RevisionInfo unrefined = with_snapshot("a");
  unrefined.snapshot->refined_T_camera_world.reset();
  store->commit({add(2, 2)}, unrefined).value();
  store->undo("anna").value();
  store->redo("anna").value();
  const auto log = store->log().value();
  EXPECT_FALSE(log[0].snapshot);
  ASSERT_TRUE(log[1].snapshot);
  EXPECT_FALSE(log[1].snapshot->refined_T_camera_world);
  EXPECT_FALSE(log[2].snapshot);
  EXPECT_FALSE(log[3].snapshot);
}

TEST_F(Snapshots, ShareTheCalibration) {
  const std::string rig(200'000, 'r');
  {
    const auto store = open_or_die(scene_);
    for (int i = 0; i < 20; ++i) {
      store->commit_unsynced({add(store->next_node_id(), 1)}, with_snapshot(rig + (i < 10 ? "" : "2"))).value();
    }
  }
  EXPECT_LT(std::filesystem::file_size(scene_), 600'000u);
  const auto log = open_or_die(scene_)->log().value();
  EXPECT_EQ(log[0].snapshot->calibration, rig);
  EXPECT_EQ(log[9].snapshot->calibration, rig);
  EXPECT_EQ(log[19].snapshot->calibration, rig + "2");
}

TEST_F(Snapshots, WithoutAPoseAreRefused) {
  const auto store = open_or_die(scene_);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto refused = [&](const std::function<void(SnapshotInfo&)>& spoil) {
    RevisionInfo info = with_snapshot("a");
    spoil(*info.snapshot);
    const auto model = store->commit({add(1, 1)}, info);
    return !model && model.error().message.find("the snapshot has no pose") != std::string::npos;
  };
  EXPECT_TRUE(refused([](SnapshotInfo& s) { s.depth_pose.state = TrackState::lost; }));
  EXPECT_TRUE(refused([](SnapshotInfo& s) { s.depth_pose.T_camera_world.linear() *= 2; }));
  EXPECT_TRUE(refused([&](SnapshotInfo& s) { s.depth_pose.covariance(3, 4) = nan; }));
  EXPECT_TRUE(refused([&](SnapshotInfo& s) { s.depth_pose.timestamp_s = nan; }));
  EXPECT_TRUE(refused([&](SnapshotInfo& s) { s.depth_pose.quality = nan; }));
  EXPECT_TRUE(refused([&](SnapshotInfo& s) { s.refined_T_camera_world->translation().x() = nan; }));
  EXPECT_EQ(store->model()->revision, 0u);
  EXPECT_TRUE(store->log().value().empty());
  EXPECT_TRUE(store->commit({add(1, 1)}, with_snapshot("a")));
}

TEST_F(Snapshots, ThatAreDamagedAreSaidToBe) {
  open_or_die(scene_)->commit({add(1, 1)}, with_snapshot("a")).value();
  const std::string whole = test::content_of(scene_);
  for (const char* sql :
       {"UPDATE calibration SET rig = 'b'", "DELETE FROM calibration", "UPDATE snapshot SET pose = x''",
        "UPDATE snapshot SET pose = zeroblob(128)", "UPDATE snapshot SET covariance = x'00'",
        "UPDATE snapshot SET refined_pose = zeroblob(128)", "UPDATE snapshot SET state = 'lost'"}) {
    test::write_content(scene_, whole);
    run_sql(sql);
    const auto store = open_or_die(scene_, false);
    EXPECT_EQ(store->model()->nodes.size(), 1u) << "the model is read without";
    const auto log = store->log();
    ASSERT_FALSE(log) << sql;
    EXPECT_THAT(log.error().message, testing::HasSubstr("snapshot of revision 1")) << sql;
  }
}

}  // namespace
}  // namespace meshloop
