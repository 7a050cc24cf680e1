#include "server/adjust/depth_fusion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

#include "boxes.h"

namespace meshloop {
namespace {

using boxes::Box;

const SensorModel kKinect{SensorModel::Kind::kinect1};
const Camera kCamera{320, 240, 290, 290, 159.5, 119.5, {}};
const std::vector<Box> kScene{{{-2, -2, 2}, {2, 2, 2.1}, 1}, {{-0.3, -0.2, 1.2}, {0.3, 0.3, 1.5}, 2}};

/// A hand that holds still as well as it can.
Pose held_pose(int i) {
  const double s = i * 2.1;
  return look_at({0.3 + 0.004 * std::sin(s), -0.3 + 0.004 * std::cos(1.3 * s), 0.003 * std::sin(0.7 * s)}, {0, 0, 1.4},
                 {0, -1, 0})
      .inverse();
}

struct Frames {
  std::vector<DepthImage> depths;
  std::vector<DepthView> views;

  explicit Frames(int count) {
    depths.reserve(static_cast<std::size_t>(count));
    for (int i = 0; i < count; ++i) {
      depths.push_back(boxes::measure(kScene, kCamera, held_pose(i), kKinect, 100u + static_cast<unsigned>(i)));
      views.push_back({&depths.back(), held_pose(i)});
    }
  }
};

/// Root mean square and mean distance from the truth, in sigma of one measurement.
struct Error {
  double rms = 0;
  double mean = 0;
  double beyond_5_sigma = 0;
};
Error error_of(const DepthImage& depth) {
  const auto truth = boxes::cast(kScene, kCamera, held_pose(0)).depth;
  Error error;
  int count = 0;
  int far_off = 0;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const auto z = static_cast<double>(depth.pixels()[i]);
    const auto true_z = static_cast<double>(truth.pixels()[i]);
    if (!(z > 0) || !(true_z > 0)) continue;
    const double sigmas = (z - true_z) / kKinect.sigma_z_m(true_z, 0);
    if (std::abs(sigmas) > 5) {
      ++far_off;
      continue;
    }
    error.rms += sigmas * sigmas;
    error.mean += std::abs(sigmas);
    ++count;
  }
  error.rms = std::sqrt(error.rms / count);
  error.mean /= count;
  error.beyond_5_sigma = static_cast<double>(far_off) / count;
  return error;
}

TEST(DepthFusion, EightFramesHaveLessThanHalfTheNoiseOfOne) {
  const Frames frames{8};
  const auto fused = fuse_depth(frames.views, kCamera, kKinect, {});
  const Error one = error_of(frames.depths[0]);
  const Error eight = error_of(fused.depth);
  std::printf("one frame: rms %.2f, mean %.2f sigma, %.4f beyond five; eight: %.2f, %.2f, %.4f\n", one.rms, one.mean,
              one.beyond_5_sigma, eight.rms, eight.mean, eight.beyond_5_sigma);
  EXPECT_LT(eight.rms, 0.5 * one.rms);
  EXPECT_LT(eight.mean, 0.4);
  EXPECT_LE(eight.beyond_5_sigma, one.beyond_5_sigma);
}

TEST(DepthFusion, OneFrameStaysAsItIs) {
  const Frames frames{1};
  const auto fused = fuse_depth(frames.views, kCamera, kKinect, {});
  for (std::size_t i = 0; i < fused.depth.size(); ++i) {
    ASSERT_EQ(fused.depth.pixels()[i], frames.depths[0].pixels()[i]) << i;
  }
}

TEST(DepthFusion, OutsideTheMaskStaysAsItIs) {
  const Frames frames{4};
  Image<std::uint8_t> mask{kCamera.width, kCamera.height};
  mask(160, 120) = 1;
  const auto fused = fuse_depth(frames.views, kCamera, kKinect, mask);
  EXPECT_GT(fused.measurements(160, 120), 1);
  EXPECT_EQ(fused.measurements(10, 10), 1);
  EXPECT_EQ(fused.depth(10, 10), frames.depths[0](10, 10));
}

TEST(DepthFusion, WhatOneFrameAloneSawIsLeftOut) {
  Frames frames{5};
  for (int y = 100; y < 120; ++y) {
    for (int x = 100; x < 120; ++x) frames.depths[0](x, y) = 0.9f;  // something flew by
  }
  const auto fused = fuse_depth(frames.views, kCamera, kKinect, {});
  EXPECT_EQ(fused.depth(110, 110), 0);
  EXPECT_EQ(fused.measurements(110, 110), 0);
}

TEST(DepthFusion, WhatStandsBeforeASurfaceInOtherFramesDoesNotMoveIt) {
  Frames frames{5};
  for (std::size_t i = 1; i < 5; ++i) {
    for (int y = 100; y < 120; ++y) {
      for (int x = 100; x < 120; ++x) frames.depths[i](x, y) = 0.9f;
    }
  }
  const auto fused = fuse_depth(frames.views, kCamera, kKinect, {});
  EXPECT_EQ(fused.depth(110, 110), frames.depths[0](110, 110));
  EXPECT_EQ(fused.measurements(110, 110), 1);
}

// A box came after the third frame: the first three have no say about it, and do not keep it away.
TEST(DepthFusion, FramesFromBeforeAChangeHaveNoSay) {
  std::vector<Box> with_box = kScene;
  with_box.push_back({{-0.1, -0.5, 1.0}, {0.1, -0.2, 1.2}});
  std::vector<DepthImage> depths;
  std::vector<DepthView> views;
  depths.reserve(5);
  for (int i = 0; i < 5; ++i) {
    depths.push_back(
        boxes::measure(i < 2 ? with_box : kScene, kCamera, held_pose(i), kKinect, 50u + static_cast<unsigned>(i)));
    views.push_back({&depths.back(), held_pose(i)});
  }
  const auto truth = boxes::cast(with_box, kCamera, held_pose(0));
  Image<std::uint8_t> mask{kCamera.width, kCamera.height, 1};
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (truth.box.pixels()[i] == 3) mask.pixels()[i] = 2;
  }
  const auto fused = fuse_depth(views, kCamera, kKinect, mask);
  EXPECT_EQ(fused.views, 2u);
  int kept = 0;
  int all = 0;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (mask.pixels()[i] != 2 || !(depths[0].pixels()[i] > 0)) continue;
    ++all;
    kept += fused.depth.pixels()[i] > 0 ? 1 : 0;
  }
  EXPECT_GT(all, 1000);
  EXPECT_EQ(kept, all);
}

