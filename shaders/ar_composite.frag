#version 310 es
precision highp float;

#include "shaders/ar_light.glsl"

layout(location = 0) uniform mat4 world_from_camera;
layout(location = 1) uniform vec4 intrinsics;  // fx, fy, cx, cy
layout(binding = 0) uniform highp sampler2D real_depth;
layout(binding = 1) uniform highp sampler2D object_shadow;
layout(binding = 2) uniform highp sampler2D model_shadow;
layout(binding = 3) uniform highp sampler2D camera_picture;
layout(binding = 4) uniform highp sampler2D objects;

out vec4 picture;

const float kObjectBias_m = 0.002;
// Where the model itself keeps the light away the picture is dark already. Measured surfaces are rough.
const float kModelBias_m = 0.012;
// A surface that the light touches at a flatter angle has no shadow worth looking for.
const float kGrazing = 0.02;

vec3 point_at(ivec2 pixel, float depth) {
  return vec3((vec2(pixel) - intrinsics.zw) / intrinsics.xy * depth, depth);
}

// The side on which the depth changes less belongs to the same surface; at the picture's border there is one side only.
vec3 step_along(ivec2 pixel, ivec2 direction, vec3 here) {
  ivec2 last = textureSize(real_depth, 0) - 1;
  ivec2 after = min(pixel + direction, last);
  ivec2 before = max(pixel - direction, ivec2(0));
  float depth_after = texelFetch(real_depth, after, 0).r;
  float depth_before = texelFetch(real_depth, before, 0).r;
  bool at_end = after == pixel;
  bool at_start = before == pixel;
  if (at_start || (!at_end && abs(depth_after - here.z) < abs(depth_before - here.z))) return point_at(after, depth_after) - here;
  return here - point_at(before, depth_before);
}

// Share of the light that the objects take away from the real surface at this pixel.
float darkness(ivec2 pixel, bool wanted) {
  float depth = texelFetch(real_depth, pixel, 0).r;
  vec3 here = point_at(pixel, depth);
  vec3 p_world = (world_from_camera * vec4(here, 1.0)).xyz;
  vec3 normal = cross(step_along(pixel, ivec2(1, 0), here), step_along(pixel, ivec2(0, 1), here));
  bool known = wanted && depth > 0.0 && dot(normal, normal) >= 1e-20;
  normal = known ? normalize(mat3(world_from_camera) * normal) : light_axes[2];
  if (dot(normal, p_world - world_from_camera[3].xyz) > 0.0) normal = -normal;
  float facing = dot(normal, -light_axes[2]);

  float taken = 1.0 - light_share(object_shadow, p_world, normal, kObjectBias_m, known && facing > kGrazing);
  taken *= light_share(model_shadow, p_world, normal, kModelBias_m, taken > 0.0);
  return taken * kSun * facing / (kSun * facing + kAmbient);
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec3 seen = texelFetch(camera_picture, pixel, 0).rgb;
  vec4 object = texelFetch(objects, pixel, 0);
  float dark = darkness(pixel, object.a < 1.0);
  if (dark > 0.0) seen = srgb_from_linear(linear_from_srgb(seen) * (1.0 - dark));
  picture = vec4(object.rgb + (1.0 - object.a) * seen, 1.0);
}
