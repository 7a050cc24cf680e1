#pragma once
// What the comparison's shaders need to know apart from the images.
#include <array>

#include "server/compare/comparator.h"

namespace meshloop {

/// As in shaders/compare_parameters.glsl, where the members are described: one vec4 after the other.
struct Parameters {
  using Vec4 = std::array<float, 4>;
  Vec4 intrinsics{};
  Vec4 sensor_axial{};
  Vec4 sensor_shape{};
  Vec4 sensor_lateral{};
  Vec4 threshold_by{};
  Vec4 variance_v{};
  Vec4 covariance_vv{};
  Vec4 variance_w{};
  Vec4 covariance_ww{};
  std::array<Vec4, 3> covariance_v_w{};
  Vec4 variance_intrinsics{};
  Vec4 covariance_fx{};
  Vec4 covariance_fy{};
};
// OpenGL ES 3.1 promises no more between vertex and fragment shader.
static_assert(sizeof(Parameters) == 15 * sizeof(Parameters::Vec4));

[[nodiscard]] Parameters parameters_of(const CompareInput& input);

}  // namespace meshloop
