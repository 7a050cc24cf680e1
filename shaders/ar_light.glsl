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
const float kNearSoft_m = 0.004;
const int kNearTaps = 8;
// Taps lie on a sunflower's spiral: each is turned from the last by the golden angle.
const vec2 kFirstDirection = vec2(1.0, 0.0);
const mat2 kGoldenTurn = mat2(-0.7373688, 0.6754903, -0.6754903, -0.7373688);

float spiral_radius(int i, int count) { return sqrt((float(i) + 0.5) / float(count)); }

// How the depth of a plane with this normal changes along the map's axes, in units of the map.
vec2 plane_slope(vec3 normal) {
  vec3 n = transpose(light_axes) * normal;
  float facing = max(abs(n.z), 0.25) * (n.z < 0.0 ? -1.0 : 1.0);
  return -n.xy / facing * (shadow_extent_m.x / shadow_extent_m.y);
}

// 1 where `wanted` is false. The loops' bounds are variables for a reason: a software rasteriser runs both sides of an
// `if` for every pixel, and a loop of fixed length whether its result is wanted or not; a loop of length 0 it skips.
float light_share(highp sampler2D map, vec3 p_world, vec3 normal, float bias_m, bool wanted) {
  vec3 p = (shadow_from_world * vec4(p_world, 1.0)).xyz;
  bool inside = all(greaterThanEqual(p, vec3(0.0))) && all(lessThanEqual(p, vec3(1.0)));
  vec2 slope = plane_slope(normal);
  float bias = bias_m / shadow_extent_m.y;
  float texel = 1.0 / float(textureSize(map, 0).x);

  float search = kLightTangent * kFarthestCaster_m / shadow_extent_m.x;
  int search_taps = wanted && inside ? kSearchTaps : 0;
  int casters = 0;
  float caster_depth = 0.0;
  vec2 direction = kFirstDirection;
  for (int i = 0; i < search_taps; ++i) {
    vec2 tap = direction * (spiral_radius(i, kSearchTaps) * search);
    direction = kGoldenTurn * direction;
    float depth = textureLod(map, p.xy + tap, 0.0).r;
    if (depth < p.z + dot(slope, tap) - bias) {
      ++casters;
      caster_depth += depth;
    }
  }
  float above_m = (p.z - caster_depth / float(max(casters, 1))) * shadow_extent_m.y;
  float radius = clamp(kLightTangent * above_m / shadow_extent_m.x, 1.5 * texel, search);

  // Within the search's circle: all of it dark, or all of it lit, needs no closer look.
  int filter_taps = casters > 0 && casters < kSearchTaps ? kFilterTaps : 0;
  int lit = 0;
  direction = kFirstDirection;
  for (int i = 0; i < filter_taps; ++i) {
    vec2 tap = direction * (spiral_radius(i, kFilterTaps) * radius);
    direction = kGoldenTurn * direction;
    lit += textureLod(map, p.xy + tap, 0.0).r < p.z + dot(slope, tap) - bias ? 0 : 1;
  }
  if (filter_taps > 0) return float(lit) / float(kFilterTaps);
  return casters > 0 ? 0.0 : 1.0;
}

// A cheaper one for the objects' own faces: of one softness, whose few taps are always taken.
float near_light_share(highp sampler2D map, vec3 p_world, vec3 normal, float bias_m) {
  vec3 p = (shadow_from_world * vec4(p_world, 1.0)).xyz;
  vec2 slope = plane_slope(normal);
  float bias = bias_m / shadow_extent_m.y;
  float radius = max(kNearSoft_m / shadow_extent_m.x, 1.5 / float(textureSize(map, 0).x));
  float lit = 0.0;
  vec2 direction = kFirstDirection;
  for (int i = 0; i < kNearTaps; ++i) {
    vec2 tap = direction * (spiral_radius(i, kNearTaps) * radius);
    direction = kGoldenTurn * direction;
    lit += textureLod(map, p.xy + tap, 0.0).r < p.z + dot(slope, tap) - bias ? 0.0 : 1.0;
  }
  return lit / float(kNearTaps);
}

vec3 linear_from_srgb(vec3 c) { return pow(c, vec3(2.2)); }
vec3 srgb_from_linear(vec3 c) { return pow(c, vec3(1.0 / 2.2)); }
