#include "common/recording/recording.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "common/base/file.h"
#include "common/image/image_file.h"
#include "recordings.h"
#include "temporary_folder.h"

namespace meshloop {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr double kFrame_s = 1.0 / 30;

ColorImage color_of(int i) {
  return {64, 48, {static_cast<std::uint8_t>(i), 20, 30}};
}

class RecordingFolder : public testing::Test {
 protected:
  // Three frames; colour comes 5 ms after depth.
  void SetUp() override {
    auto writer = RecordingWriter::create(path_, small_rig());
    ASSERT_TRUE(writer) << writer.error().message;
    for (int i = 0; i < 3; ++i) {
      DepthImage depth{32, 24, 1.0f + static_cast<float>(i)};
      depth(0, 0) = 0;
      ASSERT_TRUE(writer->add_depth(i * kFrame_s, depth));
      ASSERT_TRUE(writer->add_color(i * kFrame_s + 0.005, color_of(i)));
      ASSERT_TRUE(
          writer->add_ground_truth(i * kFrame_s + 0.005, make_pose({1.0 * i, 0, 0}, Eigen::Quaterniond::Identity())));
    }
  }
  std::string error_with(const std::string& file, const std::string& text) {
    EXPECT_TRUE(write_text_file(path_ / file, text));
    const auto recording = Recording::open(path_);
    return recording ? "no error" : recording.error().message;
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "recording";
};

TEST_F(RecordingFolder, ReadsWhatTheWriterWrote) {
  const auto recording = Recording::open(path_);
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ(recording->depth_images().size(), 3u);
  const auto frame = recording->read_frame(2);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(frame->index, 2);
  EXPECT_EQ(frame->depth_timestamp_s, 2 * kFrame_s);
  EXPECT_EQ(frame->color_timestamp_s, 2 * kFrame_s + 0.005);
  EXPECT_EQ(frame->color, color_of(2));
  EXPECT_EQ(frame->depth(0, 0), 0);
  EXPECT_NEAR(frame->depth(5, 5), 3.0, small_rig().depth_scale / 2 + 1e-6);
  EXPECT_EQ(recording->read_color(1)->color, color_of(1));
  EXPECT_EQ(recording->ground_truth()->back().T_world_camera.translation().x(), 2);
  EXPECT_EQ(recording->rig().color.fy, small_rig().color.fy);
}

TEST_F(RecordingFolder, EveryStateOfTheWriterCanBeRead) {
  auto writer = RecordingWriter::create(folder_ / "live", small_rig()).value();
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(writer.add_color(i, color_of(i)));
    const auto recording = Recording::open(folder_ / "live");
    ASSERT_TRUE(recording) << recording.error().message;
    EXPECT_EQ(recording->read_color(i)->color, color_of(i));
    EXPECT_TRUE(recording->depth_images().empty());
    EXPECT_FALSE(recording->ground_truth());
    EXPECT_THAT(recording->read_frame(0).error().message, HasSubstr("no depth images"));
  }
}

TEST_F(RecordingFolder, DepthIsRoundedToUnitsAndWhatDoesNotFitIsUnmeasured) {
  Rig rig = small_rig();
  rig.depth_scale = 0.001;
  auto writer = RecordingWriter::create(folder_ / "units", rig).value();
  DepthImage depth{32, 24};
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float values[]{0.0004f, 0.0006f, 65.535f, 65.6f, -1.0f, nan, std::numeric_limits<float>::infinity(), 1.2344f};
  for (int i = 0; i < 8; ++i) depth(i, 0) = values[i];
  ASSERT_TRUE(writer.add_depth(0, depth));
  const auto units = read_png16(folder_ / "units/depth/000000.png").value();
  const int expected[]{0, 1, 65535, 0, 0, 0, 0, 1234};
  for (int i = 0; i < 8; ++i) EXPECT_EQ(units(i, 0), expected[i]) << values[i];
}

TEST_F(RecordingFolder, FloatDepthKeepsEachValueAndWhatIsNoDepthIsUnmeasured) {
  Rig rig = small_rig();
  rig.depth_scale = 0.5;
  auto writer = RecordingWriter::create(folder_ / "float", rig, DepthFormat::float_tiff).value();
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  DepthImage depth{32, 24};
  depth(0, 0) = 1.2345678f;
  depth(1, 0) = -1;
  depth(2, 0) = kNaN;
  ASSERT_TRUE(writer.add_depth(0, depth));
  ASSERT_TRUE(writer.add_color(0, color_of(1)));
  EXPECT_EQ(Recording::open(folder_ / "float")->read_frame(0)->depth(0, 0), 1.2345678f);
  Image<float> foreign{32, 24, 4.5f};  // as another program may write it, in halves of a metre
  foreign(1, 0) = -kInfinity;
  foreign(2, 0) = kNaN;
  foreign(3, 0) = kInfinity;
  ASSERT_TRUE(write_tiff(folder_ / "float/depth/000000.tiff", foreign));
  const auto frame = Recording::open(folder_ / "float")->read_frame(0);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(frame->depth(0, 0), 2.25f);
  for (int x = 1; x < 4; ++x) EXPECT_EQ(frame->depth(x, 0), 0.0f) << x;
}

TEST_F(RecordingFolder, AFrameTakesTheColorNearestInTime) {
  ASSERT_EQ(error_with("rgb.txt", "-0.02 rgb/000000.png\n0.02 rgb/000001.png\n0.05 rgb/000002.png\n"), "no error");
  const auto recording = Recording::open(path_);
  EXPECT_EQ(recording->read_frame(0)->color, color_of(0));
  EXPECT_EQ(recording->read_frame(1)->color, color_of(1));
  EXPECT_EQ(recording->read_frame(2)->color, color_of(2));
}

TEST_F(RecordingFolder, AFrameWithoutColorNearbySaysHowFarItIs) {
  ASSERT_EQ(error_with("rgb.txt", "0 rgb/000000.png\n"), "no error");
  ASSERT_EQ(error_with("depth.txt", "0.1 depth/000000.png\n0.15 depth/000001.png"), "no error");
  const auto recording = Recording::open(path_);
  EXPECT_TRUE(recording->read_frame(0));
  EXPECT_THAT(recording->read_frame(1).error().message, AllOf(HasSubstr("frame 1"), HasSubstr("0.150 s away")));
}

TEST_F(RecordingFolder, AnImageOfAnotherSizeNamesBothSizes) {
  ASSERT_TRUE(write_png(path_ / "depth/000001.png", Image<std::uint16_t>{31, 24}));
  ASSERT_TRUE(write_png(path_ / "rgb/000002.png", ColorImage{64, 49}));
  const auto recording = Recording::open(path_);
  EXPECT_TRUE(recording->read_frame(0));
  EXPECT_THAT(recording->read_frame(1).error().message, AllOf(HasSubstr("31x24"), HasSubstr("depth camera has 32x24")));
  EXPECT_THAT(recording->read_frame(2).error().message, AllOf(HasSubstr("64x49"), HasSubstr("color camera has 64x48")));
}

TEST_F(RecordingFolder, DamagedAndMissingImagesAreErrorsOfTheirFrameOnly) {
  std::filesystem::resize_file(path_ / "depth/000000.png", 60);
  std::filesystem::remove(path_ / "rgb/000001.png");
  const auto recording = Recording::open(path_);
  EXPECT_THAT(recording->read_frame(0).error().message, HasSubstr("depth/000000.png"));
  EXPECT_THAT(recording->read_frame(1).error().message, HasSubstr("rgb/000001.png"));
  EXPECT_TRUE(recording->read_frame(2));
  ASSERT_TRUE(write_text_file(path_ / "depth/000002.png", "P5 depth"));
  EXPECT_THAT(recording->read_frame(2).error().message, HasSubstr("neither 16-bit PNG nor float TIFF"));
  EXPECT_THAT(recording->read_frame(3).error().message, HasSubstr("from 0 to 2"));
  EXPECT_FALSE(recording->read_frame(-1));
  EXPECT_FALSE(recording->read_color(3));
}

TEST_F(RecordingFolder, PathsMustNotLeaveTheFolder) {
  for (const char* path : {"../secret.png", "/etc/passwd", "rgb/../../x.png", ".."}) {
    EXPECT_THAT(error_with("rgb.txt", std::string{"0 "} + path), HasSubstr("must not leave")) << path;
  }
}

TEST_F(RecordingFolder, MistakesInListsAreNamedWithTheirLine) {
  EXPECT_THAT(error_with("depth.txt", "# a\n\n0 a.png\nx b.png\n"),
              HasSubstr("depth.txt', line 4: must begin with a timestamp"));
  EXPECT_THAT(error_with("depth.txt", "0\n"), HasSubstr("names no file"));
  EXPECT_THAT(error_with("depth.txt", "nan a.png\n"), HasSubstr("timestamp"));
  EXPECT_THAT(error_with("depth.txt", "1 a.png\n0.5 b.png\n"), HasSubstr("line 2: the timestamps must grow"));
  EXPECT_THAT(error_with("depth.txt", "# nothing\n"), HasSubstr("lists no image"));
}

TEST_F(RecordingFolder, AFolderThatIsNoRecordingSaysWhatIsMissing) {
  EXPECT_THAT(Recording::open(folder_ / "none").error().message, HasSubstr("there is no recording"));
  std::filesystem::remove(path_ / "rgb.txt");
  EXPECT_THAT(Recording::open(path_).error().message, HasSubstr("rgb.txt"));
  std::filesystem::remove(path_ / "rig.yaml");
  EXPECT_THAT(Recording::open(path_).error().message, HasSubstr("rig.yaml"));
}

TEST_F(RecordingFolder, AnotherRigFileTakesTheRecordingsPlace) {
  Rig rig = small_rig();
  rig.color.fx = 99;
  ASSERT_TRUE(write_rig(folder_ / "other.yaml", rig));
  EXPECT_EQ(Recording::open(path_, folder_ / "other.yaml")->rig().color.fx, 99);
}

TEST_F(RecordingFolder, TheWriterNeverWritesOverARecording) {
  EXPECT_THAT(RecordingWriter::create(path_, small_rig()).error().message, HasSubstr("holds a recording already"));
  EXPECT_EQ(Recording::open(path_)->depth_images().size(), 3u);
}

TEST_F(RecordingFolder, TheWriterRefusesWhatCouldNotBeReadAgain) {
  auto writer = RecordingWriter::create(folder_ / "strict", small_rig()).value();
  ASSERT_TRUE(writer.add_color(1, color_of(0)));
  EXPECT_THAT(writer.add_color(1, color_of(0)).error().message, HasSubstr("does not follow"));
  EXPECT_FALSE(writer.add_color(std::numeric_limits<double>::quiet_NaN(), color_of(0)));
  EXPECT_THAT(writer.add_color(2, ColorImage{10, 10}).error().message, HasSubstr("10x10"));
  EXPECT_THAT(writer.add_depth(0, DepthImage{64, 48}).error().message, HasSubstr("32x24"));
  Pose scaled = Pose::Identity();
  scaled.linear() *= 2;
  EXPECT_FALSE(writer.add_ground_truth(0, scaled));
  EXPECT_EQ(Recording::open(folder_ / "strict")->color_images().size(), 1u);
  Rig bad = small_rig();
  bad.depth.fx = 0;
  EXPECT_FALSE(RecordingWriter::create(folder_ / "bad", bad));
  EXPECT_THAT(RecordingWriter::create("/dev/null/x", small_rig()).error().message, HasSubstr("cannot make the folder"));
}

}  // namespace
}  // namespace meshloop
