#pragma once
// Measured against expected depth (analysis by synthesis).
#include <memory>

#include "common/base/result.h"
#include "common/change/comparison.h"
#include "common/geometry/rig.h"
#include "common/geometry/tracked_pose.h"
#include "common/gpu/context.h"
#include "common/image/image.h"
#include "common/mesh/model.h"

namespace meshloop {

/// One fifth of sigma more, uncorrelated, widens it by 2 %.
inline constexpr double kDetailShare = 0.2;

struct CompareInput {
  const Model* model = nullptr;
  /// Pinhole intrinsics of the depth camera.
  Camera camera;
  SensorModel sensor;
  /// Of (fx, fy, cx, cy), in pixels^2.
  Eigen::Matrix4d intrinsics_covariance = Eigen::Matrix4d::Zero();
  /// T_depth_world with its covariance.
  TrackedPose pose;
  /// Measured depth in metres, 0 where there is none, in the camera's size.
  const DepthImage* measured = nullptr;
  /// Of how many measurements each pixel of `measured` is the mean; null: of one. In the camera's size.
  const Image<std::uint8_t>* frames_averaged = nullptr;
  /// How far the model may be from the real surface, one sigma, in metres; its finest lattice comes on top.
  double model_sigma_m = 0;
  Threshold threshold;
  /// The drawn model may lie beside the true one by this share of the sensor's sigma at the depth, as root mean square
  /// (README.md, "Levels of detail"). 0, or a mean of frames as measurement: every triangle is drawn.
  double detail_share = kDetailShare;
  /// Levels of detail come from another thread; until they are there a node is drawn exactly. True: wait for them, so
  /// that the result does not depend on that thread.
  bool wait_for_detail = false;
};

struct CompareTimes {
  double upload_ms = 0;
  double render_ms = 0;
  double compare_ms = 0;
  double readback_ms = 0;
};

/// On the GPU. One thread, that of the context.
class Comparator {
 public:
  [[nodiscard]] static Result<std::unique_ptr<Comparator>> create(GpuContext& context);
  virtual ~Comparator() = default;
  /// Refuses images of another size than the camera's, a pose that is lost or not rigid, and uncertainties that are not
  /// numbers.
  [[nodiscard]] virtual Result<Comparison> compare(const CompareInput& input, CompareTimes* times) = 0;
};

/// The same on the CPU: given the expected depth, the contract of the shader. Reference for tests.
[[nodiscard]] Comparison compare_on_cpu(const CompareInput& input, const DepthImage& expected,
                                        const Image<std::uint32_t>& node_index);
/// Renders the model's depth and node images on the CPU, pixel by pixel (slow; reference for tests).
void render_on_cpu(const Model& model, const Camera& camera, const Pose& T_camera_world, DepthImage& depth,
                   Image<std::uint32_t>& node_index);

}  // namespace meshloop
