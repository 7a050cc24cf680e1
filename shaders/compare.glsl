// Thresholds: what both passes of the comparison share. The formulas are derived in server/compare/README.md. Without
// EVERY_TERM the intrinsics are exact and one frame was measured: a software renderer pays for terms that are zero.
const float kHalfPi = 1.57079632679;
const float kSensorLimit = 1.39626340160;      // 80 degrees: beyond, the sensor's noise is not known to grow
const float kCosSteepest = 0.03489949670;      // 88 degrees
const float kGrazing = 1.04719755120;  // 60 degrees

layout(r32f, binding = 0) readonly uniform highp image2D measured_image;
layout(r32f, binding = 1) readonly uniform highp image2D expected_image;
layout(r32f, binding = 2) readonly uniform highp image2D frames_image;  // of how many each pixel is the mean

float fixed_threshold_m() { return threshold_by.x; }
float sigmas() { return threshold_by.y; }

// 0 outside the picture, as for any load that is not of a texel.
float expected_at(ivec2 pixel) { return imageLoad(expected_image, pixel).r; }

// Change of inverse depth from one pixel to the next: the flatter side, so that a depth edge is not taken for a slope.
float slope(ivec2 pixel, ivec2 one, float inverse_depth) {
  float before_m = expected_at(pixel - one);
  float after_m = expected_at(pixel + one);
  float backward = before_m > 0.0 ? inverse_depth - 1.0 / before_m : 0.0;
  float forward = after_m > 0.0 ? 1.0 / after_m - inverse_depth : 0.0;
  if (before_m == 0.0) return forward;
  if (after_m == 0.0) return backward;
  return abs(forward) < abs(backward) ? forward : backward;
}

// N of the plane N . p = 1 through the expected surface, in the camera's frame.
vec3 plane_of(ivec2 pixel, vec3 ray, float expected_m) {
  float inverse_depth = 1.0 / expected_m;
  float x = intrinsics.x * slope(pixel, ivec2(1, 0), inverse_depth);
  float y = intrinsics.y * slope(pixel, ivec2(0, 1), inverse_depth);
  return vec3(x, y, inverse_depth - ray.x * x - ray.y * y);
}

// Variance of a . (v + w x p) for the pose's twist (v, w).
float pose_variance(vec3 a, vec3 p) {
  vec3 b = cross(p, a);
  vec3 of_w = covariance_v_wx * b.x + covariance_v_wy * b.y + covariance_v_wz * b.z;
  float own = dot(variance_v, a * a) + dot(variance_w, b * b);
  float crossed = dot(covariance_vv, a.yzx * a.zxy) + dot(covariance_ww, b.yzx * b.zxy) + dot(a, of_w);
  return max(0.0, own + 2.0 * crossed);
}

// acos for 0 to 1 (Abramowitz and Stegun, 4.4.46; within 2e-8 rad): atan takes many times as long.
float angle_of(float x) {
  float series = 0.0066700901 - 0.0012624911 * x;
  series = -0.0170881256 + series * x;
  series = 0.0308918810 + series * x;
  series = -0.0501743046 + series * x;
  series = 0.0889789874 + series * x;
  series = -0.2145988016 + series * x;
  return sqrt(max(0.0, 1.0 - x)) * (1.5707963050 + series * x);
}

float grazing_ratio(float theta) {
  float t = min(theta, kSensorLimit);
  return t / (kHalfPi - t);
}

// Of the mean of some frames: the share of the quantisation stays.
float sensor_variance(float z_m, float theta, float frames) {
  float z = clamp(z_m, sensor_shape.x, sensor_shape.y);
  float beyond = max(1.0, z_m / sensor_shape.y);
  float sigma_m = (sensor_axial.x + z * (sensor_axial.y + z * sensor_axial.z)) * beyond * beyond;
  if (sensor_shape.z > 0.0 && theta > kGrazing) {
    float ratio = grazing_ratio(theta);
    sigma_m += 0.0001 / sqrt(max(z_m, 0.1)) * ratio * ratio;
  }
  float step_m = sensor_shape.w * z_m * z_m;
  float lasting = min(step_m * step_m / 12.0, sigma_m * sigma_m);
  return (sigma_m * sigma_m - lasting) / frames + lasting;
}

float lateral_sigma_px(float theta) {
  return sensor_lateral.x + sensor_lateral.y * grazing_ratio(theta);
}

// Of J d for the error d of the intrinsics (fx, fy, cx, cy).
float intrinsics_variance(vec4 J) {
#ifdef EVERY_TERM
  float crossed = dot(covariance_fx, J.x * J.yzw) + dot(covariance_fy, vec3(J.y * J.z, J.y * J.w, J.z * J.w));
  return max(0.0, dot(variance_intrinsics, J * J) + 2.0 * crossed);
#else
  return 0.0;
#endif
}

// Of how many frames the measurement is the mean.
float frames_at(ivec2 pixel) {
#ifdef EVERY_TERM
  return sensor_axial.w > 0.0 ? max(1.0, imageLoad(frames_image, pixel).r) : 1.0;
#else
  return 1.0;
#endif
}

// How the pixel sees what is expected there; where nothing is, a plane across the ray through what was measured.
struct Sight {
  vec3 ray;
  vec3 p;      // the point, in the camera's frame
  vec3 plane;  // N of N . p = 1
  float z_m;
  float theta;   // between ray and normal
  bool is_seen;  // not too steep to tell anything
  vec2 inverse_depth_slope;  // of the expected surface, from one pixel to the next
};

Sight sight_at(ivec2 pixel, float measured_m, float expected_m) {
  Sight sight;
  sight.ray = vec3((vec2(pixel) - intrinsics.zw) / intrinsics.xy, 1.0);
  bool is_modelled = expected_m > 0.0;
  sight.z_m = is_modelled ? expected_m : measured_m;
  sight.p = sight.z_m * sight.ray;
  sight.plane = is_modelled ? plane_of(pixel, sight.ray, expected_m) : sight.ray / (sight.z_m * dot(sight.ray, sight.ray));
  float cosine = min(1.0, 1.0 / (sight.z_m * sqrt(dot(sight.plane, sight.plane) * dot(sight.ray, sight.ray))));
  sight.is_seen = cosine >= kCosSteepest;
  sight.theta = angle_of(cosine);
  sight.inverse_depth_slope = is_modelled ? sight.plane.xy / intrinsics.xy : vec2(0.0);
  return sight;
}

// kNoThreshold_m where nothing can be told.
float threshold_at(ivec2 pixel, Sight sight, float measured_m, float expected_m) {
  if (fixed_threshold_m() > 0.0) return fixed_threshold_m();
  float z2 = sight.z_m * sight.z_m;
  float lateral_m = lateral_sigma_px(sight.theta) * z2 * length(sight.inverse_depth_slope);
  vec2 by_centre = z2 * sight.plane.xy / intrinsics.xy;  // derivative of the expected depth by cx, cy
  float variance = sensor_variance(max(expected_m, measured_m), sight.theta, frames_at(pixel)) + lateral_m * lateral_m +
                   z2 * pose_variance(sight.plane, sight.p) +
                   intrinsics_variance(vec4(by_centre * sight.ray.xy, by_centre)) + threshold_by.z;
  float threshold_m = sigmas() * sqrt(variance);
  return sight.is_seen && threshold_m <= threshold_by.w ? threshold_m : kNoThreshold_m;
}
