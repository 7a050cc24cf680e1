#include "server/compare/compare_parameters.h"

#include "server/compare/compare_input.h"

namespace meshloop {
namespace {

Parameters::Vec4 vec4(double x, double y, double z, double w = 0) {
  return {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), static_cast<float>(w)};
}

Parameters::Vec4 diagonal(const Eigen::Matrix3d& block) {
  return vec4(block(0, 0), block(1, 1), block(2, 2));
}

Parameters::Vec4 beside_diagonal(const Eigen::Matrix3d& block) {
  return vec4(block(1, 2), block(2, 0), block(0, 1));
}

void set_sensor(Parameters& parameters, const CompareInput& input) {
  const SensorNoise noise = input.sensor.noise();
  const bool is_averaged = input.frames_averaged != nullptr;
  parameters.sensor_axial = vec4(noise.axial[0], noise.axial[1], noise.axial[2], is_averaged ? 1 : 0);
  parameters.sensor_shape = vec4(noise.nearest_m, noise.farthest_m, noise.grows_at_grazing ? 1 : 0, noise.step_per_m);
  parameters.sensor_lateral = vec4(noise.lateral_px, noise.lateral_growth_px, kFootprintSigma_px, kLargestReach_px);
}

void set_pose(Parameters& parameters, const PoseCovariance& given) {
  const PoseCovariance covariance = 0.5 * (given + given.transpose());
  const Eigen::Matrix3d vv = covariance.topLeftCorner<3, 3>();
  const Eigen::Matrix3d ww = covariance.bottomRightCorner<3, 3>();
  parameters.variance_v = diagonal(vv);
  parameters.covariance_vv = beside_diagonal(vv);
  parameters.variance_w = diagonal(ww);
  parameters.covariance_ww = beside_diagonal(ww);
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d column = covariance.block<3, 1>(0, 3 + axis);
    parameters.covariance_v_w[static_cast<std::size_t>(axis)] = vec4(column.x(), column.y(), column.z());
  }
}

void set_intrinsics(Parameters& parameters, const CompareInput& input) {
  const Camera& camera = input.camera;
  parameters.intrinsics = vec4(camera.fx, camera.fy, camera.cx, camera.cy);
  const Eigen::Matrix4d& c = input.intrinsics_covariance;
  parameters.variance_intrinsics = vec4(c(0, 0), c(1, 1), c(2, 2), c(3, 3));
  parameters.covariance_fx = vec4(c(0, 1), c(0, 2), c(0, 3));
  parameters.covariance_fy = vec4(c(1, 2), c(1, 3), c(2, 3));
}

}  // namespace

Parameters parameters_of(const CompareInput& input) {
  Parameters parameters;
  set_intrinsics(parameters, input);
  set_sensor(parameters, input);
  set_pose(parameters, input.pose.covariance);
  const bool is_fixed = input.threshold.kind == Threshold::Kind::fixed;
  const double model_variance_m2 = input.model_sigma_m * input.model_sigma_m + kLatticeSigma_m * kLatticeSigma_m;
  parameters.threshold_by =
      vec4(is_fixed ? input.threshold.value : 0, input.threshold.value, model_variance_m2, kLargestThreshold_m);
  return parameters;
}

}  // namespace meshloop
