#include "server/capture/recording_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/clock.h"
#include "temporary_folder.h"

namespace meshloop {
namespace {

Rig bent_rig() {
  Rig rig;
  rig.color = {64, 48, 50, 50, 31.5, 23.5, {0.4, 0, 0, 0, 0}};
  rig.depth = {32, 24, 30, 30, 15.5, 11.5, {0.5, 0, 0, 0, 0}};
  return rig;
}

class RecordingSourceTest : public testing::Test {
 protected:
  void SetUp() override {
    auto writer = RecordingWriter::create(path_, bent_rig()).value();
    for (int i = 0; i < 4; ++i) {
      ASSERT_TRUE(writer.add_color(100 + 0.03 * i, ColorImage{64, 48, {static_cast<std::uint8_t>(50 + i), 0, 0}}));
      ASSERT_TRUE(writer.add_depth(100 + 0.03 * i, DepthImage{32, 24, 1}));
    }
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "recording";
};

TEST_F(RecordingSourceTest, GivesEachFrameOnceAndThenTheEnd) {
  auto source = RecordingSource::open(path_).value();
  for (int i = 0; i < 4; ++i) {
    const auto frame = source->next();
    ASSERT_TRUE(frame && *frame);
    EXPECT_EQ((*frame)->index, i);
    EXPECT_EQ((*frame)->color(32, 24).r, 50 + i);
  }
  for (int i = 0; i < 2; ++i) {
    const auto end = source->next();
    ASSERT_TRUE(end);
    EXPECT_FALSE(*end);
  }
}

TEST_F(RecordingSourceTest, FramesAndRigAreFreeOfDistortion) {
  auto source = RecordingSource::open(path_).value();
  EXPECT_FALSE(source->rig().color.has_distortion());
  EXPECT_FALSE(source->rig().depth.has_distortion());
  EXPECT_EQ(source->rig().color.fx, 50);
  EXPECT_EQ(source->calibration().color.distortion, bent_rig().color.distortion);
  EXPECT_EQ(source->calibration().depth.distortion, bent_rig().depth.distortion);
  const auto frame = source->next().value();
  EXPECT_EQ(frame->depth(16, 12), 1);
  EXPECT_EQ(frame->depth(0, 0), 0) << "this lens did not see the pinhole's corner";
  EXPECT_EQ(frame->color(0, 0), Rgb8{});
}

TEST_F(RecordingSourceTest, GoesOnAfterAFrameThatCannotBeRead) {
  std::filesystem::remove(path_ / "depth/000001.png");
  auto source = RecordingSource::open(path_).value();
  EXPECT_TRUE(source->next());
  EXPECT_FALSE(source->next());
  const auto frame = source->next();
  ASSERT_TRUE(frame && *frame);
  EXPECT_EQ((*frame)->index, 2);
}

TEST_F(RecordingSourceTest, RealTimeKeepsTheRecordedPace) {
  auto source = RecordingSource::open(path_, std::nullopt, {.real_time = true}).value();
  const Stopwatch stopwatch;
  while (source->next().value()) {
  }
  EXPECT_GE(stopwatch.milliseconds(), 89.0);
}

TEST_F(RecordingSourceTest, RefusesARecordingWithoutDepthOrRig) {
  std::filesystem::remove(path_ / "depth.txt");
  EXPECT_THAT(RecordingSource::open(path_).error().message, testing::HasSubstr("no depth.txt"));
  EXPECT_FALSE(RecordingSource::open(path_, folder_ / "none.yaml"));
}

}  // namespace
}  // namespace meshloop
