#version 310 es
// One shape as a pinhole camera sees it: each pixel's ray meets the primitives where their equations say. The reference
// is common/implicit/cast_ray.cpp.
precision highp float;
precision highp int;

const int kMaxPrimitives = 64;
const int kMaxSteps = 128;

struct Primitive {
  // A ray's origin and direction, from the camera's frame.
  mat4 from_camera;
  // Sizes, and the kind.
  vec4 size_and_kind;
};

layout(std140, binding = 0) uniform Shape {
  Primitive primitives[kMaxPrimitives];
  ivec4 steps[kMaxSteps / 4];
};
layout(location = 0) uniform int primitive_count;
layout(location = 1) uniform int step_count;
// fx, fy, cx, cy in pixels.
layout(location = 2) uniform vec4 intrinsics;
// Metres along the optical axis.
layout(location = 3) uniform vec2 near_far_m;
layout(location = 4) uniform uint node_index;
layout(location = 5) uniform vec4 color;

layout(location = 0) out float out_depth_m;
layout(location = 1) out uint out_node_index;
layout(location = 2) out mediump vec4 out_color;

const float kNever = 1e30;

// The ray of this pixel, in a primitive's frame; t is the depth in metres.
struct Ray {
  vec3 origin;
  vec3 direction;
};

float torus_distance(vec3 p, vec2 size) {
  return length(vec2(length(p.xy) - size.x, p.z)) - size.y;
}

bool contains(int i, vec3 p) {
  vec3 size = primitives[i].size_and_kind.xyz;
  switch (int(primitives[i].size_and_kind.w)) {
    case 0:
      return dot(p, p) <= size.x * size.x;
    case 1:
      return all(lessThanEqual(abs(p), 0.5 * size));
    case 2:
      return p.z <= 0.0;
    case 3:
      return dot(p.xy, p.xy) <= size.x * size.x && abs(p.z) <= 0.5 * size.y;
    case 4:
      return p.z >= 0.0 && length(p.xy) <= size.x * (1.0 - p.z / size.y);
    default:
      return torus_distance(p, size.xy) <= 0.0;
  }
}

Ray ray_in(int i, vec3 direction) {
  mat4 m = primitives[i].from_camera;
  return Ray(m[3].xyz, mat3(m) * direction);
}

// Roots of a t^2 + 2 b t + c = 0, in order.
vec2 quadratic(float a, float b, float c) {
  float discriminant = b * b - a * c;
  if (discriminant < 0.0 || a == 0.0) return vec2(a == 0.0 ? -0.5 * c / b : kNever, kNever);
  // The sum that loses no digits first.
  float q = -(b + (b < 0.0 ? -1.0 : 1.0) * sqrt(discriminant));
  if (q == 0.0) return vec2(0.0);
  vec2 t = vec2(q / a, c / q);
  return t.x < t.y ? t : t.yx;
}

// Where the ray is nearest to the z axis (or, for `axes` of 1, to the origin): from there distances are small numbers.
float nearest_to_centre(Ray ray, vec3 axes) {
  float speed = dot(ray.direction * axes, ray.direction);
  return speed > 0.0 ? -dot(ray.origin * axes, ray.direction) / speed : 0.0;
}

float disc(Ray ray, float z, float radius) {
  float t = (z - ray.origin.z) / ray.direction.z;
  vec2 p = ray.origin.xy + t * ray.direction.xy;
  return ray.direction.z != 0.0 && dot(p, p) <= radius * radius ? t : kNever;
}

vec4 sphere(Ray ray, float radius) {
  float middle = nearest_to_centre(ray, vec3(1.0));
  vec3 foot = ray.origin + middle * ray.direction;
  float inside = (radius - length(foot)) * (radius + length(foot));
  if (inside < 0.0) return vec4(kNever);
  float half_chord = sqrt(inside) / length(ray.direction);
  return vec4(middle - half_chord, middle + half_chord, kNever, kNever);
}

vec4 box(Ray ray, vec3 half_size) {
  vec3 a = (-half_size - ray.origin) / ray.direction;
  vec3 b = (half_size - ray.origin) / ray.direction;
  for (int axis = 0; axis < 3; ++axis) {
    if (ray.direction[axis] != 0.0) continue;
    if (abs(ray.origin[axis]) > half_size[axis]) return vec4(kNever);
    a[axis] = -kNever;
    b[axis] = kNever;
  }
  vec3 first = min(a, b), last = max(a, b);
  float enter = max(first.x, max(first.y, first.z));
  float leave = min(last.x, min(last.y, last.z));
  return enter <= leave ? vec4(enter, leave, kNever, kNever) : vec4(kNever);
}

vec4 cylinder(Ray ray, float radius, float height) {
  vec4 t = vec4(kNever);
  t.z = disc(ray, 0.5 * height, radius);
  t.w = disc(ray, -0.5 * height, radius);
  float speed = length(ray.direction.xy);
  if (speed == 0.0) return t;
  float middle = nearest_to_centre(ray, vec3(1.0, 1.0, 0.0));
  float foot = length(ray.origin.xy + middle * ray.direction.xy);
  float inside = (radius - foot) * (radius + foot);
  if (inside < 0.0) return t;
  float half_chord = sqrt(inside) / speed;
  for (int i = 0; i < 2; ++i) {
    float side = middle + (i == 0 ? -half_chord : half_chord);
    if (abs(ray.origin.z + side * ray.direction.z) <= 0.5 * height) t[i] = side;
  }
  return t;
}

