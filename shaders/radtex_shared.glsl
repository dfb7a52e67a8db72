// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
//
// Look up a radiance texture in the shared layout: GLSL 330 and later, GLSL ES 300 (WebGL 2) and later.
// Include it, then
//
//     vec3 V = normalize(camera - position), N = normalize(normal);  // in the world space of the bake
//     vec3 light = radtex_diffuse(colour, irradiance, falloff, uv, dot(N, V))
//         + radtex_lobe(mirror_ends, mirror_gain, mirror_rest, n, surroundings, around, uv, reflect(-V, N))
//         + radtex_lobe(through_ends, through_gain, through_rest, n, surroundings, around, uv, -V);
//     light = max(light, 0.0);
//
// without a lobe that the sidecar's "lobes" lack, or with both by radtex_shared. The samplers are
// <name>.radiance.<layer>.exr, scene-linear Rec.709, without mipmaps, uploaded bottom row first (v = 0 is row 0).
// From the sidecar: n is "bucket", `around` is "surroundings" and "levels", `falloff` is "falloff".

#ifdef GL_ES
precision highp float;
precision highp int;
precision highp sampler2D;
#endif

#ifndef RADTEX_FALLOFF
#define RADTEX_FALLOFF 16  // the falloff's points: as many as the sidecar has
#endif

// Bilinear between the pixels of a box at `origin`, never beyond it; `position` in pixels, their centres at a half.
vec4 radtex_bilinear(sampler2D image, ivec2 origin, ivec2 box, vec2 position) {
    position = clamp(position, vec2(0.5), vec2(box) - 0.5);
#ifdef RADTEX_HARDWARE_LINEAR  // one lookup; the sampler must be LINEAR. Its weights have 8 bits
    return textureLod(image, (vec2(origin) + position) / vec2(textureSize(image, 0)), 0.0);
#else
    ivec2 low = ivec2(position - 0.5), high = min(low + 1, box - 1);
    vec2 f = position - 0.5 - vec2(low);
    vec4 below = mix(texelFetch(image, origin + low, 0), texelFetch(image, origin + ivec2(high.x, low.y), 0), f.x);
    vec4 above = mix(texelFetch(image, origin + ivec2(low.x, high.y), 0), texelFetch(image, origin + high, 0), f.x);
    return mix(below, above, f.y);
#endif
}

// Where a direction, of any length, lies on an octahedral picture of n x n cells: in pixels from its border's corner.
vec2 radtex_octahedron(vec3 d, int n) {
    d /= max(abs(d.x) + abs(d.y) + abs(d.z), 1e-30);
    vec2 folded = (1.0 - abs(d.yx)) * vec2(d.x < 0.0 ? -1.0 : 1.0, d.y < 0.0 ? -1.0 : 1.0);
    return ((d.z < 0.0 ? folded : d.xy) * 0.5 + 0.5) * float(n) + 1.0;
}

// The four buckets of n x n cells around `uv`, each at `place`, blended.
vec4 radtex_buckets(sampler2D image, int n, vec2 uv, vec2 place) {
    ivec2 box = ivec2(n + 2), last = textureSize(image, 0) / box - 1;
    vec2 position = clamp(uv * vec2(last + 1) - 0.5, vec2(0.0), vec2(last));
    ivec2 low = ivec2(position), high = min(low + 1, last);
    vec2 f = position - vec2(low);
    vec4 below = mix(radtex_bilinear(image, low * box, box, place),
                     radtex_bilinear(image, ivec2(high.x, low.y) * box, box, place), f.x);
    vec4 above = mix(radtex_bilinear(image, ivec2(low.x, high.y) * box, box, place),
                     radtex_bilinear(image, high * box, box, place), f.x);
    return mix(below, above, f.y);
}

// One level of the surroundings, whose sharpest has `size` x `size` cells; the others lie in a column beside it.
vec3 radtex_level(sampler2D surroundings, int size, int level, vec3 d) {
    int side = max(size >> level, 8);
    ivec2 origin = ivec2(level > 0 ? size + 2 : 0, 0);
    for (int k = 1; k < level; k++) origin.y += max(size >> k, 8) + 2;
    return radtex_bilinear(surroundings, origin, ivec2(side + 2), radtex_octahedron(d, side)).rgb;
}

