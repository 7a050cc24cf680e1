#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "comparator_fixture.h"

namespace meshloop {
namespace {

using namespace compare_test;

// True where a pixel within `reach` shows another node, or none.
bool is_near_edge(const Image<std::uint32_t>& nodes, int u, int v, int reach) {
  for (int y = std::max(v - reach, 0); y <= std::min(v + reach, nodes.height() - 1); ++y) {
    for (int x = std::max(u - reach, 0); x <= std::min(u + reach, nodes.width() - 1); ++x) {
      if (nodes(x, y) != nodes(u, v)) return true;
    }
  }
  return false;
}

double agreement(const Image<Label>& a, const Image<Label>& b) {
  std::size_t same = 0;
  for (std::size_t i = 0; i < a.size(); ++i) same += a.data()[i] == b.data()[i] ? 1U : 0U;
  return static_cast<double>(same) / static_cast<double>(a.size());
}

TEST_F(ComparatorTest, ExpectedDepthIsThatOfTheCpuAwayFromEdges) {
  look_at(model_, 1);
  const auto cpu = on_cpu();
  const auto gpu = on_gpu();
  std::size_t compared = 0;
  double sum_m = 0;
  double largest_m = 0;
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) {
      if (is_near_edge(cpu.node_index, u, v, 1)) continue;
      ASSERT_EQ(cpu.node_index(u, v), gpu.node_index(u, v)) << u << ", " << v;
      const double apart_m =
          std::abs(static_cast<double>(cpu.expected(u, v)) - static_cast<double>(gpu.expected(u, v)));
      ASSERT_LE(apart_m, 2e-5) << u << ", " << v;
      sum_m += apart_m;
      largest_m = std::max(largest_m, apart_m);
      ++compared;
    }
  }
  EXPECT_GT(compared, 320U * 240U * 9 / 10);
  // The figures of common/gpu/README.md.
  RecordProperty("mean_um", std::to_string(1e6 * sum_m / static_cast<double>(compared)));
  RecordProperty("largest_um", std::to_string(1e6 * largest_m));
}

TEST_F(ComparatorTest, LabelsAgreeWithTheCpuForEverySensorAndThreshold) {
  const auto constant = SensorModel::constant(0.002);
  ASSERT_TRUE(constant);
  const SensorModel sensors[] = {SensorModel{SensorModel::Kind::kinect1},
                                 SensorModel{SensorModel::Kind::kinect1_khoshelham},
                                 SensorModel{SensorModel::Kind::tof}, *constant};
  const Threshold thresholds[] = {{Threshold::Kind::fixed, 0.02}, {Threshold::Kind::k_sigma, 3}};
  unsigned seed = 10;
  for (const auto& sensor : sensors) {
    for (const auto& threshold : thresholds) {
      input_.sensor = sensor;
      input_.threshold = threshold;
      look_at(changed_model(), ++seed);
      const auto cpu = on_cpu();
      const auto gpu = on_gpu();
      EXPECT_GE(agreement(cpu.labels, gpu.labels), 0.999) << sensor.name() << ", threshold " << threshold.value;
      for (const Label label : {Label::unmeasured, Label::unmodelled, Label::closer, Label::farther, Label::agrees}) {
        EXPECT_GT(cpu.counts()[static_cast<std::size_t>(label)], 50U) << sensor.name() << ": " << info(label).name;
      }
    }
  }
}

TEST_F(ComparatorTest, ThresholdsAndDifferencesAreThoseOfTheCpu) {
  look_at(changed_model(), 3);
  const auto cpu = on_cpu();
  const auto gpu = on_gpu();
  std::size_t compared = 0;
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) {
      if (is_near_edge(cpu.node_index, u, v, 2)) continue;
      const float threshold = cpu.threshold_m(u, v);
      if (std::isinf(threshold) || std::isinf(gpu.threshold_m(u, v))) continue;
      // The slope of a rendered ball changes from triangle to triangle.
      if (cpu.node_index(u, v) != 4) {
        ASSERT_NEAR(gpu.threshold_m(u, v), threshold, 0.01 * threshold) << u << ", " << v;
        ++compared;
      }
      ASSERT_EQ(std::isnan(cpu.difference_m(u, v)), std::isnan(gpu.difference_m(u, v)));
      if (!std::isnan(cpu.difference_m(u, v))) {
        ASSERT_NEAR(cpu.difference_m(u, v), gpu.difference_m(u, v), 1e-4);
      }
    }
  }
  EXPECT_GT(compared, 40000U);
}

