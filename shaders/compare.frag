#version 310 es
// Measured against expected depth, one pixel. The formulas are derived in server/compare/README.md.
precision highp float;
precision highp int;

#include "common/change/classify_rule.h"

const int kKinect1 = 0;
const int kKinect1Khoshelham = 1;
const int kTof = 2;

const float kHalfPi = 1.57079632679;
const float kSensorLimit = 1.39626340160;      // 80 degrees: beyond, the sensor's noise is not known to grow
const float kCosSteepest = 0.03489949670;      // 88 degrees
const float kGrazing = 1.04719755120;  // 60 degrees

layout(binding = 0) uniform highp sampler2D measured_image;
layout(binding = 1) uniform highp sampler2D expected_image;
layout(binding = 2) uniform highp usampler2D node_image;

layout(location = 0) uniform vec4 intrinsics;  // fx, fy, cx, cy
layout(location = 1) uniform int sensor_kind;
layout(location = 2) uniform float sensor_constant_m;
layout(location = 3) uniform float fixed_threshold_m;  // 0: by sigma
layout(location = 4) uniform float sigmas;
layout(location = 5) uniform float model_sigma_m;
layout(location = 6) uniform float largest_threshold_m;
layout(location = 7) uniform int largest_reach_px;
// Blocks of the pose covariance: translation, translation by rotation, rotation.
layout(location = 8) uniform mat3 covariance_tt;
layout(location = 9) uniform mat3 covariance_tr;
layout(location = 10) uniform mat3 covariance_rr;

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

float sensor_variance(float z_m, float theta) {
  if (sensor_kind == kKinect1) {
    float sigma_m = 0.0012 + 0.0019 * (z_m - 0.4) * (z_m - 0.4);
    if (theta > kGrazing) {
      float ratio = grazing_ratio(theta);
      sigma_m += 0.0001 / sqrt(max(z_m, 0.1)) * ratio * ratio;
    }
    float step_m = 2.85e-3 * z_m * z_m;
    return sigma_m * sigma_m + step_m * step_m / 12.0;
  }
  float sigma_m = sensor_constant_m;
  if (sensor_kind == kKinect1Khoshelham) sigma_m = 1.425e-3 * z_m * z_m;
  if (sensor_kind == kTof) sigma_m = 0.01 * z_m;
  return sigma_m * sigma_m;
}

float lateral_variance(float theta) {
  if (sensor_kind != kKinect1) return 0.0;
  float sigma_px = 0.8 + 0.035 * grazing_ratio(theta);
  return sigma_px * sigma_px;
}

struct Uncertainty {
  float threshold_m;
  int reach_px;
};

Uncertainty uncertainty_at(ivec2 pixel, float measured_m, float expected_m) {
  if (fixed_threshold_m > 0.0) return Uncertainty(fixed_threshold_m, 0);
  vec3 ray = vec3((vec2(pixel) - intrinsics.zw) / intrinsics.xy, 1.0);
  bool is_modelled = expected_m > 0.0;
  float z_m = is_modelled ? expected_m : measured_m;
  vec3 p = z_m * ray;
  vec3 plane = is_modelled ? plane_of(pixel, ray, expected_m) : ray / (z_m * dot(ray, ray));
  float cosine = min(1.0, 1.0 / (z_m * length(plane) * length(ray)));
  if (cosine < kCosSteepest) return Uncertainty(kNoThreshold_m, 0);
  float theta = atan(sqrt(1.0 - cosine * cosine), cosine);

  float variance = sensor_variance(max(expected_m, measured_m), theta) + z_m * z_m * pose_variance(plane, p) +
                   model_sigma_m * model_sigma_m;
  float threshold_m = sigmas * sqrt(variance);
  if (threshold_m > largest_threshold_m) return Uncertainty(kNoThreshold_m, 0);

  vec2 pixels_per_metre = intrinsics.xy / z_m;
  float pose_px = max(pixels_per_metre.x * pixels_per_metre.x * pose_variance(vec3(1.0, 0.0, -ray.x), p),
                      pixels_per_metre.y * pixels_per_metre.y * pose_variance(vec3(0.0, 1.0, -ray.y), p));
  float reach_px = floor(sigmas * sqrt(lateral_variance(theta) + pose_px) + 0.5);
  return Uncertainty(threshold_m, min(int(min(reach_px, 1000.0)), largest_reach_px));
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
        if (z_m > 0.0) {
          nearest_m = nearest_m > 0.0 ? min(nearest_m, z_m) : z_m;
          farthest_m = max(farthest_m, z_m);
        } else {
          has_gap = true;
        }
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
  Uncertainty uncertainty = Uncertainty(kNoThreshold_m, 0);
  if (measured_m > 0.0) uncertainty = uncertainty_at(pixel, measured_m, expected_m);
  uint label = label_at(pixel, measured_m, expected_m, uncertainty);
  result = uvec4(floatBitsToUint(expected_m), node, floatBitsToUint(uncertainty.threshold_m), label);
}
