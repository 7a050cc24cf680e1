#version 310 es
// The model as a pinhole camera sees it.
layout(location = 0) in vec3 position;
layout(location = 1) in vec4 color;

// From the node's frame to clip space; its fourth row gives metres along the optical axis.
layout(location = 0) uniform highp mat4 clip_from_node;
layout(location = 1) uniform highp uint node_index;

out highp float depth_m;
flat out highp uint node;
out mediump vec4 vertex_color;

void main() {
  gl_Position = clip_from_node * vec4(position, 1.0);
  depth_m = gl_Position.w;
  node = node_index;
  vertex_color = color;
}
