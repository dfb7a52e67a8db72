// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Written by RadTex's .ci/build_shaders.py from shaders/source/radtex_transfer.c.
//
// Relight an object by a radiance texture of kind `transfer`: HLSL, shader model 5 and later.
// Include radtex.hlsl, then this, then for each light, and add up what they bring:
//
//     float3 L = radtex_incidence(direction to the light, normal, tangent.xyz, tangent.w);
//     float4 answer = radtex_transfer(atlas, int2(W, H), n, uv, L);
//     light += answer.rgb * irradiance;  // that the light gives a plane facing it: colour and strength
//
// or by radtex_sun and radtex_point_light. Normal and tangent are as radtex.hlsl takes them, in the space of the
// direction: objects may turn. `atlas` is <name>.transfer.exr: W x H texels of n x n cells, scene-linear Rec.709,
// premultiplied, without mipmaps. Alpha is the surface's, in any light.
// Where the sidecar's transfer.view is "around", k being transfer.views and I as radtex_sample takes it, the answer is
//
//     radtex_transfer_around(atlas, int2(W, H), k, n, uv, I, L);
//
// RADTEX_PAGES and RADTEX_TOP_DOWN are as in radtex.hlsl; pages of such an atlas count W k x H k texels.

#ifndef RADTEX_TRANSFER_HLSL
#define RADTEX_TRANSFER_HLSL

// Where a direction, of any length, lies on an octahedral map, in [0, 1]^2: +z in the middle, -z in the corners.
float2 radtex_sphere(float3 direction) {
    float3 d = direction / max(abs(direction.x) + abs(direction.y) + abs(direction.z), 1e-30);
    float2 folded = (1.0 - abs(d.yx)) * float2(d.x < 0.0 ? -1.0 : 1.0, d.y < 0.0 ? -1.0 : 1.0);
    return (d.z < 0.0 ? folded : d.xy) * 0.5 + 0.5;
}

// One cell of one texel. Beyond an edge lies on the sphere the same edge's cell, mirrored at the edge's middle.
float4 radtex_sphere_cell(RADTEX_ATLAS, int2 texel, int n, int2 cell) {
    int2 mirrored = n - 1 - cell;
    int x = cell.y < 0 || cell.y >= n ? mirrored.x : cell.x, y = cell.x < 0 || cell.x >= n ? mirrored.y : cell.y;
    return radtex_cell(RADTEX_PASSED, texel, n, clamp(int2(x, y), int2(0, 0), int2(n - 1, n - 1)), 0);
}

// One texel's map, between the four cells around a place on it.
float4 radtex_sphere_texel(RADTEX_ATLAS, int2 texel, int n, float2 place) {
    float2 position = place * float(n) - 0.5;
    int2 low = int2(floor(position));
    float2 f = position - float2(low);
    float4 below = lerp(radtex_sphere_cell(RADTEX_PASSED, texel, n, low),
        radtex_sphere_cell(RADTEX_PASSED, texel, n, low + int2(1, 0)), f.x);
    float4 above = lerp(radtex_sphere_cell(RADTEX_PASSED, texel, n, low + int2(0, 1)),
        radtex_sphere_cell(RADTEX_PASSED, texel, n, low + int2(1, 1)), f.x);
    return lerp(below, above, f.y);
}

// Between the four texels around `uv`, of one view among k x k.
float4 radtex_sphere_view(RADTEX_ATLAS, int2 texels, int k, int2 view, int n, float2 uv, float2 place) {
    float2 position = uv * float2(texels) - 0.5;
    int2 last = texels - 1, corner = int2(floor(position));
    int2 low = clamp(corner, int2(0, 0), last) * k + view, high = clamp(corner + 1, int2(0, 0), last) * k + view;
    float2 f = position - float2(corner);
    float4 below = lerp(radtex_sphere_texel(RADTEX_PASSED, low, n, place),
        radtex_sphere_texel(RADTEX_PASSED, int2(high.x, low.y), n, place), f.x);
    float4 above = lerp(radtex_sphere_texel(RADTEX_PASSED, int2(low.x, high.y), n, place),
        radtex_sphere_texel(RADTEX_PASSED, high, n, place), f.x);
    return lerp(below, above, f.y);
}

// Radiance (rgb) that leaves the surface at `uv` under light of irradiance 1 from the direction L of the frame, of any
// length but zero, and alpha: between four texels.
float4 radtex_transfer(RADTEX_ATLAS, int2 texels, int n, float2 uv, float3 L) {
    return radtex_sphere_view(RADTEX_PASSED, texels, 1, int2(0, 0), n, uv, radtex_sphere(L));
}

// The same as a viewer in the unit direction I of the frame sees it, between the four views around that of k x k.
float4 radtex_transfer_around(RADTEX_ATLAS, int2 texels, int k, int n, float2 uv, float3 I, float3 L) {
    float inner = float(k) - 0.5;
    float2 among = clamp((radtex_bucket(I) + 1.0) * 0.5 * float(k), float2(0.5, 0.5), float2(inner, inner)) - 0.5;
    int2 low = int2(among), high = min(low + 1, int2(k - 1, k - 1));
    float2 f = among - float2(low), place = radtex_sphere(L);
    float4 below = lerp(radtex_sphere_view(RADTEX_PASSED, texels, k, low, n, uv, place),
        radtex_sphere_view(RADTEX_PASSED, texels, k, int2(high.x, low.y), n, uv, place), f.x);
    float4 above = lerp(radtex_sphere_view(RADTEX_PASSED, texels, k, int2(low.x, high.y), n, uv, place),
        radtex_sphere_view(RADTEX_PASSED, texels, k, high, n, uv, place), f.x);
    return lerp(below, above, f.y);
}

// Radiance under a directional light: `to_light` points to it, `irradiance` is what a plane facing it receives.
float3 radtex_sun(RADTEX_ATLAS, int2 texels, int n, float2 uv, float3 normal, float4 tangent, float3 to_light,
                  float3 irradiance) {
    float3 L = radtex_incidence(to_light, normal, tangent.xyz, tangent.w);
    return radtex_transfer(RADTEX_PASSED, texels, n, uv, L).rgb * irradiance;
}

// Radiance under a point light of radiant `intensity`, `to_light` away. Right where the light is far against how far
// light spreads below the surface: its direction is taken for the same all over the object.
float3 radtex_point_light(RADTEX_ATLAS, int2 texels, int n, float2 uv, float3 normal, float4 tangent, float3 to_light,
                          float3 intensity) {
    float3 irradiance = intensity / max(dot(to_light, to_light), 1e-30);
    return radtex_sun(RADTEX_PASSED, texels, n, uv, normal, tangent, to_light, irradiance);
}

#endif
