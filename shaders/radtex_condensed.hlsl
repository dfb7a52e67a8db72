// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
//
// Look up a radiance texture in the condensed form of the shared layout: HLSL, shader model 5 and later.
// radtex_shared.hlsl and radtex.hlsl must lie beside it. Include it, then
//
//     float3 V = normalize(camera - position), N = normalize(normal);  // in the world space of the bake
//     float3 light = radtex_diffuse(colour, fine, irradiance, texels, falloff, uv, dot(N, V))
//         + radtex_condensed_lobe(mirror_weights, mirror_ends_xy, mirror_ends_zs, mirror_gain, mirror_rest,
//                                 mirror_ranges, columns, n, texels, surroundings, around, uv, reflect(-V, N))
//         + radtex_condensed_lobe(through_weights, through_ends_xy, through_ends_zs, through_gain, through_rest,
//                                 through_ranges, columns, n, texels, surroundings, around, uv, -V);
//     light = max(light, 0.0);
//
// without a lobe that the sidecar's "lobes" lack, or with both by radtex_condensed. The textures are
// <name>.radiance.<layer>.dds, uploaded as they are: linear (never sRGB), without mipmaps. From the sidecar: n is
// "bucket", `fine` is "colour", `texels` is "texels", `around` is "surroundings" and "levels", `falloff` is
// "falloff". Of "condensed", `columns` is "columns"; a lobe's `ranges` are the four lists of its "ends", then of its
// "gain", then of its "rest", with a 0 behind those of three numbers.

#ifndef RADTEX_CONDENSED_HLSL
#define RADTEX_CONDENSED_HLSL

#include "radtex_shared.hlsl"

#ifndef RADTEX_RANK
#define RADTEX_RANK 2  // "rank": how many weights a texel has, 2 or 6 or 10 ...
#endif

// Clusters of the four texels around `uv`, and their weights in the lookup: `weights[k]` of buckets number k. A texel
// has the bytes of its weights, (byte - 128) / 127, in its pixels, then those of its cluster, low byte first.
int4 radtex_texels(Texture2D image, int2 texels, float2 uv, out float4 weights[1 + RADTEX_RANK]) {
    float2 position = clamp(uv * texels - 0.5, 0.0, texels - 1.0);
    int2 low = int2(position), high = min(low + 1, texels - 1), pixels = int2((RADTEX_RANK + 2) / 4, 1);
    float2 f = position - low;
    weights[0] = float4(1.0 - f.x, f.x, 1.0 - f.x, f.x) * float4(1.0 - f.yy, f.yy);
    float4x4 bytes = 0.0;  // each in [0, 1]; bytes[c] of the four texels
    for (int k = 0; k < RADTEX_RANK; k++) {
        if (k % 4 == 0) {
            int2 next = int2(k / 4, 0);
            bytes = transpose(float4x4(radtex_fetch(image, low * pixels + next, 0),
                                       radtex_fetch(image, int2(high.x, low.y) * pixels + next, 0),
                                       radtex_fetch(image, int2(low.x, high.y) * pixels + next, 0),
                                       radtex_fetch(image, high * pixels + next, 0)));
        }
        weights[1 + k] = weights[0] * (255.0 * bytes[k % 4] - 128.0) / 127.0;
    }
    return int4(255.0 * (bytes[2] + 256.0 * bytes[3]) + 0.5);
}