vec4 cone(Ray ray, float radius, float height) {
  vec4 t = vec4(kNever);
  t.z = disc(ray, 0.0, radius);
  // From the point of the ray that is nearest to the cone's middle.
  float middle = nearest_to_centre(Ray(ray.origin - vec3(0.0, 0.0, 0.5 * height), ray.direction), vec3(1.0));
  vec3 o = ray.origin + middle * ray.direction;
  float k = radius / height, above = o.z - height;
  vec3 d = ray.direction;
  vec2 side = quadratic(dot(d.xy, d.xy) - k * k * d.z * d.z, dot(o.xy, d.xy) - k * k * above * d.z,
                        dot(o.xy, o.xy) - k * k * above * above);
  for (int i = 0; i < 2; ++i) {
    float z = o.z + side[i] * d.z;
    if (abs(side[i]) < kNever && z >= 0.0 && z <= height) t[i] = middle + side[i];
  }
  return t;
}

// Steps as long as the distance to the surface allows; each change of sign is halved as far as floats go.
vec4 torus(Ray ray, vec2 size) {
  const float kSmallestStep_m = 1e-4;
  vec4 roots = vec4(kNever);
  float middle = nearest_to_centre(ray, vec3(1.0));
  vec3 foot = ray.origin + middle * ray.direction;
  float outer = size.x + size.y, speed = length(ray.direction);
  float inside = (outer - length(foot)) * (outer + length(foot));
  if (inside < 0.0) return roots;
  vec3 d = ray.direction / speed;
  float last = sqrt(inside) + kSmallestStep_m;
  float s = -last;
  float here = torus_distance(foot + s * d, size);
  int found = 0;
  for (int i = 0; i < 1000 && s < last && found < 4; ++i) {
    float next = s + max(abs(here), kSmallestStep_m);
    float there = torus_distance(foot + next * d, size);
    if ((here > 0.0) != (there > 0.0)) {
      float low = s, high = next;
      for (int k = 0; k < 24; ++k) {
        float half_way = 0.5 * (low + high);
        if ((torus_distance(foot + half_way * d, size) > 0.0) == (here > 0.0)) low = half_way;
        else high = half_way;
      }
      roots[found++] = middle + 0.5 * (low + high) / speed;
    }
    s = next;
    here = there;
  }
  return roots;
}

vec4 roots_of(int i, Ray ray) {
  vec3 size = primitives[i].size_and_kind.xyz;
  switch (int(primitives[i].size_and_kind.w)) {
    case 0:
      return sphere(ray, size.x);
    case 1:
      return box(ray, 0.5 * size);
    case 2:
      return vec4(ray.direction.z != 0.0 ? -ray.origin.z / ray.direction.z : kNever, vec3(kNever));
    case 3:
      return cylinder(ray, size.x, size.y);
    case 4:
      return cone(ray, size.x, size.y);
    default:
      return torus(ray, size.xy);
  }
}

// True when the formula's value at a point depends on which side of primitive `forced` the point is. The formula is
// computed for both sides at once, each on a stack of bits.
bool is_on_surface(int forced, vec3 p_camera) {
  uint within = 0u, without = 0u;
  for (int i = 0; i < step_count; ++i) {
    int value = steps[i / 4][i % 4];
    if (value >= 0) {
      bool in_it = value != forced && contains(value, (primitives[value].from_camera * vec4(p_camera, 1.0)).xyz);
      within = within << 1 | (in_it || value == forced ? 1u : 0u);
      without = without << 1 | (in_it ? 1u : 0u);
      continue;
    }
    uvec2 first = uvec2(within, without) >> 1, second = uvec2(within, without) & 1u;
    if (value == -1) first |= second;
    if (value == -2) first &= ~1u | second;
    if (value == -3) first &= ~second;
    within = first.x;
    without = first.y;
  }
  return ((within ^ without) & 1u) != 0u;
}

void main() {
  vec2 pixel = gl_FragCoord.xy - 0.5;
  vec3 direction = vec3((pixel - intrinsics.zw) / intrinsics.xy, 1.0);
  // From one crossing to the next, in the order of (depth, primitive), until one is on the solid's surface: there are few
  // before it, where all crossings of all primitives would be many.
  float depth_m = near_far_m.x;
  int primitive = -1;
  bool hit = false;
  for (int crossing = 0; crossing < 4 * kMaxPrimitives; ++crossing) {
    float next_m = near_far_m.y;
    int next = -1;
    for (int i = 0; i < primitive_count; ++i) {
      vec4 roots = roots_of(i, ray_in(i, direction));
      for (int r = 0; r < 4; ++r) {
        bool is_after = roots[r] > depth_m || (roots[r] == depth_m && i > primitive);
        if (!is_after || !(roots[r] < next_m)) continue;
        next_m = roots[r];
        next = i;
      }
    }
    if (next < 0) break;
    depth_m = next_m;
    primitive = next;
    hit = step_count == 1 || is_on_surface(primitive, depth_m * direction);
    if (hit) break;
  }
  if (!hit) discard;
  float near_m = near_far_m.x, far_m = near_far_m.y;
  // As clip_from_camera does for triangles.
  gl_FragDepth = 0.5 + 0.5 * (far_m + near_m - 2.0 * far_m * near_m / depth_m) / (far_m - near_m);
  out_depth_m = depth_m;
  out_node_index = node_index;
  out_color = color;
}
