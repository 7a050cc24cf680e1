#version 310 es
precision highp float;

#include "shaders/ar_light.glsl"

in vec3 p_world;
in vec3 normal_world;
in vec3 albedo;
in float z_camera;

layout(location = 3) uniform vec3 camera_world;
layout(binding = 0) uniform highp sampler2D real_depth;
layout(binding = 1) uniform highp sampler2D object_shadow;
layout(binding = 2) uniform highp sampler2D model_shadow;

out vec4 covered;

// Half the width of the transition where an object dips into a real surface.
const float kSoft_m = 0.0015;
const float kObjectBias_m = 0.0015;
const float kModelBias_m = 0.006;
const vec3 kSky = vec3(0.96, 1.0, 1.06);
const vec3 kGround = vec3(0.62, 0.57, 0.52);
const float kRoughness = 0.45;

// Share of the pixel's surroundings in which nothing real is in front. The object's depth is carried on along its own
// slope, so that a slanted face is not hidden by the surface it stands on.
float visible_share() {
  vec2 slope = clamp(vec2(dFdx(z_camera), dFdy(z_camera)), vec2(-0.01), vec2(0.01));
  ivec2 here = ivec2(gl_FragCoord.xy);
  ivec2 last = textureSize(real_depth, 0) - 1;
  float share = 0.0;
  for (int dy = -1; dy <= 1; ++dy) {
    for (int dx = -1; dx <= 1; ++dx) {
      float weight = float((2 - abs(dx)) * (2 - abs(dy))) / 16.0;
      float real = texelFetch(real_depth, clamp(here + ivec2(dx, dy), ivec2(0), last), 0).r;
      float object = z_camera + dot(slope, vec2(dx, dy));
      share += weight * (real <= 0.0 ? 1.0 : smoothstep(-kSoft_m, kSoft_m, real - object));
    }
  }
  return share;
}

// Trowbridge-Reitz lobe with Schlick's Fresnel term for a dielectric; shape only, no energy bookkeeping.
float highlight(vec3 n, vec3 to_light, vec3 to_eye) {
  vec3 half_way = normalize(to_light + to_eye);
  float a2 = kRoughness * kRoughness * kRoughness * kRoughness;
  float nh = max(dot(n, half_way), 0.0);
  float d = nh * nh * (a2 - 1.0) + 1.0;
  float fresnel = 0.04 + 0.96 * pow(1.0 - max(dot(half_way, to_eye), 0.0), 5.0);
  return 0.25 * fresnel * a2 / (d * d);
}

void main() {
  vec3 to_eye = normalize(camera_world - p_world);
  vec3 n = normalize(normal_world);
  if (dot(n, to_eye) < -0.2) n = -n;
  vec3 to_light = -light_axes[2];
  float facing = dot(n, to_light);
  float lit = max(facing, 0.0);
  lit *= near_light_share(object_shadow, p_world, n, kObjectBias_m);
  lit *= near_light_share(model_shadow, p_world, n, kModelBias_m);
  vec3 base = linear_from_srgb(albedo);
  vec3 light = kAmbient * mix(kGround, kSky, 0.5 + 0.5 * n.z) + kSun * lit;
  vec3 shine = vec3(lit > 0.0 ? highlight(n, to_light, to_eye) * lit : 0.0);
  float share = visible_share();
  covered = vec4(srgb_from_linear(clamp(base * light + shine, 0.0, 1.0)) * share, share);
}
