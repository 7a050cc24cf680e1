#version 310 es
// Pieces of the measured surface, drawn into the colour camera. server/show/README.md says how they are made.
precision highp float;
precision highp int;

// Column and row in the depth image, inverse depth there (1/m).
layout(location = 0) in vec3 place;
// The block's first column, first row and size, in 14, 14 and 4 bits.
layout(location = 1) in uint block;

// From (column, row, 1, inverse depth) to the colour camera's clip space: back-projection leaves out the factor depth.
layout(location = 0) uniform highp mat4 clip_from_place;

out highp vec2 depth_pixel;
flat out highp ivec2 first_pixel;
flat out highp ivec2 last_pixel;

void main() {
  gl_Position = clip_from_place * vec4(place.xy, 1.0, place.z);
  depth_pixel = place.xy;
  first_pixel = ivec2(int(block & 0x3fffu), int((block >> 14) & 0x3fffu));
  last_pixel = first_pixel + int(block >> 28) - 1;
}
