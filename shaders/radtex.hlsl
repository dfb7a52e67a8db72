// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Written by RadTex's .ci/build_shaders.py from shaders/source/radtex.c.
//
// Look up a radiance texture: HLSL, shader model 5 and later. Include it, then
//
//     float3 I = radtex_incidence(camera - position, normal, tangent.xyz, tangent.w);
//     float4 colour = radtex_sample(atlas, int2(W, H), n, uv, I, RADTEX_QUADRILINEAR);
//
// `atlas` is W x H texels of n x n cells, scene-linear Rec.709 (never sRGB), alpha premultiplied. In `uv`, v = 0 is the
// bottom, as in Blender. Normal and tangent are MikkTSpace's of the baked UV map, interpolated; tangent.w is the
// bitangent's sign, times the sign of the model matrix's determinant. Far away, in a pixel shader, either of
//
//     radtex_sample_level(atlas, int2(W, H), n, uv, I, radtex_level(uv, int2(W, H), levels));
//     radtex_slices(slices, trilinear_clamp, n, uv, I);
//
// with the atlas's mip levels, or with its slices. Before the include, `#define RADTEX_TOP_DOWN` if row 0 of the
// textures is the top (an EXR in Unreal) and not the bottom (KTX2, DDS, anything in Unity); `#define RADTEX_PAGES`
// makes `atlas` a Texture2DArray of pages and `atlas, pages` every first argument of an atlas's lookup; and
// `#define RADTEX_HARDWARE_LINEAR linear_clamp` blends cells by the SamplerState of that name.

#ifndef RADTEX_HLSL
#define RADTEX_HLSL

#ifdef RADTEX_PAGES  // pages = (columns, rows, texels a page across, up)
#define RADTEX_ATLAS Texture2DArray atlas, int4 pages
#define RADTEX_PASSED atlas, pages
#else
#define RADTEX_ATLAS Texture2D atlas
#define RADTEX_PASSED atlas
#endif

static const int RADTEX_NEAREST = 0;       // one cell: the paper's one lookup
static const int RADTEX_LINEAR = 1;        // bilinear inside the bucket
static const int RADTEX_QUADRILINEAR = 2;  // four texels, each bilinear inside its bucket

// The size of a mip level in pixels: GLSL's textureSize. Each level is exactly half the one before.
int2 radtex_size(Texture2D image, int level) {
    uint width, height, levels;
    image.GetDimensions(0, width, height, levels);
    return int2(width, height) >> level;
}

// A pixel and a texture coordinate, counted from the bottom, as the texture has them.
int2 radtex_row(int2 pixel, int2 size) {
#ifdef RADTEX_TOP_DOWN
    pixel.y = size.y - 1 - pixel.y;
#endif
    return pixel;
}

float2 radtex_upwards(float2 uv) {
#ifdef RADTEX_TOP_DOWN
    uv.y = 1.0 - uv.y;
#endif
    return uv;
}

// The vector towards the viewer in the surface frame (T, Bt, N). Vectors in any one space, of any length but zero.
float3 radtex_incidence(float3 to_viewer, float3 normal, float3 tangent, float bitangent_sign) {
    float3 N = normalize(normal);
    float3 T = tangent / max(length(tangent), 1e-30);
    T -= N * dot(N, T);
    bool degenerate = dot(T, T) < 1e-8;
    if (degenerate) T = cross(abs(N.z) < 0.9 ? float3(0.0, 0.0, 1.0) : float3(1.0, 0.0, 0.0), N);
    T = normalize(T);
    float3 Bt = sign(bitangent_sign) * cross(N, T);
    float3 V = normalize(to_viewer);
    return float3(dot(V, T), dot(V, Bt), dot(V, N));
}

