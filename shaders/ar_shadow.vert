#version 310 es
precision highp float;

layout(location = 0) in vec3 position;
layout(location = 0) uniform mat4 clip_from_mesh;

void main() { gl_Position = clip_from_mesh * vec4(position, 1.0); }
