#version 310 es
precision highp float;
precision highp int;

in highp float depth_m;
flat in uint node;
in mediump vec4 vertex_color;

layout(location = 0) out float out_depth_m;
layout(location = 1) out uint out_node_index;
layout(location = 2) out mediump vec4 out_color;

void main() {
  out_depth_m = depth_m;
  out_node_index = node;
  out_color = vertex_color;
}
