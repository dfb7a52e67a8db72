// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
//
// Look up a radiance texture: GLSL 330 and later, GLSL ES 300 (WebGL 2) and later. Include it, then
//
//     vec3 I = radtex_incidence(camera - position, normal, tangent.xyz, tangent.w);
//     vec4 colour = radtex_sample(atlas, ivec2(W, H), n, uv, I, RADTEX_QUADRILINEAR);
//
// `atlas` is <name>.<kind>.exr: W x H texels of n x n cells, scene-linear Rec.709, alpha premultiplied, without mipmaps,
// uploaded bottom row first (v = 0 is row 0). Normal and tangent are MikkTSpace's of the baked UV map, interpolated;
// tangent.w is the bitangent's sign, times the sign of the model matrix's determinant.

#ifdef GL_ES
precision highp float;
precision highp int;
precision highp sampler2D;
#endif

const int RADTEX_NEAREST = 0;       // one cell: the paper's one lookup
const int RADTEX_LINEAR = 1;        // bilinear inside the bucket
const int RADTEX_QUADRILINEAR = 2;  // four texels, each bilinear inside its bucket

// The vector towards the viewer in the surface frame (T, Bt, N). Vectors in any one space, of any length but zero.
vec3 radtex_incidence(vec3 to_viewer, vec3 normal, vec3 tangent, float bitangent_sign) {
    vec3 N = normalize(normal);
    vec3 T = tangent / max(length(tangent), 1e-30);
    T -= N * dot(N, T);
    if (dot(T, T) < 1e-8) T = cross(abs(N.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0), N);
    T = normalize(T);
    vec3 Bt = sign(bitangent_sign) * cross(N, T);
    vec3 V = normalize(to_viewer);
    return vec3(dot(V, T), dot(V, Bt), dot(V, N));
}

// Where a unit direction in the frame lies in its bucket: B in [-1, 1]^2. Below the horizon: the rim, at its azimuth.
vec2 radtex_bucket(vec3 I) {
    vec2 A = I.xy / sqrt(max(1.0 + I.z, 1e-30));        // equisolid: sqrt(2) I.xy / |I + (0,0,1)|, for a unit I
    A /= max(length(A), 1.0);
    float widest = max(abs(A.x), abs(A.y));
    return A * (length(A) / max(widest, 1e-30));        // disc to square: A |A| / max(|A.x|, |A.y|)
}

// One texel's bucket at B, by cells or bilinear between the four around it, never beyond the bucket's own.
vec4 radtex_texel(sampler2D atlas, ivec2 texel, int n, vec2 B, bool blend) {
    ivec2 origin = texel * n, last = ivec2(n - 1);
    vec2 position = (B + 1.0) * 0.5 * float(n);
    if (!blend) return texelFetch(atlas, origin + clamp(ivec2(position), ivec2(0), last), 0);
    position = clamp(position, 0.5, float(n) - 0.5);    // the bleed guard: B in [1/n - 1, 1 - 1/n]
#ifdef RADTEX_HARDWARE_LINEAR                           // one lookup; the sampler must be LINEAR. Its weights have 8 bits
    return textureLod(atlas, (vec2(origin) + position) / vec2(textureSize(atlas, 0)), 0.0);
#else
    ivec2 low = ivec2(position - 0.5), high = min(low + 1, last);
    vec2 f = position - 0.5 - vec2(low);
    vec4 below = mix(texelFetch(atlas, origin + low, 0), texelFetch(atlas, origin + ivec2(high.x, low.y), 0), f.x);
    vec4 above = mix(texelFetch(atlas, origin + ivec2(low.x, high.y), 0), texelFetch(atlas, origin + high, 0), f.x);
    return mix(below, above, f.y);
#endif
}

// Radiance (rgb, premultiplied) and alpha that leave the surface at `uv` in the direction I of the frame.
vec4 radtex_sample(sampler2D atlas, ivec2 texels, int n, vec2 uv, vec3 I, int mode) {
    vec2 B = radtex_bucket(I), position = uv * vec2(texels);
    ivec2 last = texels - 1;
    if (mode != RADTEX_QUADRILINEAR) {
        ivec2 texel = clamp(ivec2(floor(position)), ivec2(0), last);
        return radtex_texel(atlas, texel, n, B, mode == RADTEX_LINEAR);
    }
    ivec2 corner = ivec2(floor(position - 0.5));
    ivec2 low = clamp(corner, ivec2(0), last), high = clamp(corner + 1, ivec2(0), last);
    vec2 f = fract(position - 0.5);
    vec4 below = mix(radtex_texel(atlas, low, n, B, true), radtex_texel(atlas, ivec2(high.x, low.y), n, B, true), f.x);
    vec4 above = mix(radtex_texel(atlas, ivec2(low.x, high.y), n, B, true), radtex_texel(atlas, high, n, B, true), f.x);
    return mix(below, above, f.y);
}
