// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Written by RadTex's .ci/build_shaders.py from shaders/source/radtex_transfer.c.
//
// Relight an object by a radiance texture of kind `transfer`: WGSL. Put radtex.wgsl, then this, before your shader's
// text, then for each light, and add up what they bring:
//
//     let L = radtex_incidence(direction to the light, normal, tangent.xyz, tangent.w);
//     let answer = radtex_transfer(atlas, vec2i(W, H), n, uv, L);
//     light += answer.rgb * irradiance;  // that the light gives a plane facing it: colour and strength
//
// or by radtex_sun and radtex_point_light. Normal and tangent are as radtex.wgsl takes them, in the space of the
// direction: objects may turn. `atlas` is <name>.transfer.exr: W x H texels of n x n cells, scene-linear Rec.709,
// premultiplied, without mipmaps, uploaded bottom row first (v = 0 is row 0). Alpha is the surface's, in any light.
// Where the sidecar's transfer.view is "around", k being transfer.views and I as radtex_sample takes it, the answer is
//
//     radtex_transfer_around(atlas, vec2i(W, H), k, n, uv, I, L);

// Where a direction, of any length, lies on an octahedral map, in [0, 1]^2: +z in the middle, -z in the corners.
fn radtex_sphere(direction: vec3f) -> vec2f {
    let d = direction / max(abs(direction.x) + abs(direction.y) + abs(direction.z), 1e-30);
    let folded = (1.0 - abs(d.yx)) * vec2f(select(1.0, -1.0, d.x < 0.0), select(1.0, -1.0, d.y < 0.0));
    return select(d.xy, folded, d.z < 0.0) * 0.5 + 0.5;
}

// One cell of one texel. Beyond an edge lies on the sphere the same edge's cell, mirrored at the edge's middle.
fn radtex_sphere_cell(atlas: texture_2d<f32>, texel: vec2i, n: i32, cell: vec2i) -> vec4f {
    let mirrored = n - 1 - cell;
    let x = select(cell.x, mirrored.x, cell.y < 0 || cell.y >= n);
    let y = select(cell.y, mirrored.y, cell.x < 0 || cell.x >= n);
    return radtex_cell(atlas, texel, n, clamp(vec2i(x, y), vec2i(0, 0), vec2i(n - 1, n - 1)), 0);
}

// One texel's map, between the four cells around a place on it.
fn radtex_sphere_texel(atlas: texture_2d<f32>, texel: vec2i, n: i32, place: vec2f) -> vec4f {
    let position = place * f32(n) - 0.5;
    let low = vec2i(floor(position));
    let f = position - vec2f(low);
    let below = mix(radtex_sphere_cell(atlas, texel, n, low),
        radtex_sphere_cell(atlas, texel, n, low + vec2i(1, 0)), f.x);
    let above = mix(radtex_sphere_cell(atlas, texel, n, low + vec2i(0, 1)),
        radtex_sphere_cell(atlas, texel, n, low + vec2i(1, 1)), f.x);
    return mix(below, above, f.y);
}

// Between the four texels around `uv`, of one view among k x k.
fn radtex_sphere_view(atlas: texture_2d<f32>, texels: vec2i, k: i32, view: vec2i, n: i32, uv: vec2f,
                      place: vec2f) -> vec4f {
    let position = uv * vec2f(texels) - 0.5;
    let last = texels - 1;
    let corner = vec2i(floor(position));
    let low = clamp(corner, vec2i(0, 0), last) * k + view;
    let high = clamp(corner + 1, vec2i(0, 0), last) * k + view;
    let f = position - vec2f(corner);
    let below = mix(radtex_sphere_texel(atlas, low, n, place),
        radtex_sphere_texel(atlas, vec2i(high.x, low.y), n, place), f.x);
    let above = mix(radtex_sphere_texel(atlas, vec2i(low.x, high.y), n, place),
        radtex_sphere_texel(atlas, high, n, place), f.x);
    return mix(below, above, f.y);
}

// Radiance (rgb) that leaves the surface at `uv` under light of irradiance 1 from the direction L of the frame, of any
// length but zero, and alpha: between four texels.
fn radtex_transfer(atlas: texture_2d<f32>, texels: vec2i, n: i32, uv: vec2f, L: vec3f) -> vec4f {
    return radtex_sphere_view(atlas, texels, 1, vec2i(0, 0), n, uv, radtex_sphere(L));
}

// The same as a viewer in the unit direction I of the frame sees it, between the four views around that of k x k.
fn radtex_transfer_around(atlas: texture_2d<f32>, texels: vec2i, k: i32, n: i32, uv: vec2f, I: vec3f,
                          L: vec3f) -> vec4f {
    let inner = f32(k) - 0.5;
    let among = clamp((radtex_bucket(I) + 1.0) * 0.5 * f32(k), vec2f(0.5, 0.5), vec2f(inner, inner)) - 0.5;
    let low = vec2i(among);
    let high = min(low + 1, vec2i(k - 1, k - 1));
    let f = among - vec2f(low);
    let place = radtex_sphere(L);
    let below = mix(radtex_sphere_view(atlas, texels, k, low, n, uv, place),
        radtex_sphere_view(atlas, texels, k, vec2i(high.x, low.y), n, uv, place), f.x);
    let above = mix(radtex_sphere_view(atlas, texels, k, vec2i(low.x, high.y), n, uv, place),
        radtex_sphere_view(atlas, texels, k, high, n, uv, place), f.x);
    return mix(below, above, f.y);
}

// Radiance under a directional light: `to_light` points to it, `irradiance` is what a plane facing it receives.
fn radtex_sun(atlas: texture_2d<f32>, texels: vec2i, n: i32, uv: vec2f, normal: vec3f, tangent: vec4f, to_light: vec3f,
              irradiance: vec3f) -> vec3f {
    let L = radtex_incidence(to_light, normal, tangent.xyz, tangent.w);
    return radtex_transfer(atlas, texels, n, uv, L).rgb * irradiance;
}

// Radiance under a point light of radiant `intensity`, `to_light` away. Right where the light is far against how far
// light spreads below the surface: its direction is taken for the same all over the object.
fn radtex_point_light(atlas: texture_2d<f32>, texels: vec2i, n: i32, uv: vec2f, normal: vec3f, tangent: vec4f,
                      to_light: vec3f, intensity: vec3f) -> vec3f {
    let irradiance = intensity / max(dot(to_light, to_light), 1e-30);
    return radtex_sun(atlas, texels, n, uv, normal, tangent, to_light, irradiance);
}
