// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Written by RadTex's .ci/build_shaders.py from shaders/source/radtex.c.
//
// Look up a radiance texture: GLSL 330 and later, GLSL ES 300 (WebGL 2) and later, Vulkan's GLSL. Include it, then
//
//     vec3 I = radtex_incidence(camera - position, normal, tangent.xyz, tangent.w);
//     vec4 colour = radtex_sample(atlas, ivec2(W, H), n, uv, I, RADTEX_QUADRILINEAR);
//
// `atlas` is <name>.<kind>.exr: W x H texels of n x n cells, scene-linear Rec.709, alpha premultiplied, uploaded bottom
// row first (v = 0 is row 0). Normal and tangent are MikkTSpace's of the baked UV map, interpolated; tangent.w is the
// bitangent's sign, times the sign of the model matrix's determinant. Far away, either of
//
//     radtex_sample_level(atlas, ivec2(W, H), n, uv, I, radtex_level(uv, ivec2(W, H), levels));
//     radtex_slices(slices, n, uv, I);
//
// with the atlas's mip levels, or with its slices: a texture array, trilinear, clamped to its edge. Before the include,
// `#define RADTEX_PAGES` makes `atlas` an array of pages and `atlas, pages` every first argument of an atlas's lookup;
// `#define RADTEX_HARDWARE_LINEAR` blends cells by the sampler, and `#define RADTEX_NO_DERIVATIVES` leaves radtex_level
// out, for stages other than the fragment's.

#ifdef GL_ES
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp sampler2DArray;
#endif

#ifdef RADTEX_PAGES  // pages = (columns, rows, texels a page across, up)
#define RADTEX_ATLAS sampler2DArray atlas, ivec4 pages
#define RADTEX_PASSED atlas, pages
#else
#define RADTEX_ATLAS sampler2D atlas
#define RADTEX_PASSED atlas
#endif

const int RADTEX_NEAREST = 0;       // one cell: the paper's one lookup
const int RADTEX_LINEAR = 1;        // bilinear inside the bucket
const int RADTEX_QUADRILINEAR = 2;  // four texels, each bilinear inside its bucket

// The vector towards the viewer in the surface frame (T, Bt, N). Vectors in any one space, of any length but zero.
vec3 radtex_incidence(vec3 to_viewer, vec3 normal, vec3 tangent, float bitangent_sign) {
    vec3 N = normalize(normal);
    vec3 T = tangent - N * dot(N, tangent);  // a root less, and less exact along N
    bool degenerate = dot(T, T) <= 1e-8 * dot(tangent, tangent);
    if (degenerate) T = cross(abs(N.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0), N);
    T = normalize(T);
    vec3 Bt = sign(bitangent_sign) * cross(N, T);
    vec3 V = normalize(to_viewer);
    return vec3(dot(V, T), dot(V, Bt), dot(V, N));
}

// Where a unit direction in the frame lies in its bucket: B in [-1, 1]^2. Below the horizon: the rim, at its azimuth.
vec2 radtex_bucket(vec3 I) {
    // |A|^2; equisolid: A = sqrt(2) I.xy / |I + (0,0,1)|, |I| = 1
    float A2 = dot(I.xy, I.xy) / max(1.0 + I.z, 1e-30);
    float widest = max(abs(I.x), abs(I.y));
    return I.xy * (sqrt(min(A2, 1.0)) / max(widest, 1e-30));  // disc to square: A |A| / max(|A.x|, |A.y|)
}

// One texel's cell, which is a pixel of the atlas.
vec4 radtex_cell(RADTEX_ATLAS, ivec2 texel, int n, ivec2 cell, int level) {
#ifdef RADTEX_PAGES
    ivec2 size = ivec2(pages.z >> level, pages.w >> level), page = texel / size;
    ivec2 pixel = (texel - page * size) * n + cell;
    int layer = page.y * pages.x + page.x;
    return texelFetch(atlas, ivec3(pixel, layer), level);
#else
    return texelFetch(atlas, texel * n + cell, level);
#endif
}

#ifdef RADTEX_HARDWARE_LINEAR
// The same between cells, their centres at a half, by the sampler, which must be linear: one lookup. It weighs by 8 bits.
vec4 radtex_between(RADTEX_ATLAS, ivec2 texel, int n, vec2 position, int level) {
#ifdef RADTEX_PAGES
    ivec2 size = ivec2(pages.z >> level, pages.w >> level), page = texel / size;
    vec2 place = (vec2((texel - page * size) * n) + position) / vec2(size * n);
    float layer = float(page.y * pages.x + page.x);
    return textureLod(atlas, vec3(place, layer), float(level));
#else
    return textureLod(atlas, (vec2(texel * n) + position) / vec2(textureSize(atlas, 0) >> level), float(level));
#endif
}
#endif

