// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Written by RadTex's .ci/build_shaders.py from shaders/source/radtex_shadow.c.
//
// Look up shadows in one bit a cell: HLSL, shader model 5 and later. Include radtex.hlsl, then this, then
//
//     RadtexShadow here = radtex_shadow(bits, int2(W, H), uv);
//     float3 L = radtex_incidence(to_light, normal, tangent.xyz, tangent.w);
//     light = colour * max(L.z, 0.0) * radtex_visible(here, n, L);                        // a light without a size
//     light = colour * radtex_sun(here, n, frame, to_sun, angle, 32);                     // with one: cosine included
//     light = colour * radtex_rectangle(here, n, frame, position, corner, side, up, 32);
//
// `bits` is <name>.shadow.exr, bottom row first (v = 0 is row 0; else `#define RADTEX_TOP_DOWN`), never filtered: up
// to 8 x 8 cells an R32G32_UINT texture of W x H pixels. With more cells, `#define RADTEX_SHADOW_LAYERS` makes it an
// array, layer k holding the words 2 k and 2 k + 1. Bit q * n + p, the least significant first, is 1 where the direction
// of the cell (p, q) is blocked. `frame` comes from radtex_frame: its rows are T, Bt and N, in the space of all other
// vectors.

#ifndef RADTEX_SHADOW_HLSL
#define RADTEX_SHADOW_HLSL

#ifdef RADTEX_SHADOW_LAYERS
#define RADTEX_BITS Texture2DArray<uint2>
#else
#define RADTEX_BITS Texture2D<uint2>
#endif

// The nine texels around a place, and how far that is from the middle one's middle, -1/2 to 1/2.
struct RadtexShadow {
    float2 beyond;
#ifdef RADTEX_SHADOW_LAYERS
    int2 nearest, texels;
#else
    uint2 words[9];
#endif
};

#ifdef RADTEX_SHADOW_LAYERS
#define RADTEX_SHADOW RADTEX_BITS bits, RadtexShadow here
#define RADTEX_HERE bits, here
#else
#define RADTEX_SHADOW RadtexShadow here
#define RADTEX_HERE here
#endif

// The texel t, of nine, around the nearest.
int2 radtex_shadow_texel(int2 nearest, int2 texels, int t) {
    return clamp(nearest + int2(int(uint(t) % 3u), int(uint(t) / 3u)) - 1, int2(0, 0), texels - 1);
}

#ifdef RADTEX_SHADOW_LAYERS
// The word of a texel that has the bit k.
uint radtex_bits(RADTEX_BITS bits, int2 texels, int2 texel, int k) {
    uint2 words = bits.Load(int4(radtex_row(texel, texels), k >> 6, 0));
    return (k & 32) == 0 ? words.x : words.y;
}
#else
// The two words of a texel.
uint2 radtex_bits(RADTEX_BITS bits, int2 texels, int2 texel) {
    return bits.Load(int3(radtex_row(texel, texels), 0));
}
#endif

// What every lookup at `uv` reads, for however many lights. With layers, `bits` also is each lookup's first argument.
RadtexShadow radtex_shadow(RADTEX_BITS bits, int2 texels, float2 uv) {
    float2 position = uv * float2(texels), corner = floor(position);
    RadtexShadow here;
    here.beyond = position - corner - 0.5;
#ifdef RADTEX_SHADOW_LAYERS
    here.nearest = int2(corner);
    here.texels = texels;
#else
    [unroll] for (int t = 0; t < 9; t++) {
        here.words[t] = radtex_bits(bits, texels, radtex_shadow_texel(int2(corner), texels, t));
    }
#endif
    return here;
}

// 1 where the cell k of texel t, of nine, is open, 0 where it is blocked.
float radtex_open(RADTEX_SHADOW, int t, int k) {
#ifdef RADTEX_SHADOW_LAYERS
    uint word = radtex_bits(bits, here.texels, radtex_shadow_texel(here.nearest, here.texels, t), k);
#else
    uint2 words = here.words[t];
    uint word = (k & 32) == 0 ? words.x : words.y;
#endif
    return ((word >> uint(k & 31)) & 1u) == 0u ? 1.0 : 0.0;
}

// The same between the four texels around the place.
float radtex_open_here(RADTEX_SHADOW, int k) {
    int x = here.beyond.x < 0.0 ? -1 : 1, y = here.beyond.y < 0.0 ? -3 : 3;
    float2 f = abs(here.beyond);
    return lerp(lerp(radtex_open(RADTEX_HERE, 4, k), radtex_open(RADTEX_HERE, 4 + x, k), f.x),
        lerp(radtex_open(RADTEX_HERE, 4 + y, k), radtex_open(RADTEX_HERE, 4 + x + y, k), f.x), f.y);
}

// Where a direction of the frame lies among the middles of n x n cells.
float2 radtex_between_cells(int n, float3 I) {
    float inner = float(n) - 0.5;
    return clamp((radtex_bucket(I) + 1.0) * 0.5 * float(n), float2(0.5, 0.5), float2(inner, inner)) - 0.5;
}

// How much of a light in the unit direction I of the frame is seen, 0 to 1: texels and cells are blended.
float radtex_visible(RADTEX_SHADOW, int n, float3 I) {
    float2 position = radtex_between_cells(n, I);
    int2 low = int2(position), high = min(low + 1, int2(n - 1, n - 1));
    float2 f = position - float2(low);
    float below = lerp(radtex_open_here(RADTEX_HERE, low.y * n + low.x),
        radtex_open_here(RADTEX_HERE, low.y * n + high.x), f.x);
    float above = lerp(radtex_open_here(RADTEX_HERE, high.y * n + low.x),
        radtex_open_here(RADTEX_HERE, high.y * n + high.x), f.x);
    return lerp(below, above, f.y);
}

