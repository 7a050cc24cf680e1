#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "common/image/image_file.h"
#include "common/interchange/model_file.h"
#include "common/recording/recording.h"
#include "common/simulation/demo_data.h"
#include "common/simulation/demo_scene.h"
#include "common/simulation/parallel.h"
#include "temporary_folder.h"

namespace meshloop::simulation {
namespace {

namespace fs = std::filesystem;

class DemoData : public testing::Test {
 protected:
  /// The tests may run side by side, also from several builds.
  TemporaryFolder temporary_;
  fs::path folder_ = temporary_ / "demo";
};

testing::AssertionResult succeeded(const Status& status) {
  if (status) return testing::AssertionSuccess();
  return testing::AssertionFailure() << status.error().message;
}

TEST_F(DemoData, WithoutNoiseTheRecordedDepthIsTheTruthToAnEighthOfAMillimetre) {
  DemoOptions options;
  options.noise = 0;
  options.station_frames = 4;
  options.device_frames = 2;
  int calls = 0;
  int last = 0;
  const auto count = [&](int done, int all) {
    ++calls;
    last = done;
    EXPECT_EQ(all, 10);
  };
  ASSERT_TRUE(succeeded(write_demo_data(folder_, options, count)));
  EXPECT_EQ(calls, 10);
  EXPECT_EQ(last, 10);

  const auto recording = Recording::open(folder_ / "station");
  ASSERT_TRUE(recording) << recording.error().message;
  ASSERT_EQ(recording->depth_images().size(), 4u);
  for (int i = 0; i < 4; ++i) {
    const auto name = "measured_00000" + std::to_string(i) + ".tiff";
    const auto truth = read_tiff(folder_ / "station_truth" / name);
    const auto frame = recording->read_frame(i);
    ASSERT_TRUE(truth && frame);
    double worst = 0;
    for (std::size_t k = 0; k < truth->size(); ++k) {
      worst = std::max<double>(worst, std::abs(truth->pixels()[k] - frame->depth.pixels()[k]));
    }
    EXPECT_LT(worst, 0.000126);
  }
}

TEST_F(DemoData, HoldsEveryFileThatItsHeaderNames) {
  DemoOptions options;
  options.station_frames = 4;
  options.device_frames = 3;
  ASSERT_TRUE(succeeded(write_demo_data(folder_, options, nullptr)));
  for (const char* name : {"device", "device_before_move", "device_after_move"}) {
    const auto device = Recording::open(folder_ / name);
    ASSERT_TRUE(device) << device.error().message;
    EXPECT_EQ(device->color_images().size(), 3u);
    ASSERT_TRUE(device->ground_truth());
    EXPECT_EQ(device->ground_truth()->size(), 3u);
  }
  EXPECT_FALSE(fs::exists(folder_ / "station_truth" / "previous_000001.tiff"));
  for (const char* name : {"previous_000002.tiff", "expected_000000.tiff", "measured_000003.tiff", "frames.txt"}) {
    EXPECT_TRUE(fs::exists(folder_ / "station_truth" / name)) << name;
  }
  const auto markers = read_markers(folder_ / "markers.yaml");
  ASSERT_TRUE(markers);
  EXPECT_EQ(markers->markers.size(), demo_markers().markers.size());
  const auto model = import_model(folder_ / "model.ply");
  const auto all = import_model(folder_ / "model_before_move.ply");
  ASSERT_TRUE(model && all);
  const auto triangles = [](const std::vector<ImportedPart>& parts) {
    std::size_t sum = 0;
    for (const auto& part : parts) sum += part.submesh.triangles.size();
    return sum;
  };
  EXPECT_GT(triangles(*model), 60'000u);
  EXPECT_GT(triangles(*all), triangles(*model));
}

TEST_F(DemoData, SecondHalfComesAfterAGapAndHasAPoseForEveryImage) {
  DemoOptions options;
  options.station_frames = 6;
  options.device_frames = 2;
  ASSERT_TRUE(succeeded(write_demo_data(folder_, options, nullptr)));
  const auto recording = Recording::open(folder_ / "station");
  ASSERT_TRUE(recording && recording->ground_truth());
  const auto& color = recording->color_images();
  ASSERT_EQ(color.size(), 6u);
  EXPECT_NEAR(color[3].timestamp_s - color[2].timestamp_s, 2.1, 1e-6);
  EXPECT_NEAR(color[2].timestamp_s - color[1].timestamp_s, 0.1, 1e-6);
  for (std::size_t i = 0; i < color.size(); ++i) {
    EXPECT_NEAR(recording->depth_images()[i].timestamp_s - color[i].timestamp_s, 0.012, 1e-6);
    EXPECT_TRUE(pose_at(*recording->ground_truth(), color[i].timestamp_s));
    EXPECT_TRUE(pose_at(*recording->ground_truth(), recording->depth_images()[i].timestamp_s));
  }
}

TEST_F(DemoData, RefusesNumbersThatMakeNoDemo) {
  DemoOptions options;
  options.noise = -1;
  EXPECT_FALSE(write_demo_data(folder_, options, nullptr));
  options.noise = std::nan("");
  EXPECT_FALSE(write_demo_data(folder_, options, nullptr));
  options.noise = 1;
  options.station_frames = 1;
  EXPECT_FALSE(write_demo_data(folder_, options, nullptr));
  EXPECT_FALSE(fs::exists(folder_));
}

TEST_F(DemoData, SaysSoWhenTheFolderHoldsARecordingOrCannotBeMade) {
  DemoOptions options;
  options.station_frames = 2;
  options.device_frames = 2;
  ASSERT_TRUE(succeeded(write_demo_data(folder_, options, nullptr)));
  const Status again = write_demo_data(folder_, options, nullptr);
  ASSERT_FALSE(again);
  EXPECT_NE(again.error().message.find("recording"), std::string::npos);
  const Status in_a_file = write_demo_data(folder_ / "markers.yaml" / "below", options, nullptr);
  ASSERT_FALSE(in_a_file);
  EXPECT_NE(in_a_file.error().message.find("folder"), std::string::npos);
}

TEST(Parallel, TurnsComeInOrderEvenWhenWorkIsSkipped) {
  Turns turns;
  std::vector<int> order;
  for_each_parallel(200, 4, [&](int i) {
    Turns::Turn turn(turns, i);
    if (i % 3 == 0) return;
    turn.wait();
    order.push_back(i);
  });
  EXPECT_EQ(order.size(), 133u);
  EXPECT_TRUE(std::is_sorted(order.begin(), order.end()));
}

}  // namespace
}  // namespace meshloop::simulation
