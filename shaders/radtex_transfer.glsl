// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Written by RadTex's .ci/build_shaders.py from shaders/source/radtex_transfer.c.
//
// Relight an object by a radiance texture of kind `transfer`: GLSL 330 and later, GLSL ES 300 (WebGL 2) and later.
// Include radtex.glsl, then this, then for each light, and add up what they bring:
//
//     vec3 L = radtex_incidence(direction to the light, normal, tangent.xyz, tangent.w);
//     vec4 answer = radtex_transfer(atlas, ivec2(W, H), n, uv, L);
//     light += answer.rgb * irradiance;  // that the light gives a plane facing it: colour and strength
//
// or by radtex_sun and radtex_point_light. Normal and tangent are as radtex.glsl takes them, in the space of the
// direction: objects may turn. `atlas` is <name>.transfer.exr: W x H texels of n x n cells, scene-linear Rec.709,
// premultiplied, without mipmaps, uploaded bottom row first (v = 0 is row 0). Alpha is the surface's, in any light.
// Where the sidecar's transfer.view is "around", k being transfer.views and I as radtex_sample takes it, the answer is
//
//     radtex_transfer_around(atlas, ivec2(W, H), k, n, uv, I, L);
//
// RADTEX_PAGES is as in radtex.glsl; pages of such an atlas count W k x H k texels.

// Where a direction, of any length, lies on an octahedral map, in [0, 1]^2: +z in the middle, -z in the corners.
vec2 radtex_sphere(vec3 direction) {
    vec3 d = direction / max(abs(direction.x) + abs(direction.y) + abs(direction.z), 1e-30);
    vec2 folded = (1.0 - abs(d.yx)) * vec2(d.x < 0.0 ? -1.0 : 1.0, d.y < 0.0 ? -1.0 : 1.0);
    return (d.z < 0.0 ? folded : d.xy) * 0.5 + 0.5;
}

// One cell of one texel. Beyond an edge lies on the sphere the same edge's cell, mirrored at the edge's middle.
vec4 radtex_sphere_cell(RADTEX_ATLAS, ivec2 texel, int n, ivec2 cell) {
    ivec2 mirrored = n - 1 - cell;
    int x = cell.y < 0 || cell.y >= n ? mirrored.x : cell.x, y = cell.x < 0 || cell.x >= n ? mirrored.y : cell.y;
    return radtex_cell(RADTEX_PASSED, texel, n, clamp(ivec2(x, y), ivec2(0, 0), ivec2(n - 1, n - 1)), 0);
}

// One texel's map, between the four cells around a place on it.
vec4 radtex_sphere_texel(RADTEX_ATLAS, ivec2 texel, int n, vec2 place) {
    vec2 position = place * float(n) - 0.5;
    ivec2 low = ivec2(floor(position));
    vec2 f = position - vec2(low);
    vec4 below = mix(radtex_sphere_cell(RADTEX_PASSED, texel, n, low),
        radtex_sphere_cell(RADTEX_PASSED, texel, n, low + ivec2(1, 0)), f.x);
    vec4 above = mix(radtex_sphere_cell(RADTEX_PASSED, texel, n, low + ivec2(0, 1)),
        radtex_sphere_cell(RADTEX_PASSED, texel, n, low + ivec2(1, 1)), f.x);
    return mix(below, above, f.y);
}

// Between the four texels around `uv`, of one view among k x k.
vec4 radtex_sphere_view(RADTEX_ATLAS, ivec2 texels, int k, ivec2 view, int n, vec2 uv, vec2 place) {
    vec2 position = uv * vec2(texels) - 0.5;
    ivec2 last = texels - 1, corner = ivec2(floor(position));
    ivec2 low = clamp(corner, ivec2(0, 0), last) * k + view, high = clamp(corner + 1, ivec2(0, 0), last) * k + view;
    vec2 f = position - vec2(corner);
    vec4 below = mix(radtex_sphere_texel(RADTEX_PASSED, low, n, place),
        radtex_sphere_texel(RADTEX_PASSED, ivec2(high.x, low.y), n, place), f.x);
    vec4 above = mix(radtex_sphere_texel(RADTEX_PASSED, ivec2(low.x, high.y), n, place),
        radtex_sphere_texel(RADTEX_PASSED, high, n, place), f.x);
    return mix(below, above, f.y);
}

// Radiance (rgb) that leaves the surface at `uv` under light of irradiance 1 from the direction L of the frame, of any
// length but zero, and alpha: between four texels.
vec4 radtex_transfer(RADTEX_ATLAS, ivec2 texels, int n, vec2 uv, vec3 L) {
    return radtex_sphere_view(RADTEX_PASSED, texels, 1, ivec2(0, 0), n, uv, radtex_sphere(L));
}

// The same as a viewer in the unit direction I of the frame sees it, between the four views around that of k x k.
vec4 radtex_transfer_around(RADTEX_ATLAS, ivec2 texels, int k, int n, vec2 uv, vec3 I, vec3 L) {
    float inner = float(k) - 0.5;
    vec2 among = clamp((radtex_bucket(I) + 1.0) * 0.5 * float(k), vec2(0.5, 0.5), vec2(inner, inner)) - 0.5;
    ivec2 low = ivec2(among), high = min(low + 1, ivec2(k - 1, k - 1));
    vec2 f = among - vec2(low), place = radtex_sphere(L);
    vec4 below = mix(radtex_sphere_view(RADTEX_PASSED, texels, k, low, n, uv, place),
        radtex_sphere_view(RADTEX_PASSED, texels, k, ivec2(high.x, low.y), n, uv, place), f.x);
    vec4 above = mix(radtex_sphere_view(RADTEX_PASSED, texels, k, ivec2(low.x, high.y), n, uv, place),
        radtex_sphere_view(RADTEX_PASSED, texels, k, high, n, uv, place), f.x);
    return mix(below, above, f.y);
}

// Radiance under a directional light: `to_light` points to it, `irradiance` is what a plane facing it receives.
vec3 radtex_sun(RADTEX_ATLAS, ivec2 texels, int n, vec2 uv, vec3 normal, vec4 tangent, vec3 to_light, vec3 irradiance) {
    vec3 L = radtex_incidence(to_light, normal, tangent.xyz, tangent.w);
    return radtex_transfer(RADTEX_PASSED, texels, n, uv, L).rgb * irradiance;
}

// Radiance under a point light of radiant `intensity`, `to_light` away. Right where the light is far against how far
// light spreads below the surface: its direction is taken for the same all over the object.
vec3 radtex_point_light(RADTEX_ATLAS, ivec2 texels, int n, vec2 uv, vec3 normal, vec4 tangent, vec3 to_light,
                        vec3 intensity) {
    vec3 irradiance = intensity / max(dot(to_light, to_light), 1e-30);
    return radtex_sun(RADTEX_PASSED, texels, n, uv, normal, tangent, to_light, irradiance);
}
