// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Written by RadTex's .ci/build_shaders.py from shaders/source/radtex.c.
//
// Look up a radiance texture: WGSL. Put it before your shader's text, then
//
//     let I = radtex_incidence(camera - position, normal, tangent.xyz, tangent.w);
//     let colour = radtex_sample(atlas, vec2i(W, H), n, uv, I, RADTEX_QUADRILINEAR);
//
// `atlas` is <name>.<kind>.exr: W x H texels of n x n cells, scene-linear Rec.709, alpha premultiplied, uploaded bottom
// row first (v = 0 is row 0). Normal and tangent are MikkTSpace's of the baked UV map, interpolated; tangent.w is the
// bitangent's sign, times the sign of the model matrix's determinant. Far away, either of
//
//     radtex_sample_level(atlas, vec2i(W, H), n, uv, I, radtex_level(uv, vec2i(W, H), levels));
//     radtex_slices(slices, filtering, n, uv, I);
//
// with the atlas's mip levels, or with its slices: an array texture; `filtering` is linear and clamps to the edge. Such
// a sampler can blend an atlas's cells, too, where names end in _filtered. An atlas in pages needs radtex_pages.wgsl.

const RADTEX_NEAREST: i32 = 0;       // one cell: the paper's one lookup
const RADTEX_LINEAR: i32 = 1;        // bilinear inside the bucket
const RADTEX_QUADRILINEAR: i32 = 2;  // four texels, each bilinear inside its bucket

// The vector towards the viewer in the surface frame (T, Bt, N). Vectors in any one space, of any length but zero.
fn radtex_incidence(to_viewer: vec3f, normal: vec3f, tangent: vec3f, bitangent_sign: f32) -> vec3f {
    let N = normalize(normal);
    var T = tangent / max(length(tangent), 1e-30);
    T -= N * dot(N, T);
    let degenerate = dot(T, T) < 1e-8;
    if degenerate { T = cross(select(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 0.0, 1.0), abs(N.z) < 0.9), N); }
    T = normalize(T);
    let Bt = sign(bitangent_sign) * cross(N, T);
    let V = normalize(to_viewer);
    return vec3f(dot(V, T), dot(V, Bt), dot(V, N));
}

// Where a unit direction in the frame lies in its bucket: B in [-1, 1]^2. Below the horizon: the rim, at its azimuth.
fn radtex_bucket(I: vec3f) -> vec2f {
    // |A|^2; equisolid: A = sqrt(2) I.xy / |I + (0,0,1)|, |I| = 1
    let A2 = dot(I.xy, I.xy) / max(1.0 + I.z, 1e-30);
    let widest = max(abs(I.x), abs(I.y));
    return I.xy * (sqrt(min(A2, 1.0)) / max(widest, 1e-30));  // disc to square: A |A| / max(|A.x|, |A.y|)
}

// One texel's cell, which is a pixel of the atlas.
fn radtex_cell(atlas: texture_2d<f32>, texel: vec2i, n: i32, cell: vec2i, level: i32) -> vec4f {
    return textureLoad(atlas, texel * n + cell, level);
}

// One texel's bucket at B, by cells or bilinear between the four around it, never beyond the bucket's own.
fn radtex_texel(atlas: texture_2d<f32>, texel: vec2i, n: i32, B: vec2f, blend: bool, level: i32) -> vec4f {
    let last = vec2i(n - 1, n - 1);
    let inner = f32(n) - 0.5;
    var position = (B + 1.0) * 0.5 * f32(n);
    if !blend {
        return radtex_cell(atlas, texel, n, clamp(vec2i(position), vec2i(0, 0), last), level);
    }
    position = clamp(position, vec2f(0.5, 0.5), vec2f(inner, inner));  // the bleed guard: B in [1/n - 1, 1 - 1/n]
    let low = vec2i(position - 0.5);
    let high = min(low + 1, last);
    let f = position - 0.5 - vec2f(low);
    let below = mix(radtex_cell(atlas, texel, n, low, level),
        radtex_cell(atlas, texel, n, vec2i(high.x, low.y), level), f.x);
    let above = mix(radtex_cell(atlas, texel, n, vec2i(low.x, high.y), level),
        radtex_cell(atlas, texel, n, high, level), f.x);
    return mix(below, above, f.y);
}

// The four texels around `uv`, each bilinear in its bucket. Level L averages blocks of 2^L x 2^L texels, cell by cell.
fn radtex_four(atlas: texture_2d<f32>, texels: vec2i, n: i32, uv: vec2f, B: vec2f, level: i32) -> vec4f {
    let position = uv * vec2f(texels) / f32(1 << u32(level)) - 0.5;
    let last = vec2i((texels.x - 1) >> u32(level), (texels.y - 1) >> u32(level));  // ceil(texels / 2^L) - 1
    let corner = vec2i(floor(position));
    let low = clamp(corner, vec2i(0, 0), last);
    let high = clamp(corner + 1, vec2i(0, 0), last);
    let f = fract(position);
    let below = mix(radtex_texel(atlas, low, n, B, true, level),
        radtex_texel(atlas, vec2i(high.x, low.y), n, B, true, level), f.x);
    let above = mix(radtex_texel(atlas, vec2i(low.x, high.y), n, B, true, level),
        radtex_texel(atlas, high, n, B, true, level), f.x);
    return mix(below, above, f.y);
}

