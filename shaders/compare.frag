#version 310 es
// Measured against expected depth, one pixel. The formulas are derived in server/compare/README.md.
precision highp float;
precision highp int;

#include "common/change/classify_rule.h"

const float kHalfPi = 1.57079632679;
const float kSensorLimit = 1.39626340160;      // 80 degrees: beyond, the sensor's noise is not known to grow
const float kCosSteepest = 0.03489949670;      // 88 degrees
const float kGrazing = 1.04719755120;  // 60 degrees

layout(binding = 0) uniform highp sampler2D measured_image;
layout(binding = 1) uniform highp sampler2D expected_image;
layout(binding = 2) uniform highp usampler2D node_image;
layout(binding = 3) uniform highp usampler2D frames_image;

layout(location = 0) uniform vec4 intrinsics;  // fx, fy, cx, cy
// SensorNoise: coefficients of the axial sigma by depth; range (2), grows at grazing views, step; lateral sigma, its
// growth, its least.
layout(location = 1) uniform vec3 sensor_axial;
layout(location = 2) uniform vec4 sensor_shape;
layout(location = 3) uniform vec3 sensor_lateral;
layout(location = 4) uniform float fixed_threshold_m;  // 0: by sigma
layout(location = 5) uniform float sigmas;
layout(location = 6) uniform float model_variance_m2;
layout(location = 7) uniform float largest_threshold_m;
layout(location = 8) uniform int largest_reach_px;
// Blocks of the pose covariance: translation, translation by rotation, rotation.
layout(location = 9) uniform mat3 covariance_tt;
layout(location = 10) uniform mat3 covariance_tr;
layout(location = 11) uniform mat3 covariance_rr;
layout(location = 12) uniform mat4 covariance_intrinsics;  // fx, fy, cx, cy
layout(location = 13) uniform bool is_averaged;

// Bits of expected depth, node, bits of the threshold, label.
layout(location = 0) out uvec4 result;

float expected_at(ivec2 pixel) {
  ivec2 size = textureSize(expected_image, 0);
  if (any(lessThan(pixel, ivec2(0))) || any(greaterThanEqual(pixel, size))) return 0.0;
  return texelFetch(expected_image, pixel, 0).r;
}

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
  return max(0.0, dot(a, covariance_tt * a) + 2.0 * dot(a, covariance_tr * b) + dot(b, covariance_rr * b));
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
  return max(0.0, dot(J, covariance_intrinsics * J));
}

struct Uncertainty {
  float threshold_m;
  int reach_px;
  vec2 inverse_depth_slope;  // of the expected surface, from one pixel to the next
};

const Uncertainty kNothingKnown = Uncertainty(kNoThreshold_m, 0, vec2(0.0));

Uncertainty uncertainty_at(ivec2 pixel, float measured_m, float expected_m) {
  if (fixed_threshold_m > 0.0) return Uncertainty(fixed_threshold_m, 0, vec2(0.0));
  vec3 ray = vec3((vec2(pixel) - intrinsics.zw) / intrinsics.xy, 1.0);
  bool is_modelled = expected_m > 0.0;
  float z_m = is_modelled ? expected_m : measured_m;
  vec3 p = z_m * ray;
  vec3 plane = is_modelled ? plane_of(pixel, ray, expected_m) : ray / (z_m * dot(ray, ray));
  float cosine = min(1.0, 1.0 / (z_m * length(plane) * length(ray)));
  if (cosine < kCosSteepest) return kNothingKnown;
  float theta = atan(sqrt(1.0 - cosine * cosine), cosine);

  float frames = is_averaged ? max(1.0, float(texelFetch(frames_image, pixel, 0).r)) : 1.0;
  vec2 slope = is_modelled ? plane.xy / intrinsics.xy : vec2(0.0);
  float lateral_px = lateral_sigma_px(theta);
  float lateral_m = lateral_px * z_m * z_m * length(slope);
  vec2 by_centre = z_m * z_m * plane.xy / intrinsics.xy;  // derivative of the expected depth by cx, cy
  float variance = sensor_variance(max(expected_m, measured_m), theta, frames) + lateral_m * lateral_m +
                   z_m * z_m * pose_variance(plane, p) +
                   intrinsics_variance(vec4(by_centre * ray.xy, by_centre)) + model_variance_m2;
  float threshold_m = sigmas * sqrt(variance);
  if (threshold_m > largest_threshold_m) return kNothingKnown;

  vec2 pixels_per_metre = intrinsics.xy / z_m;
  vec2 pixel_variance =
      vec2(pixels_per_metre.x * pixels_per_metre.x * pose_variance(vec3(1.0, 0.0, -ray.x), p),
           pixels_per_metre.y * pixels_per_metre.y * pose_variance(vec3(0.0, 1.0, -ray.y), p));
  vec2 calibration_variance = vec2(intrinsics_variance(vec4(ray.x, 0.0, 1.0, 0.0)),
                                   intrinsics_variance(vec4(0.0, ray.y, 0.0, 1.0)));
  float footprint_px = max(lateral_px, sensor_lateral.z);
  float variance_px2 = footprint_px * footprint_px + max(pixel_variance.x, pixel_variance.y) +
                       max(calibration_variance.x, calibration_variance.y);
  float reach_px = floor(sigmas * sqrt(variance_px2) + 0.5);
  return Uncertainty(threshold_m, min(int(min(reach_px, 1000.0)), largest_reach_px), slope);
}

// Whether the surface that is expected at the pixel itself is the one seen at a neighbour, where it has this inverse
// depth.
bool continues(float inverse_depth, float z_m, float threshold_m) {
  return inverse_depth > 0.0 && abs(z_m * inverse_depth - 1.0) <= threshold_m * inverse_depth;
}

uint label_at(ivec2 pixel, float measured_m, float expected_m, Uncertainty uncertainty) {
  float nearest_m = expected_m;
  float farthest_m = expected_m;
  bool has_gap = !(expected_m > 0.0);
  if (needs_neighbourhood(measured_m, expected_m, uncertainty.threshold_m)) {
    ivec2 last = textureSize(expected_image, 0) - 1;
    ivec2 from = max(pixel - uncertainty.reach_px, ivec2(0));
    ivec2 to = min(pixel + uncertainty.reach_px, last);
    for (int v = from.y; v <= to.y; ++v) {
      for (int u = from.x; u <= to.x; ++u) {
        float z_m = texelFetch(expected_image, ivec2(u, v), 0).r;
        if (!(z_m > 0.0)) {
          has_gap = true;
          continue;
        }
        float inverse_depth = 1.0 / expected_m + dot(uncertainty.inverse_depth_slope, vec2(ivec2(u, v) - pixel));
        if (expected_m > 0.0 && continues(inverse_depth, z_m, uncertainty.threshold_m)) continue;
        nearest_m = nearest_m > 0.0 ? min(nearest_m, z_m) : z_m;
        farthest_m = max(farthest_m, z_m);
      }
    }
  }
  return classify(measured_m, expected_m, uncertainty.threshold_m, nearest_m, farthest_m, has_gap);
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  float measured_m = texelFetch(measured_image, pixel, 0).r;
  float expected_m = texelFetch(expected_image, pixel, 0).r;
  uint node = texelFetch(node_image, pixel, 0).r;
  Uncertainty uncertainty = kNothingKnown;
  if (measured_m > 0.0) uncertainty = uncertainty_at(pixel, measured_m, expected_m);
  uint label = label_at(pixel, measured_m, expected_m, uncertainty);
  result = uvec4(floatBitsToUint(expected_m), node, floatBitsToUint(uncertainty.threshold_m), label);
}