// A wall at 2 m, seen again from 1 m, where the noise is a third: the nearer view counts most.
TEST(DepthFusion, EachViewCountsByItsOwnNoise) {
  const std::vector<Box> wall{{{-3, -3, 2}, {3, 3, 2.1}, 1}};
  const Pose nearer = make_pose({0, 0, -1}, Eigen::Quaterniond::Identity());
  std::mt19937 random{9};
  std::normal_distribution<float> any;
  std::vector<DepthImage> depths;
  for (const auto& pose : {Pose::Identity(), nearer}) {
    depths.push_back(boxes::cast(wall, kCamera, pose).depth);
    for (auto& z : depths.back().pixels())
      z += any(random) * static_cast<float>(kKinect.sigma_z_m(static_cast<double>(z), 0));
  }
  const auto fused =
      fuse_depth(std::vector<DepthView>{{&depths[0], Pose::Identity()}, {&depths[1], nearer}}, kCamera, kKinect, {});
  double squares = 0;
  int count = 0;
  for (std::size_t i = 0; i < fused.depth.size(); ++i) {
    if (fused.measurements.pixels()[i] != 2) continue;
    const double off = static_cast<double>(fused.depth.pixels()[i]) - 2;
    squares += off * off;
    ++count;
  }
  const double rms_m = std::sqrt(squares / count);
  const double plain_mean_m = std::hypot(kKinect.sigma_z_m(2, 0), kKinect.sigma_z_m(1, 0)) / 2;
  std::printf("rms %.2f mm, of the plain mean %.2f\n", 1000 * rms_m, 1000 * plain_mean_m);
  ASSERT_GT(count, 15'000);
  EXPECT_LT(rms_m, 0.6 * plain_mean_m);
  EXPECT_LT(rms_m, kKinect.sigma_z_m(1, 0));
}

TEST(DepthFusion, AveragesAcrossViewsThatAreApart) {
  // Exact depth from places 20 cm apart: what is fused is as exact as what is looked up between pixels.
  std::vector<DepthImage> depths;
  std::vector<DepthView> views;
  depths.reserve(3);
  for (int i = 0; i < 3; ++i) {
    const Pose pose = look_at({0.2 * i - 0.2, -0.3, 0}, {0, 0, 1.4}, {0, -1, 0}).inverse();
    depths.push_back(boxes::cast(kScene, kCamera, pose).depth);
    views.push_back({&depths.back(), pose});
  }
  const auto fused = fuse_depth(views, kCamera, kKinect, {});
  int of_three = 0;
  int on_faces = 0;  // not where a pixel lies between two faces
  for (std::size_t i = 0; i < fused.depth.size(); ++i) {
    if (fused.measurements.pixels()[i] < 3) continue;
    ++of_three;
    const float error_m = std::abs(fused.depth.pixels()[i] - depths[0].pixels()[i]);
    on_faces += error_m < 1e-4f ? 1 : 0;
    EXPECT_LT(error_m, 3 * kKinect.sigma_z_m(static_cast<double>(depths[0].pixels()[i]), 0)) << i;
  }
  std::printf("%d of three, %d on faces\n", of_three, on_faces);
  EXPECT_GT(of_three, 20'000);
  EXPECT_GT(on_faces, 0.99 * of_three);
}

}  // namespace
}  // namespace meshloop
