#version 310 es
// First pass of the comparison, every pixel: thresholds, and the labels that need no look at the surroundings.
precision highp float;
precision highp int;

#include "common/change/classify_rule.h"
#define PARAMETER flat in
#include "shaders/compare_parameters.glsl"
#include "shaders/compare.glsl"

layout(location = 0) out float out_threshold_m;
layout(location = 1) out uint out_label;

// Depth for the pixels that do need it, and for the others: the second pass is drawn between the two. A software
// rasteriser runs both sides of an `if` for every pixel, but leaves out what the depth test refuses.
const float kToBeContinued = 0.25;
const float kDone = 0.75;
const float kInfinity = uintBitsToFloat(0x7f800000u);

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  float measured_m = imageLoad(measured_image, pixel).r;
  float expected_m = imageLoad(expected_image, pixel).r;
  bool is_measured = measured_m > 0.0;
  float threshold_m = threshold_at(pixel, sight_at(pixel, measured_m, expected_m), measured_m, expected_m);
  if (!is_measured) threshold_m = kNoThreshold_m;
  bool is_done = fixed_threshold_m() > 0.0 || !needs_neighbourhood(measured_m, expected_m, threshold_m);
  uint label = classify(measured_m, expected_m, threshold_m, expected_m, expected_m, !(expected_m > 0.0));
  gl_FragDepth = is_done ? kDone : kToBeContinued;
  out_threshold_m = threshold_m < kNoThreshold_m ? threshold_m : kInfinity;
  out_label = label;
}