// Every term of the threshold at once, each large enough to be missed.
TEST_F(ComparatorTest, AllTermsOfTheThresholdAreThoseOfTheCpu) {
  SensorNoise noise;
  noise.axial = {0.002, -0.001, 0.002};
  noise.nearest_m = 1.3;
  noise.farthest_m = 2.2;  // the room lies before, in and behind the range
  noise.step_per_m = 0.004;
  noise.lateral_px = 0.7;
  input_.sensor = SensorModel::measured(noise).value();
  Eigen::Matrix4d A;
  A << 2, 0.5, -1, 0.3, 0.2, 3, 0.4, -0.6, 1, 0, 2, 0.5, -0.3, 0.8, 0.1, 1.5;
  input_.intrinsics_covariance = A * A.transpose();
  input_.model_sigma_m = 0.002;
  Image<std::uint8_t> frames(320, 240);
  for (std::size_t i = 0; i < frames.size(); ++i) frames.data()[i] = static_cast<std::uint8_t>(i % 13);
  look_at(changed_model(), 5);
  const auto one_frame = on_gpu();
  EXPECT_GE(agreement(on_cpu().labels, one_frame.labels), 0.999);
  input_.frames_averaged = &frames;
  const auto cpu = on_cpu();
  const auto gpu = on_gpu();
  EXPECT_GE(agreement(cpu.labels, gpu.labels), 0.999);
  std::size_t compared = 0;
  std::size_t smaller = 0;
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) {
      const float threshold = cpu.threshold_m(u, v);
      if (is_near_edge(cpu.node_index, u, v, 2) || cpu.node_index(u, v) == 4) continue;
      if (std::isinf(threshold) || std::isinf(gpu.threshold_m(u, v))) continue;
      ASSERT_NEAR(gpu.threshold_m(u, v), threshold, 0.01 * threshold) << u << ", " << v;
      ++compared;
      smaller += gpu.threshold_m(u, v) < one_frame.threshold_m(u, v) ? 1 : 0;
    }
  }
  EXPECT_GT(compared, 40000U);
  EXPECT_GT(smaller, compared / 2);
}

TEST_F(ComparatorTest, NoiseFreeComparisonIsExactToThePixel) {
  input_.sensor = *SensorModel::constant(0.0005);
  input_.pose.covariance = 1e-12 * PoseCovariance::Identity();
  Model real = model_;
  add(real, box({0.2F, 0.3F, 0.2F}), at(0.5, 0.3, 1.3, 0.4));
  const DepthImage exact = render_depth(real, input_.camera, input_.pose.T_camera_world);
  measured_ = exact;
  const DepthImage expected = render_depth(model_, input_.camera, input_.pose.T_camera_world);
  const auto labels = on_cpu().labels;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const Label label = labels.data()[i];
    if (label == Label::undecided) continue;
    const bool is_changed = exact.data()[i] != expected.data()[i];
    ASSERT_EQ(is_change(label), is_changed) << i;
  }
  EXPECT_LT(on_cpu().counts()[static_cast<std::size_t>(Label::undecided)], 320U * 240U / 200);
}

TEST_F(ComparatorTest, NoiseAloneIsRarelyAChange) {
  for (const auto kind : {SensorModel::Kind::kinect1, SensorModel::Kind::tof}) {
    input_.sensor = SensorModel{kind};
    look_at(model_, 21);
    const auto counts = on_gpu().counts();
    const auto changes = counts[1] + counts[2] + counts[3];
    EXPECT_LT(static_cast<double>(changes), 0.005 * 320 * 240) << input_.sensor.name();
    EXPECT_GT(static_cast<double>(counts[4]), 0.7 * 320 * 240) << input_.sensor.name();
  }
}

