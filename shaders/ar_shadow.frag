#version 310 es
precision highp float;

void main() {}
