#version 310 es
// One triangle that covers the picture.
precision highp float;

#define PARAMETER flat out highp
#include "shaders/compare_parameters.glsl"

layout(location = 0) uniform highp vec4 parameters[15];

void main() {
  vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);
  gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
  intrinsics = parameters[0];
  sensor_axial = parameters[1];
  sensor_shape = parameters[2];
  sensor_lateral = parameters[3];
  threshold_by = parameters[4];
  variance_v = parameters[5].xyz;
  covariance_vv = parameters[6].xyz;
  variance_w = parameters[7].xyz;
  covariance_ww = parameters[8].xyz;
  covariance_v_wx = parameters[9].xyz;
  covariance_v_wy = parameters[10].xyz;
  covariance_v_wz = parameters[11].xyz;
  variance_intrinsics = parameters[12];
  covariance_fx = parameters[13].xyz;
  covariance_fy = parameters[14].xyz;
}
