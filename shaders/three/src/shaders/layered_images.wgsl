// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Light of a bake in the layout `layered`, whose material is shown by its own images. Its places and directions are
// Blender's: z up.

fn radtex_of_blender(vector: vec3f) -> vec3f {
    return vec3f(vector.x, -vector.z, vector.y);
}

// Light towards the viewer in the unit direction V, premultiplied by alpha.
fn radtex_seen(place: vec3f, uv: vec2f, images: vec2f, normal: vec3f, tangent: vec4f, V: vec3f) -> vec4f {
    let face = radtex_of_blender(normal);
    let T = radtex_of_blender(tangent.xyz);
    let B = tangent.w * cross(face, T);
    let base = textureSample(radtex_base_map, radtex_base_map_sampler, images).rgb;
    let rough = textureSample(radtex_metal_map, radtex_metal_map_sampler, images).gb;
    let bump = textureSample(radtex_bump_map, radtex_bump_map_sampler, images).xyz;
    let alpha = radtex_alpha(uv);
    let look = radtex_look_of(radtex_images[0], radtex_images[1], radtex_images[2], base, rough, bump, T, B, face, alpha);
    let N = normalize(face);
    let turned = look.normal * inverseSqrt(max(dot(look.normal, look.normal), 1e-12));
    let shading = select(N, turned, dot(turned, N) > 0.3);
    let across = dpdx(shading);
    let up = dpdy(shading);
    let spread = RADTEX_STEADY * (dot(across, across) + dot(up, up));
    return vec4f(radtex_lit(uv, radtex_of_blender(place), N, radtex_of_blender(V), look, spread), alpha);
}
