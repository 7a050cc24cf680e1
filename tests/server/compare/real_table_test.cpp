// Real Kinect images of a table with things on it, against the bare table. Needs the data folder beside the repository.
#include <array>
#include <cstdio>
#include <filesystem>

#include "common/image/image_file.h"
#include "common/interchange/model_file.h"
#include "comparator_fixture.h"
#include "server/compare/region_tracker.h"

namespace meshloop {
namespace {

namespace fs = std::filesystem;
using namespace compare_test;

const fs::path kTables = fs::path{__FILE__}.parent_path() / "../../../../shared/data/mosd_table";
// In the masks: 0 table, 1 thing on it.
constexpr std::uint8_t kThing = 1;
constexpr std::uint8_t kIgnored = 255;

Camera registered_kinect() {
  return {640, 480, 525, 525, 319.5, 239.5, {}};
}

DepthImage metres(const Image<std::uint16_t>& millimetres) {
  DepthImage depth(millimetres.width(), millimetres.height());
  std::transform(millimetres.pixels().begin(), millimetres.pixels().end(), depth.pixels().begin(),
                 [](std::uint16_t mm) { return 0.001F * static_cast<float>(mm); });
  return depth;
}

double closer_iou(const Image<Label>& labels, const GreyImage& truth) {
  double both = 0;
  double either = 0;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    if (truth.data()[i] == kIgnored) continue;
    const bool is_thing = truth.data()[i] == kThing;
    const bool is_closer = labels.data()[i] == Label::closer;
    both += is_thing && is_closer ? 1 : 0;
    either += is_thing || is_closer ? 1 : 0;
  }
  return both / either;
}

class RealTable : public ComparatorTest, public testing::WithParamInterface<const char*> {};

TEST_P(RealTable, ThingsOnItAreCloser) {
  if (!fs::exists(kTables)) GTEST_SKIP() << "needs '" << kTables.lexically_normal().string() << "'";
  const std::string name = GetParam();
  const auto model = import_as_model(kTables / (name + "_table.obj"));
  ASSERT_TRUE(model) << model.error().message;
  const auto depth = read_png16(kTables / (name + "_depth.png"));
  ASSERT_TRUE(depth) << depth.error().message;
  const auto truth = read_png8(kTables / (name + "_gt.png"));
  ASSERT_TRUE(truth) << truth.error().message;
  input_.model = &model->model;
  input_.camera = registered_kinect();
  input_.sensor = SensorModel{SensorModel::Kind::kinect1};
  input_.pose = {};
  input_.pose.state = TrackState::tracking;
  measured_ = metres(*depth);
  auto result = on_gpu();
  RegionTracker tracker{RegionOptions{}};
  settle_labels(result, tracker.update(result, measured_, input_.camera, Pose::Identity()));
  const double iou = closer_iou(result.labels, *truth);
  std::printf("%s: IoU of closer %.4f; here: %.1f mm\n", name.c_str(), iou, 1e3 * *result.smallest_change_m());
  EXPECT_GE(iou, 0.97);
}

INSTANTIATE_TEST_SUITE_P(Scenes, RealTable, testing::Values("learn3", "learn18", "learn27", "learn36"),
                         [](const auto& scene) { return std::string{scene.param}; });

}  // namespace
}  // namespace meshloop