// Where a unit direction in the frame lies in its bucket: B in [-1, 1]^2. Below the horizon: the rim, at its azimuth.
float2 radtex_bucket(float3 I) {
    // |A|^2; equisolid: A = sqrt(2) I.xy / |I + (0,0,1)|, |I| = 1
    float A2 = dot(I.xy, I.xy) / max(1.0 + I.z, 1e-30);
    float widest = max(abs(I.x), abs(I.y));
    return I.xy * (sqrt(min(A2, 1.0)) / max(widest, 1e-30));  // disc to square: A |A| / max(|A.x|, |A.y|)
}

// One texel's cell, which is a pixel of the atlas.
float4 radtex_cell(RADTEX_ATLAS, int2 texel, int n, int2 cell, int level) {
#ifdef RADTEX_PAGES
    int2 size = int2(pages.z >> level, pages.w >> level), page = texel / size;
    int2 pixel = (texel - page * size) * n + cell;
    int layer = page.y * pages.x + page.x;
    return atlas.Load(int4(radtex_row(pixel, size * n), layer, level));
#else
    return atlas.Load(int3(radtex_row(texel * n + cell, radtex_size(atlas, level)), level));
#endif
}

#ifdef RADTEX_HARDWARE_LINEAR
// The same between cells, their centres at a half, by the sampler, which must be linear: one lookup. It weighs by 8 bits.
float4 radtex_between(RADTEX_ATLAS, int2 texel, int n, float2 position, int level) {
#ifdef RADTEX_PAGES
    int2 size = int2(pages.z >> level, pages.w >> level), page = texel / size;
    float2 place = (float2((texel - page * size) * n) + position) / float2(size * n);
    float layer = float(page.y * pages.x + page.x);
    return atlas.SampleLevel(RADTEX_HARDWARE_LINEAR, float3(radtex_upwards(place), layer), float(level));
#else
    float2 place = (float2(texel * n) + position) / float2(radtex_size(atlas, level));
    return atlas.SampleLevel(RADTEX_HARDWARE_LINEAR, radtex_upwards(place), float(level));
#endif
}
#endif

// One texel's bucket at B, by cells or bilinear between the four around it, never beyond the bucket's own.
float4 radtex_texel(RADTEX_ATLAS, int2 texel, int n, float2 B, bool blend, int level) {
    int2 last = int2(n - 1, n - 1);
    float inner = float(n) - 0.5;
    float2 position = (B + 1.0) * 0.5 * float(n);
    if (!blend) {
        return radtex_cell(RADTEX_PASSED, texel, n, clamp(int2(position), int2(0, 0), last), level);
    }
    position = clamp(position, float2(0.5, 0.5), float2(inner, inner));  // the bleed guard: B in [1/n - 1, 1 - 1/n]
#ifdef RADTEX_HARDWARE_LINEAR
    return radtex_between(RADTEX_PASSED, texel, n, position, level);
#else
    int2 low = int2(position - 0.5), high = min(low + 1, last);
    float2 f = position - 0.5 - float2(low);
    float4 below = lerp(radtex_cell(RADTEX_PASSED, texel, n, low, level),
        radtex_cell(RADTEX_PASSED, texel, n, int2(high.x, low.y), level), f.x);
    float4 above = lerp(radtex_cell(RADTEX_PASSED, texel, n, int2(low.x, high.y), level),
        radtex_cell(RADTEX_PASSED, texel, n, high, level), f.x);
    return lerp(below, above, f.y);
#endif
}

// The four texels around `uv`, each bilinear in its bucket. Level L averages blocks of 2^L x 2^L texels, cell by cell.
float4 radtex_four(RADTEX_ATLAS, int2 texels, int n, float2 uv, float2 B, int level) {
    float2 position = uv * float2(texels) / float(1 << level) - 0.5;
    int2 last = int2((texels.x - 1) >> level, (texels.y - 1) >> level);  // ceil(texels / 2^L) - 1
    int2 corner = int2(floor(position));
    int2 low = clamp(corner, int2(0, 0), last), high = clamp(corner + 1, int2(0, 0), last);
    float2 f = frac(position);
    float4 below = lerp(radtex_texel(RADTEX_PASSED, low, n, B, true, level),
        radtex_texel(RADTEX_PASSED, int2(high.x, low.y), n, B, true, level), f.x);
    float4 above = lerp(radtex_texel(RADTEX_PASSED, int2(low.x, high.y), n, B, true, level),
        radtex_texel(RADTEX_PASSED, high, n, B, true, level), f.x);
    return lerp(below, above, f.y);
}

