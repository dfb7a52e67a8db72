// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
//
// Draw an exported bake: the mesh of <name>.glb, lit by <name>.radiance.ktx2 alone, a matrix with levels. Put it behind
// radtex.wgsl. What it returns is scene-linear Rec.709, premultiplied: blend it by ("one", "one-minus-src-alpha") into
// a picture of half floats, or onto a view whose format ends in -srgb.

struct Scene {
    view_projection: mat4x4f,
    model: mat4x4f,
    camera: vec3f,  // in the world space that `model` leads to
    n: i32,         // of the manifest's bake: "bucket"
    texels: vec2i,  // of the manifest's texture: "texels"
    levels: i32,    // and "levels"
}
@group(0) @binding(0) var<uniform> scene: Scene;
@group(0) @binding(1) var atlas: texture_2d<f32>;

// Centroid: at the rim of a triangle a pixel's middle may lie beyond it, where the mesh, and its map, has nothing.
struct Fragment {
    @builtin(position) clip: vec4f,
    @location(0) @interpolate(perspective, centroid) position: vec3f,
    @location(1) @interpolate(perspective, centroid) normal: vec3f,
    @location(2) @interpolate(perspective, centroid) tangent: vec4f,
    @location(3) @interpolate(perspective, centroid) uv: vec2f,
}

// POSITION, NORMAL, TANGENT and TEXCOORD_0 of the mesh, whose v grows downwards.
@vertex fn vertex(@location(0) position: vec3f, @location(1) normal: vec3f, @location(2) tangent: vec4f,
                  @location(3) uv: vec2f) -> Fragment {
    let turn = mat3x3f(scene.model[0].xyz, scene.model[1].xyz, scene.model[2].xyz);
    let mirrored = sign(determinant(turn));
    let cofactors = mat3x3f(cross(turn[1], turn[2]), cross(turn[2], turn[0]), cross(turn[0], turn[1]));
    let world = scene.model * vec4f(position, 1.0);
    return Fragment(scene.view_projection * world, world.xyz, mirrored * (cofactors * normal),
                    vec4f(turn * tangent.xyz, mirrored * tangent.w), vec2f(uv.x, 1.0 - uv.y));
}

@fragment fn fragment(at: Fragment) -> @location(0) vec4f {
    let I = radtex_incidence(scene.camera - at.position, at.normal, at.tangent.xyz, at.tangent.w);
    let level = radtex_level(at.uv, scene.texels, scene.levels);
    return radtex_sample_level(atlas, scene.texels, scene.n, at.uv, I, level);
}
