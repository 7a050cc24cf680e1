#version 310 es
precision highp float;
precision highp int;

in highp float depth_m;
flat in uint node;

layout(location = 0) out float out_depth_m;
layout(location = 1) out uint out_node_index;

void main() {
  out_depth_m = depth_m;
  out_node_index = node;
}
