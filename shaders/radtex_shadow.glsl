// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
//
// Look up shadows in one bit a cell: GLSL 330 and later, GLSL ES 300 (WebGL 2) and later. Include radtex.glsl, then
// this, then
//
//     RadtexShadow here = radtex_shadow(bits, ivec2(W, H), uv);
//     vec3 L = radtex_incidence(to_light, normal, tangent.xyz, tangent.w);
//     light = colour * max(L.z, 0.0) * radtex_visible(here, n, L);                        // a light without a size
//     light = colour * radtex_sun(here, n, frame, to_sun, angle, 32);                     // with one: cosine included
//     light = colour * radtex_rectangle(here, n, frame, position, corner, side, up, 32);
//
// `bits` is <name>.shadow.exr, bottom row first (v = 0 is row 0), never filtered: up to 8 x 8 cells an RG32UI texture
// of W x H pixels. With more cells, `#define RADTEX_SHADOW_LAYERS` makes it an array, layer k holding the words 2 k and
// 2 k + 1. Bit q * n + p, the least significant first, is 1 where the direction of the cell (p, q) is blocked. `frame`
// comes from radtex_frame: its columns are T, Bt and N, in the space of all other vectors.

#ifdef GL_ES
precision highp usampler2D;
precision highp usampler2DArray;
#endif

#ifdef RADTEX_SHADOW_LAYERS
#define RADTEX_BITS usampler2DArray
#else
#define RADTEX_BITS usampler2D
#endif

// The four texels around a place, and their weights.
struct RadtexShadow {
    vec4 weights;
#ifdef RADTEX_SHADOW_LAYERS
    ivec2 low, high;
#else
    uvec2 words[4];
#endif
};

#ifdef RADTEX_SHADOW_LAYERS
#define RADTEX_SHADOW RADTEX_BITS bits, RadtexShadow here
#define RADTEX_HERE bits, here
#else
#define RADTEX_SHADOW RadtexShadow here
#define RADTEX_HERE here
#endif

