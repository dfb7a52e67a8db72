// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
//
// The vertex stage of object.frag.glsl: POSITION, NORMAL, TANGENT and TEXCOORD_0 of an exported <name>.glb. Centroid, for
// at the rim of a triangle a pixel's middle may lie beyond it, where the mesh, and its map, has nothing.

#version 450

layout(set = 0, binding = 0) uniform Scene {
    mat4 view_projection;
    mat4 model;
    vec3 camera;  // in the world space that `model` leads to
};

layout(location = 0) in vec3 in_position;
layout(location = 1) in vec3 in_normal;
layout(location = 2) in vec4 in_tangent;
layout(location = 3) in vec2 in_uv;
layout(location = 0) centroid out vec3 position;
layout(location = 1) centroid out vec3 normal;
layout(location = 2) centroid out vec4 tangent;
layout(location = 3) centroid out vec2 uv;

void main() {
    mat3 turn = mat3(model);
    float mirrored = sign(determinant(turn));
    vec4 world = model * vec4(in_position, 1.0);
    gl_Position = view_projection * world;
    position = world.xyz;
    normal = mirrored * mat3(cross(turn[1], turn[2]), cross(turn[2], turn[0]), cross(turn[0], turn[1])) * in_normal;
    tangent = vec4(turn * in_tangent.xyz, mirrored * in_tangent.w);
    uv = vec2(in_uv.x, 1.0 - in_uv.y);  // glTF's v grows downwards
}
