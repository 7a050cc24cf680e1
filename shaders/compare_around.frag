#version 310 es
// Second pass of the comparison, only where a measurement differs: may a surface beside the pixel explain it?
precision highp float;
precision highp int;

#include "common/change/classify_rule.h"
#define PARAMETER flat in
#include "shaders/compare_parameters.glsl"
#include "shaders/compare.glsl"

layout(location = 1) out uint out_label;

// How far to each side, in pixels, a surface may lie that was measured here.
int reach_at(Sight sight) {
  vec2 pixels_per_metre = intrinsics.xy / sight.z_m;
  vec2 pixel_variance = pixels_per_metre * pixels_per_metre *
                        vec2(pose_variance(vec3(1.0, 0.0, -sight.ray.x), sight.p),
                             pose_variance(vec3(0.0, 1.0, -sight.ray.y), sight.p));
  vec2 calibration_variance = vec2(intrinsics_variance(vec4(sight.ray.x, 0.0, 1.0, 0.0)),
                                   intrinsics_variance(vec4(0.0, sight.ray.y, 0.0, 1.0)));
  float footprint_px = max(lateral_sigma_px(sight.theta), sensor_lateral.z);
  float variance_px2 = footprint_px * footprint_px + max(pixel_variance.x, pixel_variance.y) +
                       max(calibration_variance.x, calibration_variance.y);
  float reach_px = floor(sigmas() * sqrt(variance_px2) + 0.5);
  return min(int(min(reach_px, 1000.0)), int(sensor_lateral.w));
}

// Whether the surface that is expected at the pixel itself is the one seen at a neighbour, where it has this inverse
// depth.
bool continues(float inverse_depth, float z_m, float threshold_m) {
  return inverse_depth > 0.0 && abs(z_m * inverse_depth - 1.0) <= threshold_m * inverse_depth;
}

// Without branches: a software renderer pays for each of them at every step.
uint label_at(ivec2 pixel, float measured_m, float expected_m, float threshold_m, int reach_px, vec2 inverse_depth_slope) {
  bool is_modelled = expected_m > 0.0;
  float inverse_depth = is_modelled ? 1.0 / expected_m : 0.0;
  float nearest_m = is_modelled ? expected_m : kNoThreshold_m;
  float farthest_m = expected_m;
  float least_m = expected_m;
  ivec2 from = max(pixel - reach_px, ivec2(0));
  ivec2 to = min(pixel + reach_px, imageSize(expected_image) - 1);
  for (int v = from.y; v <= to.y; ++v) {
    float row = inverse_depth + inverse_depth_slope.y * float(v - pixel.y);
    for (int u = from.x; u <= to.x; ++u) {
      float z_m = imageLoad(expected_image, ivec2(u, v)).r;
      float here = row + inverse_depth_slope.x * float(u - pixel.x);
      bool is_other = z_m > 0.0 && !(is_modelled && continues(here, z_m, threshold_m));
      nearest_m = is_other ? min(nearest_m, z_m) : nearest_m;
      farthest_m = is_other ? max(farthest_m, z_m) : farthest_m;
      least_m = min(least_m, z_m);
    }
  }
  nearest_m = farthest_m > 0.0 ? nearest_m : 0.0;
  return classify(measured_m, expected_m, threshold_m, nearest_m, farthest_m, !(least_m > 0.0));
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  float measured_m = imageLoad(measured_image, pixel).r;
  float expected_m = imageLoad(expected_image, pixel).r;
  Sight sight = sight_at(pixel, measured_m, expected_m);
  float threshold_m = threshold_at(pixel, sight, measured_m, expected_m);
  out_label = label_at(pixel, measured_m, expected_m, threshold_m, reach_at(sight), sight.inverse_depth_slope);
}
