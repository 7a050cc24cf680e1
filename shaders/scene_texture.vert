#version 310 es
// Nodes with a texture as a pinhole camera sees them. As scene.vert, but for where the colour comes from.
layout(location = 0) in vec3 position;

// From the node's frame to clip space; its fourth row gives metres along the optical axis.
layout(location = 0) uniform highp mat4 clip_from_node;
layout(location = 1) uniform highp uint node_index;
// common/mesh/texture.h: from the node's frame to pixels of the picture.
layout(location = 2) uniform highp mat4x3 picture_from_node;

out highp float depth_m;
flat out highp uint node;
// Divided in the fragment, so that the pixel is exact across the triangle from wherever it is seen.
out highp vec3 picture_pixel;

void main() {
  gl_Position = clip_from_node * vec4(position, 1.0);
  depth_m = gl_Position.w;
  node = node_index;
  picture_pixel = picture_from_node * vec4(position, 1.0);
}
