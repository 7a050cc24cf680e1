#include "server/compare/compare_input.h"

#include <fmt/format.h>

#include <cmath>

namespace meshloop {

Status validate(const CompareInput& input) {
  if (input.model == nullptr || input.measured == nullptr) return fail("a comparison needs a model and a depth image");
  if (auto camera = validate(input.camera); !camera) return fail("the depth camera", camera.error());
  const DepthImage& measured = *input.measured;
  if (measured.width() != input.camera.width || measured.height() != input.camera.height) {
    return fail(
        fmt::format("the depth image has {}x{} pixels, but its camera {}x{}; use the rig.yaml of this recording",
                    measured.width(), measured.height(), input.camera.width, input.camera.height));
  }
  if (input.pose.state == TrackState::lost)
    return fail("the pose of this frame is lost; compare a frame that is tracked");
  if (!is_rigid(input.pose.T_camera_world)) return fail("the pose of this frame is not a rotation and a translation");
  if (!input.pose.covariance.allFinite()) return fail("the covariance of the pose holds values that are not numbers");
  if (!input.intrinsics_covariance.allFinite()) {
    return fail("the covariance of the depth intrinsics holds values that are not numbers");
  }
  if (!(input.model_sigma_m >= 0 && input.model_sigma_m < 1)) {
    return fail("the model's tolerance must be at least 0 and below 1 m");
  }
  if (input.frames_averaged != nullptr &&
      (input.frames_averaged->width() != measured.width() || input.frames_averaged->height() != measured.height())) {
    return fail("the counts of averaged frames must be as large as the depth image");
  }
  if (!(std::isfinite(input.threshold.value) && input.threshold.value > 0)) {
    return fail("the threshold must be above 0: metres, or multiples of sigma");
  }
  return {};
}

}  // namespace meshloop
