// Shared by the AR shaders: the light, and how much of it reaches a point past what is in a shadow map. A shadow grows
// softer with the distance from what casts it (Fernando 2005, "Percentage-Closer Soft Shadows").

layout(location = 20) uniform mat4 shadow_from_world;  // texture coordinates and depth, all 0 to 1
layout(location = 21) uniform mat3 light_axes;         // world directions of the map's x, y and depth, as columns
layout(location = 22) uniform vec2 shadow_extent_m;    // side of the map, range of its depth

const float kSun = 0.85;
const float kAmbient = 0.5;
// Half the light's angle as seen from the scene, as a tangent: a lamp of the size of a hand a few metres away.
const float kLightTangent = 0.06;
const float kFarthestCaster_m = 0.25;
const int kSearchTaps = 12;
const int kFilterTaps = 28;
const float kGoldenAngle = 2.39996323;

vec2 disc_tap(int i, int count) {
  float radius = sqrt((float(i) + 0.5) / float(count));
  float angle = float(i) * kGoldenAngle;
  return radius * vec2(cos(angle), sin(angle));
}

// How the depth of a plane with this normal changes along the map's axes, in units of the map.
vec2 plane_slope(vec3 normal) {
  vec3 n = transpose(light_axes) * normal;
  float facing = max(abs(n.z), 0.25) * (n.z < 0.0 ? -1.0 : 1.0);
  return -n.xy / facing * (shadow_extent_m.x / shadow_extent_m.y);
}

float light_share(highp sampler2D map, vec3 p_world, vec3 normal, float bias_m) {
  vec3 p = (shadow_from_world * vec4(p_world, 1.0)).xyz;
  if (any(lessThan(p, vec3(0.0))) || any(greaterThan(p, vec3(1.0)))) return 1.0;
  vec2 slope = plane_slope(normal);
  float bias = bias_m / shadow_extent_m.y;
  float texel = 1.0 / float(textureSize(map, 0).x);

  float search = kLightTangent * kFarthestCaster_m / shadow_extent_m.x;
  float casters = 0.0;
  float caster_depth = 0.0;
  for (int i = 0; i < kSearchTaps; ++i) {
    vec2 tap = disc_tap(i, kSearchTaps) * search;
    float depth = textureLod(map, p.xy + tap, 0.0).r;
    if (depth < p.z + dot(slope, tap) - bias) {
      casters += 1.0;
      caster_depth += depth;
    }
  }
  if (casters < 0.5) return 1.0;

  float above_m = (p.z - caster_depth / casters) * shadow_extent_m.y;
  float radius = clamp(kLightTangent * above_m / shadow_extent_m.x, 1.5 * texel, search);
  float lit = 0.0;
  for (int i = 0; i < kFilterTaps; ++i) {
    vec2 tap = disc_tap(i, kFilterTaps) * radius;
    lit += textureLod(map, p.xy + tap, 0.0).r < p.z + dot(slope, tap) - bias ? 0.0 : 1.0;
  }
  return lit / float(kFilterTaps);
}

vec3 linear_from_srgb(vec3 c) { return pow(c, vec3(2.2)); }
vec3 srgb_from_linear(vec3 c) { return pow(c, vec3(1.0 / 2.2)); }
