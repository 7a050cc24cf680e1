#version 310 es
precision highp float;
precision highp int;

layout(location = 1) uniform uint node_index;

in highp float depth_m;
in mediump vec4 vertex_color;

layout(location = 0) out float out_depth_m;
layout(location = 1) out uint out_node_index;
layout(location = 2) out mediump vec4 out_color;

void main() {
  out_depth_m = depth_m;
  out_node_index = node_index;
  out_color = vertex_color;
}
