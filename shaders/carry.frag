#version 310 es
// Which depth pixel is seen: the nearest one, never a mixture.
precision highp float;
precision highp int;

layout(location = 1) uniform int depth_width;

in highp vec2 depth_pixel;
flat in highp ivec2 first_pixel;
flat in highp ivec2 last_pixel;

// Position in the depth image, plus 1.
layout(location = 0) out uint source;

void main() {
  ivec2 pixel = clamp(ivec2(floor(depth_pixel + 0.5)), first_pixel, last_pixel);
  source = uint(pixel.y * depth_width + pixel.x + 1);
}
