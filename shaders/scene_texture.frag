#version 310 es
precision highp float;
precision highp int;

in highp float depth_m;
flat in uint node;
in highp vec3 picture_pixel;

layout(binding = 0) uniform mediump sampler2D picture;

layout(location = 0) out float out_depth_m;
layout(location = 1) out uint out_node_index;
layout(location = 2) out mediump vec4 out_color;

void main() {
  out_depth_m = depth_m;
  out_node_index = node;
  // Pixel (0, 0) has its middle half a pixel inside the picture.
  vec2 pixel = picture_pixel.xy / picture_pixel.z + 0.5;
  out_color = vec4(textureLod(picture, pixel / vec2(textureSize(picture, 0)), 0.0).rgb, 1.0);
}
