// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
//
// Look up a radiance texture in the shared layout: HLSL, shader model 5 and later. radtex.hlsl, which
// must lie beside it, says what RADTEX_TOP_DOWN and RADTEX_HARDWARE_LINEAR do. Include it, then
//
//     float3 V = normalize(camera - position), N = normalize(normal);  // in the world space of the bake
//     float3 light = radtex_diffuse(colour, irradiance, falloff, uv, dot(N, V))
//         + radtex_lobe(mirror_ends, mirror_gain, mirror_rest, n, surroundings, around, uv, reflect(-V, N))
//         + radtex_lobe(through_ends, through_gain, through_rest, n, surroundings, around, uv, -V);
//     light = max(light, 0.0);
//
// without a lobe that the sidecar's "lobes" lack, or with both by radtex_shared. The textures are
// <name>.radiance.<layer>.*, scene-linear Rec.709 (never sRGB), without mipmaps. From the sidecar: n is "bucket",
// `around` is "surroundings" and "levels", `falloff` is "falloff". v grows upwards, as in Blender.

#ifndef RADTEX_SHARED_HLSL
#define RADTEX_SHARED_HLSL

#include "radtex.hlsl"

#ifndef RADTEX_FALLOFF
#define RADTEX_FALLOFF 16  // the falloff's points: as many as the sidecar has
#endif

// Bilinear between the pixels of a box at `origin`, never beyond it; `position` in pixels, their centres at a half.
float4 radtex_bilinear(Texture2D image, int2 origin, int2 box, float2 position) {
    position = clamp(position, 0.5, box - 0.5);
#ifdef RADTEX_HARDWARE_LINEAR  // one lookup. Its weights have 8 bits
    return radtex_filtered(image, origin + position, 0);
#else
    int2 low = int2(position - 0.5), high = min(low + 1, box - 1);
    float2 f = position - 0.5 - low;
    float4 below = lerp(radtex_fetch(image, origin + low, 0),
                        radtex_fetch(image, origin + int2(high.x, low.y), 0), f.x);
    float4 above = lerp(radtex_fetch(image, origin + int2(low.x, high.y), 0),
                        radtex_fetch(image, origin + high, 0), f.x);
    return lerp(below, above, f.y);
#endif
}

// Where a direction, of any length, lies on an octahedral picture of n x n cells: in pixels from its border's corner.
float2 radtex_octahedron(float3 d, int n) {
    d /= max(abs(d.x) + abs(d.y) + abs(d.z), 1e-30);
    float2 folded = (1.0 - abs(d.yx)) * float2(d.x < 0.0 ? -1.0 : 1.0, d.y < 0.0 ? -1.0 : 1.0);
    return ((d.z < 0.0 ? folded : d.xy) * 0.5 + 0.5) * n + 1.0;
}

// The four buckets of n x n cells around `uv`, each at `place`, blended.
float4 radtex_buckets(Texture2D image, int n, float2 uv, float2 place) {
    int2 box = n + 2, last = radtex_size(image, 0) / box - 1;
    float2 position = clamp(uv * (last + 1) - 0.5, 0.0, float2(last));
    int2 low = int2(position), high = min(low + 1, last);
    float2 f = position - low;
    float4 below = lerp(radtex_bilinear(image, low * box, box, place),
                        radtex_bilinear(image, int2(high.x, low.y) * box, box, place), f.x);
    float4 above = lerp(radtex_bilinear(image, int2(low.x, high.y) * box, box, place),
                        radtex_bilinear(image, high * box, box, place), f.x);
    return lerp(below, above, f.y);
}

// One level of the surroundings, whose sharpest has `size` x `size` cells; the others lie in a column beside it.
float3 radtex_level(Texture2D surroundings, int size, int level, float3 d) {
    int side = max(size >> level, 8);
    int2 origin = int2(level > 0 ? size + 2 : 0, 0);
    for (int k = 1; k < level; k++) origin.y += max(size >> k, 8) + 2;
    return radtex_bilinear(surroundings, origin, side + 2, radtex_octahedron(d, side)).rgb;
}