// Surroundings around the direction d, blurred by a variance in units of the sharpest level's. Each level has four
// times the variance of the one before.
vec3 radtex_surroundings(sampler2D surroundings, ivec2 around, vec3 d, float spread) {
    float level = clamp(0.5 * log2(max(spread, 1.0)), 0.0, float(around.y - 1));
    int low = int(level), high = min(low + 1, around.y - 1);
    vec3 sharper = radtex_level(surroundings, around.x, low, d);
    return mix(sharper, radtex_level(surroundings, around.x, high, d), level - float(low));
}

// Light that leaves every way alike, but for its falloff with the cosine N.V. `fine` and `texels` are the images'
// sizes: an image may be padded on the right and at the top.
vec3 radtex_diffuse(sampler2D colour, ivec2 fine, sampler2D irradiance, ivec2 texels, vec3 falloff[RADTEX_FALLOFF],
                    vec2 uv, float cosine) {
    float place = clamp(cosine * float(RADTEX_FALLOFF) - 0.5, 0.0, float(RADTEX_FALLOFF - 1));
    int low = int(place);
    return radtex_bilinear(colour, ivec2(0), fine, uv * vec2(fine)).rgb
        * radtex_bilinear(irradiance, ivec2(0), texels, uv * vec2(texels)).rgb
        * mix(falloff[low], falloff[min(low + 1, RADTEX_FALLOFF - 1)], place - float(low));
}

// The same of images that are not padded.
vec3 radtex_diffuse(sampler2D colour, sampler2D irradiance, vec3 falloff[RADTEX_FALLOFF], vec2 uv, float cosine) {
    ivec2 fine = textureSize(colour, 0), texels = textureSize(irradiance, 0);
    return radtex_diffuse(colour, fine, irradiance, texels, falloff, uv, cosine);
}

// Light that leaves along a lobe: its axis, in world space, is reflect(-V, N) for "mirror" and -V for "through".
vec3 radtex_lobe(sampler2D ends, sampler2D gain, sampler2D rest, int n, sampler2D surroundings, ivec2 around,
                 vec2 uv, vec3 axis) {
    vec2 place = radtex_octahedron(axis, n);
    vec4 end = radtex_buckets(ends, n, uv, place);
    vec3 met = radtex_surroundings(surroundings, around, axis + end.xyz, end.w);
    return radtex_buckets(gain, n, uv, place).rgb * met + radtex_buckets(rest, n, uv, place).rgb;
}

// The direction V to the viewer whose place a ray takes that hits the surface: `ray` leads to it, unit as N is. One from
// behind N counts as grazing: at a slant a smooth normal turns away from rays that do hit the front. A ray that meets a
// facet's back is no hit.
vec3 radtex_hit_viewer(vec3 ray, vec3 N) {
    vec3 V = max(dot(ray, N), 0.0) * N - ray;
    return V / max(length(V), 1e-30);
}

// Radiance of a bake with both lobes towards the viewer, in the unit direction V, where the unit normal is N.
vec3 radtex_shared(sampler2D colour, sampler2D irradiance, vec3 falloff[RADTEX_FALLOFF],
                   sampler2D mirror_ends, sampler2D mirror_gain, sampler2D mirror_rest,
                   sampler2D through_ends, sampler2D through_gain, sampler2D through_rest, int n,
                   sampler2D surroundings, ivec2 around, vec2 uv, vec3 N, vec3 V) {
    vec3 light = radtex_diffuse(colour, irradiance, falloff, uv, dot(N, V))
        + radtex_lobe(mirror_ends, mirror_gain, mirror_rest, n, surroundings, around, uv, reflect(-V, N))
        + radtex_lobe(through_ends, through_gain, through_rest, n, surroundings, around, uv, -V);
    return max(light, 0.0);
}

// What a ray finds where it hits the surface, for a runtime that traces: V is radtex_hit_viewer(ray, N).
vec3 radtex_shared_hit(sampler2D colour, sampler2D irradiance, vec3 falloff[RADTEX_FALLOFF],
                       sampler2D mirror_ends, sampler2D mirror_gain, sampler2D mirror_rest,
                       sampler2D through_ends, sampler2D through_gain, sampler2D through_rest, int n,
                       sampler2D surroundings, ivec2 around, vec2 uv, vec3 N, vec3 ray) {
    return radtex_shared(colour, irradiance, falloff, mirror_ends, mirror_gain, mirror_rest,
                         through_ends, through_gain, through_rest, n, surroundings, around, uv, N,
                         radtex_hit_viewer(ray, N));
}