// Radiance (rgb, premultiplied) and alpha that leave the surface at `uv` in the direction I of the frame.
fn radtex_sample(atlas: texture_2d<f32>, texels: vec2i, n: i32, uv: vec2f, I: vec3f, mode: i32) -> vec4f {
    let B = radtex_bucket(I);
    if mode == RADTEX_QUADRILINEAR { return radtex_four(atlas, texels, n, uv, B, 0); }
    let texel = clamp(vec2i(floor(uv * vec2f(texels))), vec2i(0, 0), texels - 1);
    return radtex_texel(atlas, texel, n, B, mode == RADTEX_LINEAR, 0);
}

// What a ray finds where it hits the surface at `uv`: radtex_sample towards where it comes from. `ray` leads to the
// surface, in the space of the other vectors, of any length but zero. One from behind the normal takes the rim: at a
// slant a smooth normal turns away from rays that do hit the front. A ray that meets a facet's back is no hit.
fn radtex_hit(atlas: texture_2d<f32>, texels: vec2i, n: i32, uv: vec2f, ray: vec3f, normal: vec3f, tangent: vec3f,
              bitangent_sign: f32, mode: i32) -> vec4f {
    let I = radtex_incidence(-ray, normal, tangent, bitangent_sign);
    return radtex_sample(atlas, texels, n, uv, I, mode);
}

// As radtex_sample, quadrilinear, between the mip levels around `level`, which is 0 or more and the atlas's last at most.
fn radtex_sample_level(atlas: texture_2d<f32>, texels: vec2i, n: i32, uv: vec2f, I: vec3f, level: f32) -> vec4f {
    let B = radtex_bucket(I);
    let low = i32(level);
    let sharper = radtex_four(atlas, texels, n, uv, B, low);
    if level == f32(low) { return sharper; }  // always so where the texture is magnified
    return mix(sharper, radtex_four(atlas, texels, n, uv, B, low + 1), level - f32(low));
}

// The mip level at which a texel is as wide as a pixel of the screen: log2 of the longer derivative, in texels.
// Only in the fragment stage, in uniform control flow.
fn radtex_level(uv: vec2f, texels: vec2i, levels: i32) -> f32 {
    let across = dpdx(uv) * vec2f(texels);
    let up = dpdy(uv) * vec2f(texels);
    return min(0.5 * log2(max(max(dot(across, across), dot(up, up)), 1.0)), f32(levels - 1));
}

// The quadrilinear filter of slices: layer q * n + p holds the cell (p, q) of all texels, so that the four cells around
// B take one hardware lookup each, with mipmaps and anisotropy. Never call it where pixels go different ways.
fn radtex_slices(slices: texture_2d_array<f32>, filtering: sampler, n: i32, uv: vec2f, I: vec3f) -> vec4f {
    let inner = f32(n) - 0.5;  // the bleed guard
    let position = clamp((radtex_bucket(I) + 1.0) * 0.5 * f32(n), vec2f(0.5, 0.5), vec2f(inner, inner)) - 0.5;
    var low = vec2i(position);
    var high = min(low + 1, vec2i(n - 1, n - 1));
    let f = position - vec2f(low);
    low.y *= n;
    high.y *= n;
    let below = mix(textureSample(slices, filtering, uv, low.y + low.x),
        textureSample(slices, filtering, uv, low.y + high.x), f.x);
    let above = mix(textureSample(slices, filtering, uv, high.y + low.x),
        textureSample(slices, filtering, uv, high.y + high.x), f.x);
    return mix(below, above, f.y);
}

// The same at a mip level of your choice, in any stage.
fn radtex_slices_level(slices: texture_2d_array<f32>, filtering: sampler, n: i32, uv: vec2f, I: vec3f,
                       level: f32) -> vec4f {
    let inner = f32(n) - 0.5;
    let position = clamp((radtex_bucket(I) + 1.0) * 0.5 * f32(n), vec2f(0.5, 0.5), vec2f(inner, inner)) - 0.5;
    let low = vec2i(position);
    let high = min(low + 1, vec2i(n - 1, n - 1));
    let f = position - vec2f(low);
    let below = mix(textureSampleLevel(slices, filtering, uv, low.y * n + low.x, level),
        textureSampleLevel(slices, filtering, uv, low.y * n + high.x, level), f.x);
    let above = mix(textureSampleLevel(slices, filtering, uv, high.y * n + low.x, level),
        textureSampleLevel(slices, filtering, uv, high.y * n + high.x, level), f.x);
    return mix(below, above, f.y);
}

