#include "server/show/carry.h"

#include <gtest/gtest.h>

#include <cmath>

#include "carry_on_cpu.h"
#include "common/simulation/camera_path.h"
#include "common/simulation/demo_scene.h"
#include "common/simulation/sensor.h"

namespace meshloop {
namespace {

struct Sizes {
  const char* name;
  int depth_width;
  int depth_height;
  int color_width;
  int color_height;
  double baseline_m;
  double noise;
};

Rig rig_of(const Sizes& sizes) {
  const auto camera = [](int width, int height, double focal) {
    return Camera{width, height, focal * width, focal * width, (width - 1) / 2.0, (height - 1) / 2.0, {}};
  };
  Rig rig;
  rig.depth = camera(sizes.depth_width, sizes.depth_height, 0.91);
  rig.color = camera(sizes.color_width, sizes.color_height, 0.82);
  rig.T_depth_color =
      make_pose({sizes.baseline_m, 0.004, -0.002},
                Eigen::Quaterniond{Eigen::AngleAxisd{0.01, Eigen::Vector3d{0.3, 0.9, 0.2}.normalized()}});
  return rig;
}

/// The demo's scene, of which the model knows a part.
struct Seen {
  DepthImage measured;
  Comparison comparison;
};

Label label_of(float measured, float expected) {
  if (!(measured > 0)) return Label::unmeasured;
  if (!(expected > 0)) return Label::unmodelled;
  if (std::abs(measured - expected) < 0.02f) return Label::agrees;
  return measured < expected ? Label::closer : Label::farther;
}

Seen look(const Rig& rig, double noise) {
  const auto scene = simulation::make_demo_scene(1);
  const Pose T_depth_world = rig.T_depth_color * simulation::StationPath{}.at(0.8).inverse();
  Seen seen;
  const auto exact = simulation::cast_depth(scene, rig.depth, T_depth_world, false);
  seen.measured = simulation::measure(exact, rig.depth, rig.sensor, {noise, 7});
  Comparison& c = seen.comparison;
  c.expected = simulation::cast_depth(scene, rig.depth, T_depth_world, true).depth;
  c.labels = Image<Label>{rig.depth.width, rig.depth.height};
  c.difference_m = Image<float>{rig.depth.width, rig.depth.height};
  for (std::size_t i = 0; i < c.labels.size(); ++i) {
    c.labels.data()[i] = label_of(seen.measured.data()[i], c.expected.data()[i]);
  }
  return seen;
}

// Labels of the colour image; 255 where nothing is known.
GreyImage labels_of(const Image<std::uint32_t>& source, const Comparison& comparison) {
  GreyImage labels{source.width(), source.height()};
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const std::uint32_t from = source.data()[i];
    labels.data()[i] = from == 0 ? 255 : static_cast<std::uint8_t>(comparison.labels.data()[from - 1]);
  }
  return labels;
}

bool is_near_outline(const GreyImage& labels, int x, int y, int reach) {
  for (int v = std::max(0, y - reach); v <= std::min(labels.height() - 1, y + reach); ++v) {
    for (int u = std::max(0, x - reach); u <= std::min(labels.width() - 1, x + reach); ++u) {
      if (labels(u, v) != labels(x, y)) return true;
    }
  }
  return false;
}

class CarryOfSizes : public testing::TestWithParam<Sizes> {};

// The squares of the reference face the camera and are a tenth larger than their pixels, so at outlines both differ by
// up to a depth pixel.
TEST_P(CarryOfSizes, AgreesWithTheReferenceAwayFromOutlines) {
  const Rig rig = rig_of(GetParam());
  const Seen seen = look(rig, GetParam().noise);
  auto gpu = GpuContext::create_headless();
  ASSERT_TRUE(gpu) << gpu.error().message;
  auto carrier = show::Carrier::create(**gpu);
  ASSERT_TRUE(carrier) << carrier.error().message;
  const auto source = (*carrier)->carry(seen.comparison, seen.measured, rig);
  ASSERT_TRUE(source) << source.error().message;
  const GreyImage labels = labels_of(*source, seen.comparison);
  const GreyImage reference = labels_of(carry_on_cpu(seen.comparison, seen.measured, rig), seen.comparison);
  const int reach = 1 + static_cast<int>(std::ceil(rig.color.fx / rig.depth.fx));
  std::size_t inside = 0;
  std::size_t equal_inside = 0;
  std::size_t equal = 0;
  for (int y = 0; y < labels.height(); ++y) {
    for (int x = 0; x < labels.width(); ++x) {
      const bool same = labels(x, y) == reference(x, y);
      equal += same ? 1 : 0;
      if (is_near_outline(reference, x, y, reach)) continue;
      ++inside;
      equal_inside += same ? 1 : 0;
    }
  }
  const auto all = static_cast<double>(labels.size());
  const double share_inside = static_cast<double>(inside) / all;
  const double agreement = static_cast<double>(equal_inside) / static_cast<double>(inside);
  std::printf("%s: %.5f of %.3f of the pixels equal, %.4f of all\n", GetParam().name, agreement, share_inside,
              static_cast<double>(equal) / all);
  EXPECT_GE(agreement, 0.999);
  EXPECT_GE(share_inside, 0.6);
  EXPECT_GE(static_cast<double>(equal) / all, 0.97);
}

INSTANTIATE_TEST_SUITE_P(Rigs, CarryOfSizes,
                         testing::Values(Sizes{"exact", 640, 480, 640, 480, 0.025, 0},
                                         Sizes{"kinect", 640, 480, 640, 480, 0.025, 1},
                                         Sizes{"coarse_depth", 176, 144, 1280, 720, 0.05, 0},
                                         Sizes{"coarse_color", 640, 480, 320, 240, 0.025, 1},
                                         Sizes{"far_apart", 320, 240, 640, 480, 0.12, 1}),
                         [](const auto& sizes) { return std::string{sizes.param.name}; });

}  // namespace
}  // namespace meshloop