// Surroundings around the direction d, blurred by a variance in units of the sharpest level's. Each level has four
// times the variance of the one before.
float3 radtex_surroundings(Texture2D surroundings, int2 around, float3 d, float spread) {
    float level = clamp(0.5 * log2(max(spread, 1.0)), 0.0, around.y - 1.0);
    int low = int(level), high = min(low + 1, around.y - 1);
    float3 sharper = radtex_level(surroundings, around.x, low, d);
    return lerp(sharper, radtex_level(surroundings, around.x, high, d), level - low);
}

// Light that leaves every way alike, but for its falloff with the cosine N.V. `fine` and `texels` are the images'
// sizes: an image may be padded on the right and at the top.
float3 radtex_diffuse(Texture2D colour, int2 fine, Texture2D irradiance, int2 texels, float3 falloff[RADTEX_FALLOFF],
                      float2 uv, float cosine) {
    float place = clamp(cosine * RADTEX_FALLOFF - 0.5, 0.0, RADTEX_FALLOFF - 1.0);
    int low = int(place);
    return radtex_bilinear(colour, 0, fine, uv * fine).rgb
        * radtex_bilinear(irradiance, 0, texels, uv * texels).rgb
        * lerp(falloff[low], falloff[min(low + 1, RADTEX_FALLOFF - 1)], place - low);
}

// The same of images that are not padded.
float3 radtex_diffuse(Texture2D colour, Texture2D irradiance, float3 falloff[RADTEX_FALLOFF], float2 uv, float cosine) {
    int2 fine = radtex_size(colour, 0), texels = radtex_size(irradiance, 0);
    return radtex_diffuse(colour, fine, irradiance, texels, falloff, uv, cosine);
}

// Light that leaves along a lobe: its axis, in world space, is reflect(-V, N) for "mirror" and -V for "through".
float3 radtex_lobe(Texture2D ends, Texture2D gain, Texture2D rest, int n, Texture2D surroundings, int2 around,
                   float2 uv, float3 axis) {
    float2 place = radtex_octahedron(axis, n);
    float4 end = radtex_buckets(ends, n, uv, place);
    float3 met = radtex_surroundings(surroundings, around, axis + end.xyz, end.w);
    return radtex_buckets(gain, n, uv, place).rgb * met + radtex_buckets(rest, n, uv, place).rgb;
}

// The direction V to the viewer whose place a ray takes that hits the surface: `ray` leads to it, unit as N is. One from
// behind N counts as grazing: at a slant a smooth normal turns away from rays that do hit the front. A ray that meets a
// facet's back is no hit.
float3 radtex_hit_viewer(float3 ray, float3 N) {
    float3 V = max(dot(ray, N), 0.0) * N - ray;
    return V / max(length(V), 1e-30);
}

// Radiance of a bake with both lobes towards the viewer, in the unit direction V, where the unit normal is N.
float3 radtex_shared(Texture2D colour, Texture2D irradiance, float3 falloff[RADTEX_FALLOFF],
                     Texture2D mirror_ends, Texture2D mirror_gain, Texture2D mirror_rest,
                     Texture2D through_ends, Texture2D through_gain, Texture2D through_rest, int n,
                     Texture2D surroundings, int2 around, float2 uv, float3 N, float3 V) {
    float3 light = radtex_diffuse(colour, irradiance, falloff, uv, dot(N, V))
        + radtex_lobe(mirror_ends, mirror_gain, mirror_rest, n, surroundings, around, uv, reflect(-V, N))
        + radtex_lobe(through_ends, through_gain, through_rest, n, surroundings, around, uv, -V);
    return max(light, 0.0);
}

// What a ray finds where it hits the surface, for a runtime that traces: V is radtex_hit_viewer(ray, N).
float3 radtex_shared_hit(Texture2D colour, Texture2D irradiance, float3 falloff[RADTEX_FALLOFF],
                         Texture2D mirror_ends, Texture2D mirror_gain, Texture2D mirror_rest,
                         Texture2D through_ends, Texture2D through_gain, Texture2D through_rest, int n,
                         Texture2D surroundings, int2 around, float2 uv, float3 N, float3 ray) {
    return radtex_shared(colour, irradiance, falloff, mirror_ends, mirror_gain, mirror_rest,
                         through_ends, through_gain, through_rest, n, surroundings, around, uv, N,
                         radtex_hit_viewer(ray, N));
}

#endif