// What every lookup at `uv` reads, for however many lights. With layers, `bits` also is each lookup's first argument.
RadtexShadow radtex_shadow(RADTEX_BITS bits, ivec2 texels, vec2 uv) {
    vec2 position = uv * vec2(texels) - 0.5;
    ivec2 corner = ivec2(floor(position)), last = texels - 1;
    ivec2 low = clamp(corner, ivec2(0), last), high = clamp(corner + 1, ivec2(0), last);
    vec2 f = fract(position);
    RadtexShadow here;
    here.weights = vec4((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
#ifdef RADTEX_SHADOW_LAYERS
    here.low = low;
    here.high = high;
#else
    here.words[0] = texelFetch(bits, low, 0).xy;
    here.words[1] = texelFetch(bits, ivec2(high.x, low.y), 0).xy;
    here.words[2] = texelFetch(bits, ivec2(low.x, high.y), 0).xy;
    here.words[3] = texelFetch(bits, high, 0).xy;
#endif
    return here;
}

// 1 where the cell of texel `t`, of four, is open, 0 where it is blocked.
float radtex_open(RADTEX_SHADOW, int t, int k) {
#ifdef RADTEX_SHADOW_LAYERS
    ivec2 texel = ivec2((t & 1) == 0 ? here.low.x : here.high.x, t < 2 ? here.low.y : here.high.y);
    uvec2 words = texelFetch(bits, ivec3(texel, k >> 6), 0).xy;
#else
    uvec2 words = here.words[t];
#endif
    uint word = (k & 32) == 0 ? words.x : words.y;
    return float(1u - ((word >> uint(k & 31)) & 1u));
}

// How much of a light in the unit direction I of the frame is seen, 0 to 1: texels and cells are blended.
float radtex_visible(RADTEX_SHADOW, int n, vec3 I) {
    vec2 position = clamp((radtex_bucket(I) + 1.0) * 0.5 * float(n), 0.5, float(n) - 0.5) - 0.5;
    ivec2 low = ivec2(position), high = min(low + 1, n - 1);
    vec2 f = position - vec2(low);
    float seen = 0.0;
    for (int t = 0; t < 4; t++) {
        float below = mix(radtex_open(RADTEX_HERE, t, low.y * n + low.x),
                          radtex_open(RADTEX_HERE, t, low.y * n + high.x), f.x);
        float above = mix(radtex_open(RADTEX_HERE, t, high.y * n + low.x),
                          radtex_open(RADTEX_HERE, t, high.y * n + high.x), f.x);
        seen += here.weights[t] * mix(below, above, f.y);
    }
    return seen;
}

// The same of the one cell that holds I: for each of many points of a light, whose size blends cells by itself.
float radtex_visible_cell(RADTEX_SHADOW, int n, vec3 I) {
    ivec2 cell = clamp(ivec2((radtex_bucket(I) + 1.0) * 0.5 * float(n)), ivec2(0), ivec2(n - 1));
    int k = cell.y * n + cell.x;
    return dot(here.weights, vec4(radtex_open(RADTEX_HERE, 0, k), radtex_open(RADTEX_HERE, 1, k),
                                  radtex_open(RADTEX_HERE, 2, k), radtex_open(RADTEX_HERE, 3, k)));
}

// The frame (T, Bt, N) as columns: what radtex_incidence brings vectors into.
mat3 radtex_frame(vec3 normal, vec3 tangent, float bitangent_sign) {
    vec3 x = radtex_incidence(vec3(1.0, 0.0, 0.0), normal, tangent, bitangent_sign);
    vec3 y = radtex_incidence(vec3(0.0, 1.0, 0.0), normal, tangent, bitangent_sign);
    vec3 z = radtex_incidence(vec3(0.0, 0.0, 1.0), normal, tangent, bitangent_sign);
    return transpose(mat3(x, y, z));
}

// A sun's irradiance over that which it has at a right angle, from `count` points, even on its disc, `angle` wide in
// radians.
float radtex_sun(RADTEX_SHADOW, int n, mat3 frame, vec3 to_sun, float angle, int count) {
    vec3 axis = normalize(to_sun);
    vec3 across = normalize(cross(abs(axis.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0), axis));
    vec3 up = cross(axis, across);
    float rim = cos(0.5 * angle), sum = 0.0;
    for (int k = 0; k < count; k++) {
        float share = count > 1 ? (float(k) + 0.5) / float(count) : 0.0, turn = float(k) * 2.39996323;  // a sunflower
        float cosine = 1.0 - share * (1.0 - rim), sine = sqrt(max(1.0 - cosine * cosine, 0.0));
        vec3 L = (cosine * axis + sine * (cos(turn) * across + sin(turn) * up)) * frame;
        if (L.z > 0.0) sum += L.z * radtex_visible_cell(RADTEX_HERE, n, L);
    }
    return sum / float(count) * 2.0 / (1.0 + rim);
}

// A rectangle's irradiance over its radiance: it lies at `corner`, its sides are `side` and `up`, and it shines along
// cross(side, up). Divide by the area for a lamp of given power. Points are spread by Roberts's sequence.
float radtex_rectangle(RADTEX_SHADOW, int n, mat3 frame, vec3 position, vec3 corner, vec3 side, vec3 up, int count) {
    vec3 face = cross(side, up);  // as long as the area
    float sum = 0.0;
    for (int k = 0; k < count; k++) {
        vec2 place = fract(0.5 + float(k + 1) * vec2(0.754877666, 0.569840291));
        vec3 way = corner + place.x * side + place.y * up - position;
        float squared = max(dot(way, way), 1e-30);
        vec3 L = (way * inversesqrt(squared)) * frame;
        float weight = max(L.z, 0.0) * max(-dot(way, face), 0.0) / (squared * sqrt(squared));
        if (weight > 0.0) sum += weight * radtex_visible_cell(RADTEX_HERE, n, L);
    }
    return sum / float(count);
}
