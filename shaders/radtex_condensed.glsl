// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
//
// Look up a radiance texture in the condensed form of the shared layout: GLSL 330 and later, GLSL ES 300 (WebGL 2)
// and later. Include it after radtex_shared.glsl, then
//
//     vec3 V = normalize(camera - position), N = normalize(normal);  // in the world space of the bake
//     vec3 light = radtex_diffuse(colour, fine, irradiance, texels, falloff, uv, dot(N, V))
//         + radtex_condensed_lobe(mirror_weights, mirror_ends_xy, mirror_ends_zs, mirror_gain, mirror_rest,
//                                 mirror_ranges, columns, n, texels, surroundings, around, uv, reflect(-V, N))
//         + radtex_condensed_lobe(through_weights, through_ends_xy, through_ends_zs, through_gain, through_rest,
//                                 through_ranges, columns, n, texels, surroundings, around, uv, -V);
//     light = max(light, 0.0);
//
// without a lobe that the sidecar's "lobes" lack, or with both by radtex_condensed. The samplers are
// <name>.radiance.<layer>.dds, uploaded as they are: linear (never sRGB), without mipmaps. From the sidecar: n is
// "bucket", `fine` is "colour", `texels` is "texels", `around` is "surroundings" and "levels", `falloff` is
// "falloff". Of "condensed", `columns` is "columns"; a lobe's `ranges` are the four lists of its "ends", then of its
// "gain", then of its "rest", with a 0 behind those of three numbers.

#ifndef RADTEX_RANK
#define RADTEX_RANK 2  // "rank": how many weights a texel has, 2 or 6 or 10 ...
#endif

// Clusters of the four texels around `uv`, and their weights in the lookup: `weights[k]` of buckets number k. A texel
// has the bytes of its weights, (byte - 128) / 127, in its pixels, then those of its cluster, low byte first.
ivec4 radtex_texels(sampler2D image, ivec2 texels, vec2 uv, out vec4 weights[1 + RADTEX_RANK]) {
    vec2 position = clamp(uv * vec2(texels) - 0.5, vec2(0.0), vec2(texels - 1));
    ivec2 low = ivec2(position), high = min(low + 1, texels - 1), pixels = ivec2((RADTEX_RANK + 2) / 4, 1);
    vec2 f = position - vec2(low);
    weights[0] = vec4(1.0 - f.x, f.x, 1.0 - f.x, f.x) * vec4(1.0 - f.yy, f.yy);
    mat4 bytes;  // each in [0, 1]; bytes[c] of the four texels
    for (int k = 0; k < RADTEX_RANK; k++) {
        if (k % 4 == 0) {
            ivec2 next = ivec2(k / 4, 0);
            bytes = transpose(mat4(texelFetch(image, low * pixels + next, 0),
                                   texelFetch(image, ivec2(high.x, low.y) * pixels + next, 0),
                                   texelFetch(image, ivec2(low.x, high.y) * pixels + next, 0),
                                   texelFetch(image, high * pixels + next, 0)));
        }
        weights[1 + k] = weights[0] * (255.0 * bytes[k % 4] - 128.0) / 127.0;
    }
    return ivec4(255.0 * (bytes[2] + 256.0 * bytes[3]) + 0.5);
}

