// A box of 10 cm that stands 2 cm nearer, or farther, than the model says, seen by a simulated Kinect.
#include <cmath>
#include <cstdio>
#include <set>
#include <vector>

#include "sanitized.h"
#include "server/compare/frame_average.h"
#include "simulated_view.h"

namespace meshloop {
namespace {

using namespace compare_test;

constexpr double kMove_m = 0.02;
constexpr int kFrames = 10;
constexpr int kRim_px = 3;
// Number of the box in a cast image.
constexpr std::uint16_t kBoxNumber = 2;

// A hand that moves sideways and turns; 10 frames at 30 Hz with 0.3 m/s.
Pose pose_at(int frame) {
  const Eigen::Vector3d eye{0.01 * frame - 0.05, 0.004 * frame - 0.02, 0.002 * frame};
  return look_at(eye, {0.005 * frame, 0, 1.5}, {0, -1, 0}).inverse();
}

struct Recall {
  int trials = 0;
  /// The box lies in a confirmed region within kFrames frames.
  int found = 0;
  /// Of the box's front, as far as it was measured: the share inside a confirmed region in the last frame.
  double covered = 0;
  /// Regions away from the box.
  int false_regions = 0;
};

class SmallChange : public SimulatedViewTest {
 protected:
  void SetUp() override {
    SimulatedViewTest::SetUp();
    camera_ = kinect_camera(640);
  }

  // Pixels of the box's front that show it before and after, but for its rim: there lateral noise mixes it with the
  // wall.
  Image<std::uint8_t> front_of(const simulation::Scene& before, const simulation::Scene& after, const Pose& pose) {
    const auto old_depth = simulation::cast_depth(before, camera_, pose, false);
    const auto new_depth = simulation::cast_depth(after, camera_, pose, false);
    const auto shows_front = [&](int u, int v) {
      return old_depth.solid(u, v) == kBoxNumber && new_depth.solid(u, v) == kBoxNumber &&
             old_depth.cos_theta(u, v) > 0.8F && new_depth.cos_theta(u, v) > 0.8F;
    };
    Image<std::uint8_t> front(camera_.width, camera_.height);
    for (int v = kRim_px; v < camera_.height - kRim_px; ++v) {
      for (int u = kRim_px; u < camera_.width - kRim_px; ++u) {
        const bool inside = shows_front(u - kRim_px, v - kRim_px) && shows_front(u + kRim_px, v - kRim_px) &&
                            shows_front(u - kRim_px, v + kRim_px) && shows_front(u + kRim_px, v + kRim_px);
        front(u, v) = inside ? 1 : 0;
      }
    }
    return front;
  }

  static std::vector<bool> confirmed_ids(const RegionMap& map) {
    std::vector<bool> confirmed(1, false);
    for (const Region& region : map.regions) {
      confirmed.resize(std::max<std::size_t>(confirmed.size(), region.id + 1), false);
      confirmed[region.id] = region.confirmed;
    }
    return confirmed;
  }

  static double covered_share(const SimulatedFrame& frame, const Image<std::uint8_t>& front) {
    const auto confirmed = confirmed_ids(frame.regions);
    double covered = 0;
    double all = 0;
    for (std::size_t i = 0; i < front.size(); ++i) {
      if (front.data()[i] == 0 || frame.measured.data()[i] <= 0) continue;
      ++all;
      covered += confirmed[frame.regions.ids.data()[i]] ? 1 : 0;
    }
    return covered / all;
  }

  static int regions_beside(const RegionMap& map, const Image<std::uint8_t>& front) {
    std::set<RegionId> on_front;
    for (std::size_t i = 0; i < front.size(); ++i) {
      if (front.data()[i] != 0) on_front.insert(map.ids.data()[i]);
    }
    return static_cast<int>(std::count_if(map.regions.begin(), map.regions.end(),
                                          [&](const Region& region) { return !on_front.contains(region.id); }));
  }