TEST_F(ComparatorTest, BorderOfWhatIsGoneIsUndecidedWhereNothingElseIsModelled) {
  input_.sensor = SensorModel{SensorModel::Kind::kinect1};
  input_.pose.covariance.setZero();
  input_.pose.T_camera_world = Pose::Identity();
  model_.nodes.clear();
  add(model_, quad({-0.3F, -0.2F, 1}, {0.3F, -0.2F, 1}, {0.3F, 0.2F, 1}, {-0.3F, 0.2F, 1}), Pose::Identity());
  measured_ = DepthImage(320, 240, 3.0F);
  const auto result = on_gpu();
  for (int v = 0; v < 240; ++v) {
    for (int u = 0; u < 320; ++u) {
      if (result.node_index(u, v) == 0) {
        ASSERT_EQ(result.labels(u, v), Label::unmodelled);
      } else {
        const bool at_border = is_near_edge(result.node_index, u, v, 2);
        ASSERT_EQ(result.labels(u, v), at_border ? Label::undecided : Label::farther) << u << ", " << v;
      }
    }
  }
  EXPECT_GT(result.counts()[static_cast<std::size_t>(Label::farther)], 10000U);
}

TEST_F(ComparatorTest, SurfaceSeenAlmostFromTheSideIsUndecided) {
  input_.sensor = *SensorModel::constant(0.0005);
  input_.pose.covariance.setZero();
  input_.pose.T_camera_world = Pose::Identity();
  // A floor 10 cm below the camera: seen at 88 degrees at 2.9 m.
  model_.nodes.clear();
  add(model_, quad({-9, 0.1F, 0.2F}, {9, 0.1F, 0.2F}, {9, 0.1F, 12}, {-9, 0.1F, 12}), Pose::Identity());
  measured_ = render_depth(model_, input_.camera, Pose::Identity());
  const auto result = on_gpu();
  const double row_at_88 = input_.camera.cy + input_.camera.fy * std::tan(2 * std::numbers::pi / 180);
  for (int v = 0; v < 240; ++v) {
    const int u = static_cast<int>(std::lround(input_.camera.cx));
    if (result.expected(u, v) == 0 || std::abs(v - row_at_88) < 2) continue;
    ASSERT_EQ(result.labels(u, v), v > row_at_88 ? Label::agrees : Label::undecided) << v;
  }
  EXPECT_GT(result.counts()[static_cast<std::size_t>(Label::undecided)], 1000U);
}

TEST_F(ComparatorTest, PoseThatIsUncertainRaisesTheThreshold) {
  look_at(model_, 5);
  const auto sure = on_gpu();
  input_.pose.covariance(2, 2) = 0.02 * 0.02;
  const auto unsure = on_gpu();
  EXPECT_GT(unsure.threshold_m(200, 40), 3 * 0.02F);
  EXPECT_LT(sure.threshold_m(200, 40), 3 * 0.02F);
}

TEST_F(ComparatorTest, EmptyModelMakesEverythingMeasuredUnmodelled) {
  look_at(model_, 6);
  model_.nodes.clear();
  const auto result = on_gpu();
  for (std::size_t i = 0; i < measured_.size(); ++i) {
    const bool is_measured = measured_.data()[i] > 0;
    ASSERT_EQ(result.labels.data()[i], is_measured ? Label::unmodelled : Label::unmeasured);
    ASSERT_TRUE(std::isnan(result.difference_m.data()[i]));
  }
}

TEST_F(ComparatorTest, ValuesThatAreNotDepthsAreUnmeasured) {
  look_at(model_, 7);
  measured_(5, 100) = std::numeric_limits<float>::quiet_NaN();
  measured_(6, 100) = std::numeric_limits<float>::infinity();
  measured_(7, 100) = -1;
  for (const auto& result : {on_gpu(), on_cpu()}) {
    for (int u = 5; u <= 7; ++u) {
      EXPECT_EQ(result.labels(u, 100), Label::unmeasured);
      EXPECT_TRUE(std::isnan(result.difference_m(u, 100)));
      EXPECT_TRUE(std::isinf(result.threshold_m(u, 100)));
    }
  }
}

TEST_F(ComparatorTest, SizeMayChangeFromFrameToFrame) {
  look_at(model_, 8);
  on_gpu();
  input_.camera = camera_of(160, 120);
  look_at(model_, 8);
  const auto result = on_gpu();
  EXPECT_EQ(result.labels.width(), 160);
  EXPECT_GE(agreement(on_cpu().labels, result.labels), 0.998);
}

TEST_F(ComparatorTest, TimesAreOfEachStep) {
  look_at(model_, 9);
  CompareTimes times;
  ASSERT_TRUE(comparator_->compare(input_, &times));
  EXPECT_GT(times.upload_ms, 0);
  EXPECT_GT(times.render_ms, 0);
  EXPECT_GT(times.compare_ms, 0);
  EXPECT_GT(times.readback_ms, 0);
}

}  // namespace
}  // namespace meshloop