// What each of many points of a light looks up, and how.
#ifdef RADTEX_SHADOW_LAYERS
#define RADTEX_POINTS RADTEX_SHADOW
#define RADTEX_POINT RADTEX_HERE

// The cell that holds I: more than 8 x 8 cells are fine enough for a light's own size to blend them.
float radtex_visible_point(RADTEX_POINTS, int n, float3 I) {
    int2 cell = int2((radtex_bucket(I) + 1.0) * 0.5 * float(n));
    cell = clamp(cell, int2(0, 0), int2(n - 1, n - 1));
    return radtex_open_here(RADTEX_HERE, cell.y * n + cell.x);
}
#else
#define RADTEX_POINTS float radtex_openness[64]
#define RADTEX_POINT radtex_openness

// How open each cell is in the mean of nine texels, read once for all points.
void radtex_blend(RadtexShadow here, out float radtex_openness[64]) {
    float3 across = float3(0.5 - here.beyond.x, 1.0, 0.5 + here.beyond.x) * 0.5;
    float3 up = float3(0.5 - here.beyond.y, 1.0, 0.5 + here.beyond.y) * 0.5;
    for (int k = 0; k < 64; k++) {
        float open = 0.0;
        [unroll] for (int y = 0; y < 3; y++) {
            [unroll] for (int x = 0; x < 3; x++) open += across[x] * up[y] * radtex_open(here, 3 * y + x, k);
        }
        radtex_openness[k] = open;
    }
}

// Between four cells, and sharpened: a shadow's edge lies where so wide a blend is about a half.
float radtex_visible_point(RADTEX_POINTS, int n, float3 I) {
    float2 position = radtex_between_cells(n, I);
    int2 low = int2(position), high = min(low + 1, int2(n - 1, n - 1));
    float2 f = position - float2(low);
    float below = lerp(radtex_openness[low.y * n + low.x], radtex_openness[low.y * n + high.x], f.x);
    float above = lerp(radtex_openness[high.y * n + low.x], radtex_openness[high.y * n + high.x], f.x);
    return clamp(2.0 * lerp(below, above, f.y) - 0.5, 0.0, 1.0);
}
#endif

// The frame (T, Bt, N) as rows: what radtex_incidence brings vectors into.
float3x3 radtex_frame(float3 normal, float3 tangent, float bitangent_sign) {
    float3 x = radtex_incidence(float3(1.0, 0.0, 0.0), normal, tangent, bitangent_sign);
    float3 y = radtex_incidence(float3(0.0, 1.0, 0.0), normal, tangent, bitangent_sign);
    float3 z = radtex_incidence(float3(0.0, 0.0, 1.0), normal, tangent, bitangent_sign);
    return transpose(float3x3(x, y, z));
}

float3 radtex_in_frame(float3 direction, float3x3 frame) {
    return mul(frame, direction);
}

// A sun's irradiance over that which it has at a right angle, from `count` points, even on its disc, `angle` wide in
// radians.
float radtex_sun(RADTEX_SHADOW, int n, float3x3 frame, float3 to_sun, float angle, int count) {
#ifndef RADTEX_SHADOW_LAYERS
    float radtex_openness[64];
    radtex_blend(here, radtex_openness);
#endif
    float3 axis = normalize(to_sun);
    float3 across = normalize(cross(abs(axis.z) < 0.9 ? float3(0.0, 0.0, 1.0) : float3(1.0, 0.0, 0.0), axis));
    float3 up = cross(axis, across);
    float rim = cos(0.5 * angle), sum = 0.0;
    for (int k = 0; k < count; k++) {
        float share = count > 1 ? (float(k) + 0.5) / float(count) : 0.0, turn = float(k) * 2.39996323;  // a sunflower
        float cosine = 1.0 - share * (1.0 - rim), sine = sqrt(max(1.0 - cosine * cosine, 0.0));
        float3 L = radtex_in_frame(cosine * axis + sine * (cos(turn) * across + sin(turn) * up), frame);
        if (L.z > 0.0) sum += L.z * radtex_visible_point(RADTEX_POINT, n, L);
    }
    return sum / float(count) * 2.0 / (1.0 + rim);
}

// A rectangle's irradiance over its radiance: it lies at `corner`, its sides are `side` and `up`, and it shines along
// cross(side, up). Divide by the area for a lamp of given power. Points are spread by Roberts's sequence.
float radtex_rectangle(RADTEX_SHADOW, int n, float3x3 frame, float3 position, float3 corner, float3 side, float3 up,
                       int count) {
#ifndef RADTEX_SHADOW_LAYERS
    float radtex_openness[64];
    radtex_blend(here, radtex_openness);
#endif
    float3 face = cross(side, up);  // as long as the area
    float sum = 0.0;
    for (int k = 0; k < count; k++) {
        float2 place = frac(0.5 + float(k + 1) * float2(0.754877666, 0.569840291));
        float3 way = corner + place.x * side + place.y * up - position;
        float squared = max(dot(way, way), 1e-30);
        float3 L = radtex_in_frame(way * rsqrt(squared), frame);
        float weight = max(L.z, 0.0) * max(-dot(way, face), 0.0) / (squared * sqrt(squared));
        if (weight > 0.0) sum += weight * radtex_visible_point(RADTEX_POINT, n, L);
    }
    return sum / float(count);
}

#endif
