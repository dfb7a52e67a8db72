// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
//
// Look up a radiance texture in the condensed form of the shared layout: WGSL. Put it behind radtex_shared.wgsl, then
//
//     let V = normalize(camera - position); let N = normalize(normal);  // in the world space of the bake
//     var light = radtex_diffuse_padded(colour, fine, irradiance, texels, filtering, falloff, uv, dot(N, V))
//         + radtex_condensed_lobe(mirror_weights, mirror_ends_xy, mirror_ends_zs, mirror_gain, mirror_rest, filtering,
//                                 mirror_ranges, columns, n, texels, surroundings, around, uv, reflect(-V, N))
//         + radtex_condensed_lobe(through_weights, through_ends_xy, through_ends_zs, through_gain, through_rest,
//                                 filtering, through_ranges, columns, n, texels, surroundings, around, uv, -V);
//     light = max(light, vec3f(0.0));
//
// without a lobe that the sidecar's "lobes" lack, or with both by radtex_condensed. The textures are
// <name>.radiance.<layer>.dds, uploaded as they are: linear (never sRGB), without mipmaps. From the sidecar: n is
// "bucket", `fine` is "colour", `texels` is "texels", `around` is "surroundings" and "levels", `falloff` is
// "falloff". Of "condensed", `columns` is "columns"; a lobe's `ranges` are the four lists of its "ends", then of its
// "gain", then of its "rest", with a 0 behind those of three numbers.

const RADTEX_RANK: i32 = 2;  // "rank": how many weights a texel has, 2 or 6 or 10 ...
alias RadtexRanges = array<vec4f, 12>;

// Clusters of the four texels around a place, and their weights in the lookup: `weights[k]` of buckets number k.
struct RadtexShares { cluster: vec4i, weights: array<vec4f, 1 + RADTEX_RANK> }

// A texel has the bytes of its weights, (byte - 128) / 127, in its pixels, then those of its cluster, low byte first.
fn radtex_shares(image: texture_2d<f32>, texels: vec2i, uv: vec2f) -> RadtexShares {
    let position = clamp(uv * vec2f(texels) - 0.5, vec2f(0.0), vec2f(texels - 1));
    let low = vec2i(position);
    let high = min(low + 1, texels - 1);
    let pixels = vec2i((RADTEX_RANK + 2) / 4, 1);
    let f = position - vec2f(low);
    var shares: RadtexShares;
    shares.weights[0] = vec4f(1.0 - f.x, f.x, 1.0 - f.x, f.x) * vec4f(1.0 - f.yy, f.yy);
    var bytes: mat4x4f;  // each in [0, 1]; bytes[c] of the four texels
    for (var k = 0; k < RADTEX_RANK; k++) {
        if k % 4 == 0 {
            let next = vec2i(k / 4, 0);
            bytes = transpose(mat4x4f(textureLoad(image, low * pixels + next, 0),
                                      textureLoad(image, vec2i(high.x, low.y) * pixels + next, 0),
                                      textureLoad(image, vec2i(low.x, high.y) * pixels + next, 0),
                                      textureLoad(image, high * pixels + next, 0)));
        }
        shares.weights[1 + k] = shares.weights[0] * (255.0 * bytes[k % 4] - 128.0) / 127.0;
    }
    shares.cluster = vec4i(255.0 * (bytes[2] + 256.0 * bytes[3]) + 0.5);
    return shares;
}

