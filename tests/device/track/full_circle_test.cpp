// Measures, not run by default (about two minutes):
//   test-device-track --gtest_also_run_disabled_tests --gtest_filter='*FullCircle*'
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <vector>

#include "common/base/clock.h"
#include "device/track/model_tracker.h"
#include "simulated_walk.h"

namespace meshloop {
namespace {

constexpr int kFrames = 180;

Camera full_camera() {
  return {640, 480, 525, 525, 319.5, 239.5, {}};
}

test::WalkResult circle(const simulation::Scene& scene, const std::shared_ptr<const Model>& model, const char* name) {
  auto context = GpuContext::create_headless();
  auto tracker = ModelTracker::create(**context, full_camera(), {});
  const auto result = test::walk(**tracker, scene, model, full_camera(), kFrames, 360.0 / kFrames);
  std::printf("%-28s %8zu triangles: mean %.2f mm, max %.2f mm, lost %d, quality at least %.2f\n", name,
              model->triangle_count(), 1000 * result.mean_m, 1000 * result.max_m, result.lost, result.lowest_quality);
  return result;
}

TEST(FullCircle, DISABLED_MeanErrorIsBelowACentimetre) {
  const auto scene = simulation::make_demo_scene(1);
  const auto moved = simulation::with_moved_object(scene, "box", {0.02, 0, 0});
  const auto right = circle(scene, test::model_of(scene, false), "right model");
  const auto lacking = circle(scene, test::model_of(scene, true), "without box and car");
  const auto stale = circle(moved, test::model_of(scene, false), "box moved by 2 cm");
  const auto bare = circle(scene, test::without_colors(*test::model_of(scene, false)), "model without colours");
  EXPECT_LT(right.mean_m, 0.002);
  EXPECT_LT(lacking.mean_m, 0.01);
  EXPECT_LT(stale.mean_m, 0.01);
  EXPECT_EQ(right.lost + lacking.lost + stale.lost, 0);
  EXPECT_GT(bare.max_m, right.max_m);
}

TEST(FullCircle, DISABLED_TimeOfAFrame) {
  const auto scene = simulation::make_demo_scene(1);
  const auto model = test::model_of(scene, false);
  auto context = GpuContext::create_headless();
  auto tracker = ModelTracker::create(**context, full_camera(), {});
  std::vector<ColorFrame> frames;
  for (int i = 0; i < 20; ++i) frames.push_back(test::frame_at(scene, full_camera(), test::pose_at(2.0 * i), i));
  (*tracker)->start_at(test::pose_at(0));
  std::vector<double> times_ms;
  for (const auto& frame : frames) {
    const Stopwatch watch;
    ASSERT_EQ((*tracker)->track(frame, model).state, TrackState::tracking);
    times_ms.push_back(watch.milliseconds());
  }
  std::sort(times_ms.begin(), times_ms.end());
  std::printf("%s: %zu triangles, median %.1f ms a frame, slowest %.1f ms\n", (*context)->description().c_str(),
              model->triangle_count(), times_ms[times_ms.size() / 2], times_ms.back());
}

}  // namespace
}  // namespace meshloop