// Radiance (rgb, premultiplied) and alpha that leave the surface at `uv` in the direction I of the frame.
float4 radtex_sample(RADTEX_ATLAS, int2 texels, int n, float2 uv, float3 I, int mode) {
    float2 B = radtex_bucket(I);
    if (mode == RADTEX_QUADRILINEAR) return radtex_four(RADTEX_PASSED, texels, n, uv, B, 0);
    int2 texel = clamp(int2(floor(uv * float2(texels))), int2(0, 0), texels - 1);
    return radtex_texel(RADTEX_PASSED, texel, n, B, mode == RADTEX_LINEAR, 0);
}

// What a ray finds where it hits the surface at `uv`: radtex_sample towards where it comes from. `ray` leads to the
// surface, in the space of the other vectors, of any length but zero. One from behind the normal takes the rim: at a
// slant a smooth normal turns away from rays that do hit the front. A ray that meets a facet's back is no hit.
float4 radtex_hit(RADTEX_ATLAS, int2 texels, int n, float2 uv, float3 ray, float3 normal, float3 tangent,
                  float bitangent_sign, int mode) {
    float3 I = radtex_incidence(-ray, normal, tangent, bitangent_sign);
    return radtex_sample(RADTEX_PASSED, texels, n, uv, I, mode);
}

// As radtex_sample, quadrilinear, between the mip levels around `level`, which is 0 or more and the atlas's last at most.
float4 radtex_sample_level(RADTEX_ATLAS, int2 texels, int n, float2 uv, float3 I, float level) {
    float2 B = radtex_bucket(I);
    int low = int(level);
    float4 sharper = radtex_four(RADTEX_PASSED, texels, n, uv, B, low);
    if (level == float(low)) return sharper;  // always so where the texture is magnified
    return lerp(sharper, radtex_four(RADTEX_PASSED, texels, n, uv, B, low + 1), level - float(low));
}

// The mip level at which a texel is as wide as a pixel of the screen: log2 of the longer derivative, in texels.
float radtex_level(float2 uv, int2 texels, int levels) {
    float2 across = ddx(uv) * float2(texels), up = ddy(uv) * float2(texels);
    return min(0.5 * log2(max(max(dot(across, across), dot(up, up)), 1.0)), float(levels - 1));
}

// The quadrilinear filter of slices: layer q * n + p holds the cell (p, q) of all texels, so that the four cells around
// B take one hardware lookup each, with mipmaps and anisotropy. Never call it where pixels go different ways.
float4 radtex_slices(Texture2DArray slices, SamplerState filtering, int n, float2 uv, float3 I) {
    float inner = float(n) - 0.5;  // the bleed guard
    float2 position = clamp((radtex_bucket(I) + 1.0) * 0.5 * float(n), float2(0.5, 0.5), float2(inner, inner)) - 0.5;
    int2 low = int2(position), high = min(low + 1, int2(n - 1, n - 1));
    float2 f = position - float2(low);
    low.y *= n;
    high.y *= n;
    float2 at = radtex_upwards(uv);
    float4 below = lerp(slices.Sample(filtering, float3(at, low.y + low.x)),
        slices.Sample(filtering, float3(at, low.y + high.x)), f.x);
    float4 above = lerp(slices.Sample(filtering, float3(at, high.y + low.x)),
        slices.Sample(filtering, float3(at, high.y + high.x)), f.x);
    return lerp(below, above, f.y);
}

#endif
