// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
//
// Draw an exported bake with Vulkan: glslangValidator -V object.frag.glsl. For OpenGL and WebGL 2 declare the uniforms
// without their sets and bindings, each alone, and put the text of radtex.glsl where it is included. The result is
// scene-linear Rec.709, premultiplied: blend it by ONE and ONE_MINUS_SRC_ALPHA into half floats or an sRGB target.

#version 450
#extension GL_GOOGLE_include_directive : require

#include "../radtex.glsl"

layout(set = 0, binding = 0) uniform Scene {
    mat4 view_projection;
    mat4 model;
    vec3 camera;  // in the world space that `model` leads to
};
layout(set = 0, binding = 1) uniform Bake {
    ivec4 pages;   // of the manifest's texture: "pages" and "page_texels"
    ivec2 texels;  // and "texels"
    int n;         // of the manifest's bake: "bucket"
    int levels;    // of the texture: "levels"
};
#ifdef RADTEX_SLICES                                                // exported by --arrangement slices
layout(set = 0, binding = 2) uniform sampler2DArray slices;
#elif defined(RADTEX_PAGES)                                         // a matrix beyond --limit
layout(set = 0, binding = 2) uniform sampler2DArray atlas;
#else
layout(set = 0, binding = 2) uniform sampler2D atlas;
#endif

layout(location = 0) centroid in vec3 position;
layout(location = 1) centroid in vec3 normal;
layout(location = 2) centroid in vec4 tangent;
layout(location = 3) centroid in vec2 uv;
layout(location = 0) out vec4 colour;

void main() {
    vec3 I = radtex_incidence(camera - position, normal, tangent.xyz, tangent.w);
#ifdef RADTEX_SLICES
    colour = radtex_slices(slices, n, uv, I);
#else
    colour = radtex_sample_level(RADTEX_PASSED, texels, n, uv, I, radtex_level(uv, texels, levels));
#endif
}
