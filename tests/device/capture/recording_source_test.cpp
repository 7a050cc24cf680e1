#include "device/capture/recording_source.h"

#include <gtest/gtest.h>

#include "common/base/clock.h"
#include "temporary_folder.h"

namespace meshloop {
namespace {

class ColorRecordingSourceTest : public testing::Test {
 protected:
  void record(int count) {
    Rig rig;
    rig.color = {64, 48, 50, 50, 31.5, 23.5, {0.4, 0, 0, 0, 0}};
    rig.depth = {32, 24, 30, 30, 15.5, 11.5, {}};
    auto writer = RecordingWriter::create(path_, rig).value();
    for (int i = 0; i < count; ++i) {
      ASSERT_TRUE(writer.add_color(100 + 0.03 * i, ColorImage{64, 48, {static_cast<std::uint8_t>(50 + i), 0, 0}}));
    }
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "recording";
};

TEST_F(ColorRecordingSourceTest, PlaysAColorOnlyRecordingToItsEnd) {
  record(3);
  auto source = ColorRecordingSource::open(path_).value();
  for (int i = 0; i < 3; ++i) {
    const auto frame = source->next();
    ASSERT_TRUE(frame && *frame);
    EXPECT_EQ((*frame)->index, i);
    EXPECT_DOUBLE_EQ((*frame)->timestamp_s, 100 + 0.03 * i);
    EXPECT_EQ((*frame)->color(32, 24).r, 50 + i);
  }
  EXPECT_FALSE(source->next().value());
}

TEST_F(ColorRecordingSourceTest, TakesTheLensOut) {
  record(1);
  auto source = ColorRecordingSource::open(path_).value();
  EXPECT_FALSE(source->camera().has_distortion());
  EXPECT_EQ(source->next().value()->color(0, 0), Rgb8{}) << "this lens did not see the pinhole's corner";
}

TEST_F(ColorRecordingSourceTest, LoopsWithTimesThatGrowAndAnIndexThatCounts) {
  record(3);
  auto source = ColorRecordingSource::open(path_, std::nullopt, {.loop = true}).value();
  for (int i = 0; i < 8; ++i) {
    const auto frame = source->next().value();
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->index, i);
    EXPECT_NEAR(frame->timestamp_s, 100 + 0.03 * i, 1e-9);
    EXPECT_EQ(frame->color(32, 24).r, 50 + i % 3);
  }
}

TEST_F(ColorRecordingSourceTest, LoopsASingleImage) {
  record(1);
  auto source = ColorRecordingSource::open(path_, std::nullopt, {.loop = true}).value();
  const double first_s = source->next().value()->timestamp_s;
  EXPECT_GT(source->next().value()->timestamp_s, first_s);
}

TEST_F(ColorRecordingSourceTest, RealTimeKeepsTheRecordedPaceAlsoInLaterRounds) {
  record(2);
  auto source = ColorRecordingSource::open(path_, std::nullopt, {.real_time = true, .loop = true}).value();
  const Stopwatch stopwatch;
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(source->next().value());
  EXPECT_GE(stopwatch.milliseconds(), 89.0);
}

TEST_F(ColorRecordingSourceTest, GoesOnAfterAFrameThatCannotBeRead) {
  record(3);
  std::filesystem::resize_file(path_ / "rgb/000001.png", 30);
  auto source = ColorRecordingSource::open(path_).value();
  EXPECT_TRUE(source->next());
  EXPECT_FALSE(source->next());
  EXPECT_EQ(source->next().value()->index, 2);
}

}  // namespace
}  // namespace meshloop