// Light that leaves along a lobe: its axis, in world space, is reflect(-V, N) for "mirror" and -V for "through".
vec3 radtex_condensed_lobe(sampler2D weights, sampler2D ends_xy, sampler2D ends_zs, sampler2D gain, sampler2D rest,
                           vec4 ranges[12], int columns, int n, ivec2 texels, sampler2D surroundings, ivec2 around,
                           vec2 uv, vec3 axis) {
    vec2 place = radtex_octahedron(axis, n);
    ivec2 box = ivec2(n + 2);
    vec4 shares[1 + RADTEX_RANK], end = vec4(0.0), scale = vec4(0.0), own = vec4(0.0);
    ivec4 cluster = radtex_texels(weights, texels, uv, shares);
    vec4 left = vec4(greaterThan(shares[0], vec4(0.0)));
    while (any(greaterThan(left, vec4(0.0)))) {  // texels of one cluster are looked up at once: most often all four
        int first = left.x > 0.0 ? cluster.x : left.y > 0.0 ? cluster.y : left.z > 0.0 ? cluster.z : cluster.w;
        vec4 alike = left * vec4(equal(cluster, ivec4(first)));
        for (int k = 0; k <= RADTEX_RANK; k++) {
            int tile = first * (1 + RADTEX_RANK) + k, range = k > 0 ? 2 : 0;
            ivec2 origin = ivec2(tile % columns, tile / columns) * box;
            float weight = dot(alike, shares[k]);
            vec4 ends = vec4(radtex_bilinear(ends_xy, origin, box, place).xy,
                             radtex_bilinear(ends_zs, origin, box, place).xy);
            end += weight * mix(ranges[range], ranges[range + 1], ends);
            scale += weight * mix(ranges[range + 4], ranges[range + 5], radtex_bilinear(gain, origin, box, place));
            own += weight * mix(ranges[range + 8], ranges[range + 9], radtex_bilinear(rest, origin, box, place));
        }
        left -= alike;
    }
    return scale.rgb * radtex_surroundings(surroundings, around, axis + end.xyz, end.w) + own.rgb;
}

// Radiance of a bake with both lobes towards the viewer, in the unit direction V, where the unit normal is N.
vec3 radtex_condensed(sampler2D colour, ivec2 fine, sampler2D irradiance, ivec2 texels, vec3 falloff[RADTEX_FALLOFF],
                      sampler2D mirror_weights, sampler2D mirror_ends_xy, sampler2D mirror_ends_zs,
                      sampler2D mirror_gain, sampler2D mirror_rest, vec4 mirror_ranges[12],
                      sampler2D through_weights, sampler2D through_ends_xy, sampler2D through_ends_zs,
                      sampler2D through_gain, sampler2D through_rest, vec4 through_ranges[12],
                      int columns, int n, sampler2D surroundings, ivec2 around, vec2 uv, vec3 N, vec3 V) {
    vec3 light = radtex_diffuse(colour, fine, irradiance, texels, falloff, uv, dot(N, V))
        + radtex_condensed_lobe(mirror_weights, mirror_ends_xy, mirror_ends_zs, mirror_gain, mirror_rest,
                                mirror_ranges, columns, n, texels, surroundings, around, uv, reflect(-V, N))
        + radtex_condensed_lobe(through_weights, through_ends_xy, through_ends_zs, through_gain, through_rest,
                                through_ranges, columns, n, texels, surroundings, around, uv, -V);
    return max(light, 0.0);
}

// What a ray finds where it hits the surface, for a runtime that traces: V is radtex_hit_viewer(ray, N).
vec3 radtex_condensed_hit(sampler2D colour, ivec2 fine, sampler2D irradiance, ivec2 texels,
                          vec3 falloff[RADTEX_FALLOFF],
                          sampler2D mirror_weights, sampler2D mirror_ends_xy, sampler2D mirror_ends_zs,
                          sampler2D mirror_gain, sampler2D mirror_rest, vec4 mirror_ranges[12],
                          sampler2D through_weights, sampler2D through_ends_xy, sampler2D through_ends_zs,
                          sampler2D through_gain, sampler2D through_rest, vec4 through_ranges[12],
                          int columns, int n, sampler2D surroundings, ivec2 around, vec2 uv, vec3 N, vec3 ray) {
    return radtex_condensed(colour, fine, irradiance, texels, falloff,
                            mirror_weights, mirror_ends_xy, mirror_ends_zs, mirror_gain, mirror_rest, mirror_ranges,
                            through_weights, through_ends_xy, through_ends_zs, through_gain, through_rest,
                            through_ranges, columns, n, surroundings, around, uv, N, radtex_hit_viewer(ray, N));
}