// One texel's bucket at B, by cells or bilinear between the four around it, never beyond the bucket's own.
vec4 radtex_texel(RADTEX_ATLAS, ivec2 texel, int n, vec2 B, bool blend, int level) {
    ivec2 last = ivec2(n - 1, n - 1);
    float inner = float(n) - 0.5;
    vec2 position = (B + 1.0) * 0.5 * float(n);
    if (!blend) {
        return radtex_cell(RADTEX_PASSED, texel, n, clamp(ivec2(position), ivec2(0, 0), last), level);
    }
    position = clamp(position, vec2(0.5, 0.5), vec2(inner, inner));  // the bleed guard: B in [1/n - 1, 1 - 1/n]
#ifdef RADTEX_HARDWARE_LINEAR
    return radtex_between(RADTEX_PASSED, texel, n, position, level);
#else
    ivec2 low = ivec2(position - 0.5), high = min(low + 1, last);
    vec2 f = position - 0.5 - vec2(low);
    vec4 below = mix(radtex_cell(RADTEX_PASSED, texel, n, low, level),
        radtex_cell(RADTEX_PASSED, texel, n, ivec2(high.x, low.y), level), f.x);
    vec4 above = mix(radtex_cell(RADTEX_PASSED, texel, n, ivec2(low.x, high.y), level),
        radtex_cell(RADTEX_PASSED, texel, n, high, level), f.x);
    return mix(below, above, f.y);
#endif
}

// The four texels around `uv`, each bilinear in its bucket. Level L averages blocks of 2^L x 2^L texels, cell by cell.
vec4 radtex_four(RADTEX_ATLAS, ivec2 texels, int n, vec2 uv, vec2 B, int level) {
    vec2 position = uv * vec2(texels) / float(1 << level) - 0.5;
    ivec2 last = ivec2((texels.x - 1) >> level, (texels.y - 1) >> level);  // ceil(texels / 2^L) - 1
    ivec2 corner = ivec2(floor(position));
    ivec2 low = clamp(corner, ivec2(0, 0), last), high = clamp(corner + 1, ivec2(0, 0), last);
    vec2 f = fract(position);
    vec4 below = mix(radtex_texel(RADTEX_PASSED, low, n, B, true, level),
        radtex_texel(RADTEX_PASSED, ivec2(high.x, low.y), n, B, true, level), f.x);
    vec4 above = mix(radtex_texel(RADTEX_PASSED, ivec2(low.x, high.y), n, B, true, level),
        radtex_texel(RADTEX_PASSED, high, n, B, true, level), f.x);
    return mix(below, above, f.y);
}

// Radiance (rgb, premultiplied) and alpha that leave the surface at `uv` in the direction I of the frame.
vec4 radtex_sample(RADTEX_ATLAS, ivec2 texels, int n, vec2 uv, vec3 I, int mode) {
    vec2 B = radtex_bucket(I);
    if (mode == RADTEX_QUADRILINEAR) return radtex_four(RADTEX_PASSED, texels, n, uv, B, 0);
    ivec2 texel = clamp(ivec2(floor(uv * vec2(texels))), ivec2(0, 0), texels - 1);
    return radtex_texel(RADTEX_PASSED, texel, n, B, mode == RADTEX_LINEAR, 0);
}

// What a ray finds where it hits the surface at `uv`: radtex_sample towards where it comes from. `ray` leads to the
// surface, in the space of the other vectors, of any length but zero. One from behind the normal takes the rim: at a
// slant a smooth normal turns away from rays that do hit the front. A ray that meets a facet's back is no hit.
vec4 radtex_hit(RADTEX_ATLAS, ivec2 texels, int n, vec2 uv, vec3 ray, vec3 normal, vec3 tangent, float bitangent_sign,
                int mode) {
    vec3 I = radtex_incidence(-ray, normal, tangent, bitangent_sign);
    return radtex_sample(RADTEX_PASSED, texels, n, uv, I, mode);
}

// As radtex_sample, quadrilinear, between the mip levels around `level`, which is 0 or more and the atlas's last at most.
vec4 radtex_sample_level(RADTEX_ATLAS, ivec2 texels, int n, vec2 uv, vec3 I, float level) {
    vec2 B = radtex_bucket(I);
    int low = int(level);
    vec4 sharper = radtex_four(RADTEX_PASSED, texels, n, uv, B, low);
    if (level == float(low)) return sharper;  // always so where the texture is magnified
    return mix(sharper, radtex_four(RADTEX_PASSED, texels, n, uv, B, low + 1), level - float(low));
}

#ifndef RADTEX_NO_DERIVATIVES
// The mip level at which a texel is as wide as a pixel of the screen: log2 of the longer derivative, in texels.
float radtex_level(vec2 uv, ivec2 texels, int levels) {
    vec2 across = dFdx(uv) * vec2(texels), up = dFdy(uv) * vec2(texels);
    return min(0.5 * log2(max(max(dot(across, across), dot(up, up)), 1.0)), float(levels - 1));
}
#endif

// The quadrilinear filter of slices: layer q * n + p holds the cell (p, q) of all texels, so that the four cells around
// B take one hardware lookup each, with mipmaps and anisotropy. Never call it where pixels go different ways.
vec4 radtex_slices(sampler2DArray slices, int n, vec2 uv, vec3 I) {
    float inner = float(n) - 0.5;  // the bleed guard
    vec2 position = clamp((radtex_bucket(I) + 1.0) * 0.5 * float(n), vec2(0.5, 0.5), vec2(inner, inner)) - 0.5;
    ivec2 low = ivec2(position), high = min(low + 1, ivec2(n - 1, n - 1));
    vec2 f = position - vec2(low);
    low.y *= n;
    high.y *= n;
    vec4 below = mix(texture(slices, vec3(uv, float(low.y + low.x))),
        texture(slices, vec3(uv, float(low.y + high.x))), f.x);
    vec4 above = mix(texture(slices, vec3(uv, float(high.y + low.x))),
        texture(slices, vec3(uv, float(high.y + high.x))), f.x);
    return mix(below, above, f.y);
}
