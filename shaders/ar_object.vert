#version 310 es
precision highp float;

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 color;
layout(location = 2) in vec3 normal;

layout(location = 0) uniform mat4 world_from_object;
layout(location = 1) uniform mat4 camera_from_object;
layout(location = 2) uniform mat4 clip_from_camera;

out vec3 p_world;
out vec3 normal_world;
out vec3 albedo;
out float z_camera;

void main() {
  vec4 p_camera = camera_from_object * vec4(position, 1.0);
  p_world = (world_from_object * vec4(position, 1.0)).xyz;
  normal_world = mat3(world_from_object) * normal;
  albedo = color;
  z_camera = p_camera.z;
  gl_Position = clip_from_camera * p_camera;
}