// Light that leaves along a lobe: its axis, in world space, is reflect(-V, N) for "mirror" and -V for "through".
float3 radtex_condensed_lobe(Texture2D weights, Texture2D ends_xy, Texture2D ends_zs, Texture2D gain, Texture2D rest,
                             float4 ranges[12], int columns, int n, int2 texels, Texture2D surroundings, int2 around,
                             float2 uv, float3 axis) {
    float2 place = radtex_octahedron(axis, n);
    int2 box = n + 2;
    float4 shares[1 + RADTEX_RANK], end = 0.0, scale = 0.0, own = 0.0;
    int4 cluster = radtex_texels(weights, texels, uv, shares);
    float4 left = float4(shares[0] > 0.0);
    while (any(left > 0.0)) {  // texels of one cluster are looked up at once: most often all four
        int first = left.x > 0.0 ? cluster.x : left.y > 0.0 ? cluster.y : left.z > 0.0 ? cluster.z : cluster.w;
        float4 alike = left * float4(cluster == first);
        for (int k = 0; k <= RADTEX_RANK; k++) {
            int tile = first * (1 + RADTEX_RANK) + k, range = k > 0 ? 2 : 0;
            int2 origin = int2(tile % columns, tile / columns) * box;
            float weight = dot(alike, shares[k]);
            float4 ends = float4(radtex_bilinear(ends_xy, origin, box, place).xy,
                                 radtex_bilinear(ends_zs, origin, box, place).xy);
            end += weight * lerp(ranges[range], ranges[range + 1], ends);
            scale += weight * lerp(ranges[range + 4], ranges[range + 5], radtex_bilinear(gain, origin, box, place));
            own += weight * lerp(ranges[range + 8], ranges[range + 9], radtex_bilinear(rest, origin, box, place));
        }
        left -= alike;
    }
    return scale.rgb * radtex_surroundings(surroundings, around, axis + end.xyz, end.w) + own.rgb;
}

// Radiance of a bake with both lobes towards the viewer, in the unit direction V, where the unit normal is N.
float3 radtex_condensed(Texture2D colour, int2 fine, Texture2D irradiance, int2 texels, float3 falloff[RADTEX_FALLOFF],
                        Texture2D mirror_weights, Texture2D mirror_ends_xy, Texture2D mirror_ends_zs,
                        Texture2D mirror_gain, Texture2D mirror_rest, float4 mirror_ranges[12],
                        Texture2D through_weights, Texture2D through_ends_xy, Texture2D through_ends_zs,
                        Texture2D through_gain, Texture2D through_rest, float4 through_ranges[12],
                        int columns, int n, Texture2D surroundings, int2 around, float2 uv, float3 N, float3 V) {
    float3 light = radtex_diffuse(colour, fine, irradiance, texels, falloff, uv, dot(N, V))
        + radtex_condensed_lobe(mirror_weights, mirror_ends_xy, mirror_ends_zs, mirror_gain, mirror_rest,
                                mirror_ranges, columns, n, texels, surroundings, around, uv, reflect(-V, N))
        + radtex_condensed_lobe(through_weights, through_ends_xy, through_ends_zs, through_gain, through_rest,
                                through_ranges, columns, n, texels, surroundings, around, uv, -V);
    return max(light, 0.0);
}

// What a ray finds where it hits the surface, for a runtime that traces: V is radtex_hit_viewer(ray, N).
float3 radtex_condensed_hit(Texture2D colour, int2 fine, Texture2D irradiance, int2 texels,
                            float3 falloff[RADTEX_FALLOFF],
                            Texture2D mirror_weights, Texture2D mirror_ends_xy, Texture2D mirror_ends_zs,
                            Texture2D mirror_gain, Texture2D mirror_rest, float4 mirror_ranges[12],
                            Texture2D through_weights, Texture2D through_ends_xy, Texture2D through_ends_zs,
                            Texture2D through_gain, Texture2D through_rest, float4 through_ranges[12],
                            int columns, int n, Texture2D surroundings, int2 around, float2 uv, float3 N,
                            float3 ray) {
    return radtex_condensed(colour, fine, irradiance, texels, falloff,
                            mirror_weights, mirror_ends_xy, mirror_ends_zs, mirror_gain, mirror_rest, mirror_ranges,
                            through_weights, through_ends_xy, through_ends_zs, through_gain, through_rest,
                            through_ranges, columns, n, surroundings, around, uv, N, radtex_hit_viewer(ray, N));
}

#endif
