// Levels of detail against every triangle: the same labels, and deviations as promised.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "common/gpu/mesh_cache.h"
#include "common/gpu/scene_renderer.h"
#include "kinect_camera.h"
#include "server/compare/comparator.h"
#include "server/compare/region_tracker.h"

namespace meshloop {
namespace {

/// Hills of half a metre and bumps of some millimetres, 1.4 to 2.6 m away, in four nodes of 64,800 triangles.
Model landscape() {
  constexpr std::uint32_t kCells = 180;
  Model model;
  for (int tile = 0; tile < 4; ++tile) {
    Submesh submesh;
    for (std::uint32_t i = 0; i <= kCells; ++i) {
      for (std::uint32_t j = 0; j <= kCells; ++j) {
        const float x = 1.5F * (static_cast<float>(j) / kCells - static_cast<float>(tile % 2));
        const float y = 1.2F * (static_cast<float>(i) / kCells - static_cast<float>(tile / 2));
        const float bumps = 0.004F * std::sin(40 * x) * std::sin(33 * y);
        submesh.positions.emplace_back(x, y, 2 + 0.5F * std::sin(5 * x) * std::cos(4 * y) + bumps);
      }
    }
    for (std::uint32_t i = 0; i < kCells; ++i) {
      for (std::uint32_t j = 0; j < kCells; ++j) {
        const std::uint32_t here = i * (kCells + 1) + j;
        submesh.triangles.push_back({here, here + kCells + 1, here + 1});
        submesh.triangles.push_back({here + 1, here + kCells + 1, here + kCells + 2});
      }
    }
    model.nodes.push_back(make_node(static_cast<NodeId>(tile + 1), "tile", std::move(submesh)));
  }
  return model;
}

class DetailTest : public testing::Test {
 protected:
  void SetUp() override {
    auto gpu = GpuContext::create_headless();
    ASSERT_TRUE(gpu) << gpu.error().message;
    gpu_ = std::move(*gpu);
    comparator_ = std::move(Comparator::create(*gpu_).value());
    renderer_ = std::move(SceneRenderer::create(*gpu_).value());
    input_.model = &model_;
    input_.camera = test::kinect_camera();
    input_.pose.state = TrackState::tracking;
    input_.pose.covariance = 1e-8 * PoseCovariance::Identity();
    input_.wait_for_detail = true;
  }

  DepthImage depth(const Tolerance& tolerance) {
    SceneView view;
    view.camera = test::kinect_camera();
    view.tolerance = tolerance;
    gpu_->meshes().finish(model_);
    renderer_->render(model_, view);
    return renderer_->read_depth();
  }

  Model model_ = landscape();
  std::unique_ptr<GpuContext> gpu_;
  std::unique_ptr<SceneRenderer> renderer_;
  std::unique_ptr<Comparator> comparator_;
  CompareInput input_;
};

TEST_F(DetailTest, LabelsAreThoseOfEveryTriangle) {
  // A Kinect's noise, and a change of 3 sigma in half of the picture, where labels are most easily lost.
  DepthImage measured = depth(Tolerance{});
  std::mt19937 random{7};
  std::normal_distribution<float> noise;
  for (int v = 0; v < measured.height(); ++v) {
    for (int u = 0; u < measured.width(); ++u) {
      float& z = measured(u, v);
      const auto sigma_m = static_cast<float>(input_.sensor.sigma_z_m(static_cast<double>(z), 0));
      z += sigma_m * (noise(random) - (u < measured.width() / 2 ? 3.0F : 0.0F));
    }
  }
  input_.measured = &measured;
  input_.detail_share = 0;
  const auto exact = comparator_->compare(input_, nullptr);
  input_.detail_share = kDetailShare;
  const auto detail = comparator_->compare(input_, nullptr);
  ASSERT_TRUE(exact && detail);
  std::size_t same = 0;
  std::size_t same_where_unchanged = 0;
  for (int v = 0; v < measured.height(); ++v) {
    for (int u = 0; u < measured.width(); ++u) {
      const bool equal = exact->labels(u, v) == detail->labels(u, v);
      same += equal ? 1 : 0;
      same_where_unchanged += equal && u >= measured.width() / 2 ? 1 : 0;
    }
  }
  EXPECT_GE(static_cast<double>(same_where_unchanged), 0.999 * static_cast<double>(measured.size() / 2));
  // Every pixel of the other half lies on the edge of the decision.
  EXPECT_GE(static_cast<double>(same), 0.96 * static_cast<double>(measured.size()));
}

TEST_F(DetailTest, NoDeviationBecomesARegion) {
  const DepthImage exact = depth(Tolerance{});
  std::mt19937 random{3};
  std::normal_distribution<float> noise;
  RegionTracker tracker{RegionOptions{}};
  for (int i = 0; i < 12; ++i) {
    DepthImage measured = exact;
    for (float& z : measured.pixels()) {
      z += static_cast<float>(input_.sensor.sigma_z_m(static_cast<double>(z), 0)) * noise(random);
    }
    input_.measured = &measured;
    const auto detail = comparator_->compare(input_, nullptr);
    ASSERT_TRUE(detail);
    EXPECT_TRUE(tracker.update(*detail, measured, input_.camera, Pose::Identity()).regions.empty()) << i;
  }
}

TEST_F(DetailTest, DeviationsKeepToTheShareOfSigma) {
  const SensorModel sensor;
  const auto exact = depth(Tolerance{});
  const auto detail = depth(Tolerance{[&](double z_m) { return kDetailShare * sensor.sigma_z_m(z_m, 0); }});
  double squares = 0;
  double largest = 0;
  for (std::size_t i = 0; i < exact.size(); ++i) {
    const auto z_m = static_cast<double>(exact.data()[i]);
    const double in_sigma = (static_cast<double>(detail.data()[i]) - z_m) / sensor.sigma_z_m(z_m, 0);
    squares += in_sigma * in_sigma;
    largest = std::max(largest, std::abs(in_sigma));
  }
  EXPECT_LE(std::sqrt(squares / static_cast<double>(exact.size())), kDetailShare);
  RecordProperty("rms_in_sigma", std::to_string(std::sqrt(squares / static_cast<double>(exact.size()))));
  RecordProperty("largest_in_sigma", std::to_string(largest));
}

TEST_F(DetailTest, WithoutWaitingTheFirstFrameIsExact) {
  const DepthImage measured(640, 480, 1.0F);
  input_.measured = &measured;
  input_.wait_for_detail = false;
  const auto first = comparator_->compare(input_, nullptr);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->expected, depth(Tolerance{}));
}

}  // namespace
}  // namespace meshloop
