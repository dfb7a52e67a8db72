// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Light of a bake in the layout `layered`. Its places and directions are Blender's: z up; the page's y is up.

fn radtex_of_blender(vector: vec3f) -> vec3f {
    return vec3f(vector.x, -vector.z, vector.y);
}

// Light towards the viewer in the unit direction V, premultiplied by alpha.
fn radtex_seen(place: vec3f, uv: vec2f, images: vec2f, normal: vec3f, tangent: vec4f, V: vec3f) -> vec4f {
    let N = radtex_of_blender(normalize(normal));
    let seen = radtex_layered_steady(uv, radtex_of_blender(place), N, radtex_of_blender(V), RADTEX_STEADY);
    return vec4f(seen, radtex_alpha(uv));
}
