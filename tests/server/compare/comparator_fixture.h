#pragma once
// A comparator on the GPU, the room of compare_scene.h, and the same comparison on the CPU.
#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "compare_scene.h"
#include "server/compare/comparator.h"

namespace meshloop::compare_test {

class ComparatorTest : public testing::Test {
 protected:
  void SetUp() override {
    auto context = GpuContext::create_headless();
    ASSERT_TRUE(context) << context.error().message;
    context_ = std::move(*context);
    auto comparator = Comparator::create(*context_);
    ASSERT_TRUE(comparator) << comparator.error().message;
    comparator_ = std::move(*comparator);
    input_.model = &model_;
    input_.camera = camera_of(320, 240);
    input_.pose = room_pose();
    input_.measured = &measured_;
  }
  void look_at(const Model& real, unsigned seed) {
    measured_ = measure(render_depth(real, input_.camera, input_.pose.T_camera_world), input_.sensor, seed);
  }
  Comparison on_cpu() const {
    DepthImage depth;
    Image<std::uint32_t> nodes;
    render_on_cpu(model_, input_.camera, input_.pose.T_camera_world, depth, nodes);
    return compare_on_cpu(input_, depth, nodes);
  }
  Comparison on_gpu() {
    auto result = comparator_->compare(input_, nullptr);
    EXPECT_TRUE(result) << (result ? "" : result.error().message);
    return result ? std::move(*result) : Comparison{};
  }

  std::unique_ptr<GpuContext> context_;
  std::unique_ptr<Comparator> comparator_;
  Model model_ = room_model();
  DepthImage measured_;
  CompareInput input_;
};

}  // namespace meshloop::compare_test