// Light that leaves along a lobe: its axis, in world space, is reflect(-V, N) for "mirror" and -V for "through".
fn radtex_condensed_lobe(weights: texture_2d<f32>, ends_xy: texture_2d<f32>, ends_zs: texture_2d<f32>,
                         gain: texture_2d<f32>, rest: texture_2d<f32>, filtering: sampler, ranges: RadtexRanges,
                         columns: i32, n: i32, texels: vec2i, surroundings: texture_2d<f32>, around: vec2i,
                         uv: vec2f, axis: vec3f) -> vec3f {
    let place = radtex_octahedron(axis, n);
    let box = vec2i(n + 2);
    var end = vec4f(0.0);
    var scale = vec4f(0.0);
    var own = vec4f(0.0);
    var shares = radtex_shares(weights, texels, uv);
    let cluster = shares.cluster;
    var left = vec4f(shares.weights[0] > vec4f(0.0));
    while any(left > vec4f(0.0)) {  // texels of one cluster are looked up at once: most often all four
        var first = cluster.w;
        if left.x > 0.0 { first = cluster.x; } else if left.y > 0.0 { first = cluster.y; } else if left.z > 0.0 {
            first = cluster.z;
        }
        let alike = left * vec4f(cluster == vec4i(first));
        for (var k = 0; k <= RADTEX_RANK; k++) {
            let tile = first * (1 + RADTEX_RANK) + k;
            let range = select(0, 2, k > 0);
            let origin = vec2i(tile % columns, tile / columns) * box;
            let weight = dot(alike, shares.weights[k]);
            let ends = vec4f(radtex_bilinear(ends_xy, filtering, origin, box, place).xy,
                             radtex_bilinear(ends_zs, filtering, origin, box, place).xy);
            end += weight * mix(ranges[range], ranges[range + 1], ends);
            scale += weight * mix(ranges[range + 4], ranges[range + 5],
                                  radtex_bilinear(gain, filtering, origin, box, place));
            own += weight * mix(ranges[range + 8], ranges[range + 9],
                                radtex_bilinear(rest, filtering, origin, box, place));
        }
        left -= alike;
    }
    return scale.rgb * radtex_surroundings(surroundings, filtering, around, axis + end.xyz, end.w) + own.rgb;
}

// Radiance of a bake with both lobes towards the viewer, in the unit direction V, where the unit normal is N.
fn radtex_condensed(colour: texture_2d<f32>, fine: vec2i, irradiance: texture_2d<f32>, texels: vec2i,
                    filtering: sampler, falloff: RadtexFalloff,
                    mirror_weights: texture_2d<f32>, mirror_ends_xy: texture_2d<f32>, mirror_ends_zs: texture_2d<f32>,
                    mirror_gain: texture_2d<f32>, mirror_rest: texture_2d<f32>, mirror_ranges: RadtexRanges,
                    through_weights: texture_2d<f32>, through_ends_xy: texture_2d<f32>,
                    through_ends_zs: texture_2d<f32>, through_gain: texture_2d<f32>, through_rest: texture_2d<f32>,
                    through_ranges: RadtexRanges, columns: i32, n: i32, surroundings: texture_2d<f32>, around: vec2i,
                    uv: vec2f, N: vec3f, V: vec3f) -> vec3f {
    let light = radtex_diffuse_padded(colour, fine, irradiance, texels, filtering, falloff, uv, dot(N, V))
        + radtex_condensed_lobe(mirror_weights, mirror_ends_xy, mirror_ends_zs, mirror_gain, mirror_rest, filtering,
                                mirror_ranges, columns, n, texels, surroundings, around, uv, reflect(-V, N))
        + radtex_condensed_lobe(through_weights, through_ends_xy, through_ends_zs, through_gain, through_rest,
                                filtering, through_ranges, columns, n, texels, surroundings, around, uv, -V);
    return max(light, vec3f(0.0));
}

// What a ray finds where it hits the surface, for a runtime that traces: V is radtex_hit_viewer(ray, N).
fn radtex_condensed_hit(colour: texture_2d<f32>, fine: vec2i, irradiance: texture_2d<f32>, texels: vec2i,
                        filtering: sampler, falloff: RadtexFalloff,
                        mirror_weights: texture_2d<f32>, mirror_ends_xy: texture_2d<f32>,
                        mirror_ends_zs: texture_2d<f32>, mirror_gain: texture_2d<f32>, mirror_rest: texture_2d<f32>,
                        mirror_ranges: RadtexRanges, through_weights: texture_2d<f32>,
                        through_ends_xy: texture_2d<f32>, through_ends_zs: texture_2d<f32>,
                        through_gain: texture_2d<f32>, through_rest: texture_2d<f32>, through_ranges: RadtexRanges,
                        columns: i32, n: i32, surroundings: texture_2d<f32>, around: vec2i, uv: vec2f, N: vec3f,
                        ray: vec3f) -> vec3f {
    return radtex_condensed(colour, fine, irradiance, texels, filtering, falloff,
                            mirror_weights, mirror_ends_xy, mirror_ends_zs, mirror_gain, mirror_rest, mirror_ranges,
                            through_weights, through_ends_xy, through_ends_zs, through_gain, through_rest,
                            through_ranges, columns, n, surroundings, around, uv, N, radtex_hit_viewer(ray, N));
}