// One texel's cell, which is a pixel of the atlas.
fn radtex_cell_filtered(atlas: texture_2d<f32>, filtering: sampler, texel: vec2i, n: i32, cell: vec2i,
                        level: i32) -> vec4f {
    return textureLoad(atlas, texel * n + cell, level);
}

// The same between cells, their centres at a half, by the sampler, which must be linear: one lookup. It weighs by 8 bits.
fn radtex_between_filtered(atlas: texture_2d<f32>, filtering: sampler, texel: vec2i, n: i32, position: vec2f,
                           level: i32) -> vec4f {
    let size = vec2f(textureDimensions(atlas, level));
    return textureSampleLevel(atlas, filtering, (vec2f(texel * n) + position) / size, f32(level));
}

// One texel's bucket at B, by cells or bilinear between the four around it, never beyond the bucket's own.
fn radtex_texel_filtered(atlas: texture_2d<f32>, filtering: sampler, texel: vec2i, n: i32, B: vec2f, blend: bool,
                         level: i32) -> vec4f {
    let last = vec2i(n - 1, n - 1);
    let inner = f32(n) - 0.5;
    var position = (B + 1.0) * 0.5 * f32(n);
    if !blend {
        return radtex_cell_filtered(atlas, filtering, texel, n, clamp(vec2i(position), vec2i(0, 0), last), level);
    }
    position = clamp(position, vec2f(0.5, 0.5), vec2f(inner, inner));  // the bleed guard: B in [1/n - 1, 1 - 1/n]
    return radtex_between_filtered(atlas, filtering, texel, n, position, level);
}

// The four texels around `uv`, each bilinear in its bucket. Level L averages blocks of 2^L x 2^L texels, cell by cell.
fn radtex_four_filtered(atlas: texture_2d<f32>, filtering: sampler, texels: vec2i, n: i32, uv: vec2f, B: vec2f,
                        level: i32) -> vec4f {
    let position = uv * vec2f(texels) / f32(1 << u32(level)) - 0.5;
    let last = vec2i((texels.x - 1) >> u32(level), (texels.y - 1) >> u32(level));  // ceil(texels / 2^L) - 1
    let corner = vec2i(floor(position));
    let low = clamp(corner, vec2i(0, 0), last);
    let high = clamp(corner + 1, vec2i(0, 0), last);
    let f = fract(position);
    let below = mix(radtex_texel_filtered(atlas, filtering, low, n, B, true, level),
        radtex_texel_filtered(atlas, filtering, vec2i(high.x, low.y), n, B, true, level), f.x);
    let above = mix(radtex_texel_filtered(atlas, filtering, vec2i(low.x, high.y), n, B, true, level),
        radtex_texel_filtered(atlas, filtering, high, n, B, true, level), f.x);
    return mix(below, above, f.y);
}

// Radiance (rgb, premultiplied) and alpha that leave the surface at `uv` in the direction I of the frame.
fn radtex_sample_filtered(atlas: texture_2d<f32>, filtering: sampler, texels: vec2i, n: i32, uv: vec2f, I: vec3f,
                          mode: i32) -> vec4f {
    let B = radtex_bucket(I);
    if mode == RADTEX_QUADRILINEAR { return radtex_four_filtered(atlas, filtering, texels, n, uv, B, 0); }
    let texel = clamp(vec2i(floor(uv * vec2f(texels))), vec2i(0, 0), texels - 1);
    return radtex_texel_filtered(atlas, filtering, texel, n, B, mode == RADTEX_LINEAR, 0);
}

// What a ray finds where it hits the surface at `uv`: radtex_sample towards where it comes from. `ray` leads to the
// surface, in the space of the other vectors, of any length but zero. One from behind the normal takes the rim: at a
// slant a smooth normal turns away from rays that do hit the front. A ray that meets a facet's back is no hit.
fn radtex_hit_filtered(atlas: texture_2d<f32>, filtering: sampler, texels: vec2i, n: i32, uv: vec2f, ray: vec3f,
                       normal: vec3f, tangent: vec3f, bitangent_sign: f32, mode: i32) -> vec4f {
    let I = radtex_incidence(-ray, normal, tangent, bitangent_sign);
    return radtex_sample_filtered(atlas, filtering, texels, n, uv, I, mode);
}

// As radtex_sample, quadrilinear, between the mip levels around `level`, which is 0 or more and the atlas's last at most.
fn radtex_sample_level_filtered(atlas: texture_2d<f32>, filtering: sampler, texels: vec2i, n: i32, uv: vec2f, I: vec3f,
                                level: f32) -> vec4f {
    let B = radtex_bucket(I);
    let low = i32(level);
    let sharper = radtex_four_filtered(atlas, filtering, texels, n, uv, B, low);
    if level == f32(low) { return sharper; }  // always so where the texture is magnified
    return mix(sharper, radtex_four_filtered(atlas, filtering, texels, n, uv, B, low + 1), level - f32(low));
}
