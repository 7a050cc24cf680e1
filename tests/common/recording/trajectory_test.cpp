#include "common/recording/trajectory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "common/base/file.h"
#include "temporary_folder.h"

namespace meshloop {
namespace {

using testing::HasSubstr;

class TrajectoryFile : public testing::Test {
 protected:
  Result<Trajectory> read(const std::string& text) {
    EXPECT_TRUE(write_text_file(file_, text));
    return read_trajectory(file_);
  }

  TemporaryFolder folder_;
  std::filesystem::path file_ = folder_ / "poses.txt";
};

Pose pose(double x, double angle) {
  return make_pose({x, 0, 0}, Eigen::Quaterniond{Eigen::AngleAxisd{angle, Eigen::Vector3d::UnitZ()}});
}

TEST_F(TrajectoryFile, ReadsTumLinesWithCommentsBlanksAndForeignLineEnds) {
  const auto read_back =
      read("# ground truth\r\n\r\n 1305031102.1753 1 2 3 0 0 0.7071 0.7071\r\n1305031103\t4 5 6 0 0 0 1");
  ASSERT_TRUE(read_back) << read_back.error().message;
  ASSERT_EQ(read_back->size(), 2u);
  EXPECT_EQ(read_back->front().timestamp_s, 1305031102.1753);
  EXPECT_TRUE((read_back->front().T_world_camera * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d{1, 3, 3}, 1e-6));
  EXPECT_EQ(read_back->back().T_world_camera.translation(), Eigen::Vector3d(4, 5, 6));
}

TEST_F(TrajectoryFile, WrittenPosesComeBack) {
  const Trajectory trajectory{{0.1, pose(1.0 / 3, 0.2)}, {1305031102.175304, pose(-2, 3)}};
  ASSERT_TRUE(write_trajectory(file_, trajectory));
  const auto read_back = read_trajectory(file_);
  ASSERT_TRUE(read_back);
  ASSERT_EQ(read_back->size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ((*read_back)[i].timestamp_s, trajectory[i].timestamp_s);
    EXPECT_EQ((*read_back)[i].T_world_camera.translation(), trajectory[i].T_world_camera.translation());
    EXPECT_TRUE((*read_back)[i].T_world_camera.isApprox(trajectory[i].T_world_camera, 1e-15));
  }
}

TEST_F(TrajectoryFile, AFileWithoutPosesIsEmpty) {
  EXPECT_TRUE(read("# nothing\n").value().empty());
}

TEST_F(TrajectoryFile, MistakesAreNamedWithTheirLine) {
  EXPECT_THAT(read("1 0 0 0 0 0 0 1\n2 0 0 nan 0 0 0 1\n").error().message, HasSubstr("line 2: 'nan' is not a finite"));
  EXPECT_THAT(read("1 0 0 0 0 0 1\n").error().message, HasSubstr("expected 8 numbers, but there are 7"));
  EXPECT_THAT(read("1 0 0 0 0 0 0 1 5\n").error().message, HasSubstr("there are more"));
  EXPECT_THAT(read("1 0 0 0 0 0 0 0.99\n").error().message, HasSubstr("must have length 1"));
  EXPECT_THAT(read("1 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n").error().message,
              HasSubstr("line 2: the timestamps must grow"));
  EXPECT_THAT(read("1 0 0 0 0 0 0 1e999\n").error().message, HasSubstr("1e999"));
  EXPECT_THAT(read("1 0 0 0x1 0 0 0 1\n").error().message, HasSubstr("0x1"));
  EXPECT_FALSE(read_trajectory(folder_ / "none"));
}

TEST(PoseAt, InterpolatesOnSe3BetweenTwoPoses) {
  const Trajectory trajectory{{1.0, pose(0, 0)}, {1.4, pose(0.4, 0.8)}};
  const auto middle = pose_at(trajectory, 1.1);
  ASSERT_TRUE(middle);
  EXPECT_TRUE(middle->isApprox(interpolate(trajectory[0].T_world_camera, trajectory[1].T_world_camera, 0.25), 1e-9));
  EXPECT_TRUE(pose_at(trajectory, 1.4)->isApprox(trajectory[1].T_world_camera));
}

TEST(PoseAt, GivesNothingOutsideTheTimeOrInsideALongGap) {
  const Trajectory trajectory{{1.0, pose(0, 0)}, {1.4, pose(0.4, 0)}, {2.0, pose(1, 0)}};
  EXPECT_FALSE(pose_at(trajectory, 0.999));
  EXPECT_FALSE(pose_at(trajectory, 2.001));
  EXPECT_FALSE(pose_at(trajectory, 1.7));
  EXPECT_TRUE(pose_at(trajectory, 1.7, 1.0));
  EXPECT_TRUE(pose_at(trajectory, 2.0));
  EXPECT_FALSE(pose_at(trajectory, std::nan("")));
  EXPECT_FALSE(pose_at({}, 1));
}

TEST(ParsePose, ReadsTranslationAndQuaternionXyzw) {
  const auto parsed = parse_pose("1,-2.5,3e-1,0,0,0.7071067811865476,0.7071067811865476");
  ASSERT_TRUE(parsed) << parsed.error().message;
  EXPECT_TRUE((*parsed * Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d{1, -1.5, 0.3}, 1e-12));
}

TEST(ParsePose, RefusesOtherTextsAsWrongUsage) {
  for (const char* text :
       {"", "1,2,3", "1,2,3,0,0,0,1,0", "1,2,3,0,0,0,x", "nan,2,3,0,0,0,1", "1,2,3,0,0,0,2", ",,,"}) {
    const auto parsed = parse_pose(text);
    ASSERT_FALSE(parsed) << text;
    EXPECT_EQ(parsed.error().kind, ErrorKind::usage);
    EXPECT_THAT(parsed.error().message, HasSubstr("TX,TY,TZ,QX,QY,QZ,QW"));
  }
}

}  // namespace
}  // namespace meshloop
