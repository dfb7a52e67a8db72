// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Light of a bake in the layout `layered` that light comes through. Its places and directions are Blender's: z up.

fn radtex_of_blender(vector: vec3f) -> vec3f {
    return vec3f(vector.x, -vector.z, vector.y);
}

// Light towards the viewer in the unit direction V, premultiplied by alpha.
fn radtex_seen(place: vec3f, uv: vec2f, images: vec2f, normal: vec3f, tangent: vec4f, V: vec3f) -> vec4f {
    let N = radtex_of_blender(normalize(normal));
    let along = radtex_of_blender(tangent.xyz);
    let T = normalize(along - dot(along, N) * N);
    let B = tangent.w * cross(N, T);
    let seen = radtex_layered_through(uv, radtex_of_blender(place), N, radtex_of_blender(V), T, B);
    return vec4f(seen, radtex_alpha(uv));
}