  void try_once(double distance_m, double move_m, std::uint64_t seed, Recall& recall) {
    // Places all over the middle of the picture.
    const double x = distance_m * 0.25 * std::sin(2.4 * static_cast<double>(seed));
    const double y = distance_m * 0.18 * std::cos(1.7 * static_cast<double>(seed));
    const auto before = box_before_wall(distance_m, x, y);
    const auto after = simulation::with_moved_object(before, "box", {0, 0, move_m});
    const Model model = model_of(before, 0.5);
    RegionTracker tracker{RegionOptions{}};
    SimulatedFrame frame;
    for (int i = 0; i < kFrames; ++i) {
      frame = look(model, after, false, pose_at(i), 1000 * seed + static_cast<std::uint64_t>(i), tracker);
    }
    const auto front = front_of(before, after, pose_at(kFrames - 1));
    const double covered = covered_share(frame, front);
    ++recall.trials;
    recall.found += covered > 0.25 ? 1 : 0;
    recall.covered += covered;
    recall.false_regions += regions_beside(frame.regions, front);
  }

  Recall measure_recall(double distance_m, double move_m) {
    Recall recall;
    const std::uint64_t trials = test::kSanitized ? 1 : 12;
    for (std::uint64_t seed = 1; seed <= trials; ++seed) try_once(distance_m, move_m, seed, recall);
    recall.covered /= recall.trials;
    std::printf("%+.0f cm at %.0f m, %dx%d: found %d of %d, %.4f of its front, %d other regions\n", 100 * move_m,
                distance_m, camera_.width, camera_.height, recall.found, recall.trials, recall.covered,
                recall.false_regions);
    return recall;
  }
};

TEST_F(SmallChange, IsFoundAtOneMetreAndCovered) {
  for (const double move_m : {-kMove_m, kMove_m}) {
    const auto recall = measure_recall(1, move_m);
    EXPECT_EQ(recall.found, recall.trials) << move_m;
    EXPECT_GE(recall.covered, 0.99) << move_m;
    EXPECT_EQ(recall.false_regions, 0) << move_m;
  }
}

// 2 cm are 3.3 sigma there: of ten pixels six are above the threshold in a frame. The region is found in every trial.
TEST_F(SmallChange, IsFoundAtTwoMetres) {
  for (const double move_m : {-kMove_m, kMove_m}) {
    const auto recall = measure_recall(2, move_m);
    EXPECT_GE(recall.found, 0.9 * recall.trials) << move_m;
    EXPECT_EQ(recall.false_regions, 0) << move_m;
  }
}

TEST_F(SmallChange, IsCoveredAtTwoMetresInTheMeanOfTenFrames) {
  const auto before = box_before_wall(2, 0.1, -0.05);
  const Model model = model_of(before, 0.5);
  for (const double move_m : {-kMove_m, kMove_m}) {
    const auto after = simulation::with_moved_object(before, "box", {0, 0, move_m});
    FrameAverage average{camera_, sensor_};
    TrackedPose pose;
    pose.state = TrackState::tracking;
    pose.T_camera_world = pose_at(0);
    for (std::uint64_t i = 0; i < kFrames; ++i) {
      ASSERT_TRUE(average.add(sense(after, false, pose_at(0), 50 + i), pose));
    }
    const auto mean = average.result();
    SimulatedFrame frame{mean.mean, compare(model, mean.mean, pose_at(0), &mean.frames), {}};
    RegionTracker tracker{RegionOptions{}};
    frame.regions = tracker.update(frame.comparison, mean.mean, camera_, pose_at(0), mean.count);
    const auto front = front_of(before, after, pose_at(0));
    const double covered = covered_share(frame, front);
    std::printf("%+.0f cm at 2 m, mean of %d frames: %.4f of its front; here: %.1f mm instead of %.1f\n", 100 * move_m,
                mean.count, covered, 1e3 * *frame.comparison.smallest_change_m(),
                1e3 * *compare(model, mean.mean, pose_at(0)).smallest_change_m());
    EXPECT_GE(covered, 0.9);
    EXPECT_EQ(regions_beside(frame.regions, front), 0);
  }
}

}  // namespace
}  // namespace meshloop
