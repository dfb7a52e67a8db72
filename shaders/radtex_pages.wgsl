// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Written by RadTex's .ci/build_shaders.py from shaders/source/radtex_pages.c.
//
// Look up a radiance texture in pages, an array texture: WGSL. Put it behind radtex.wgsl, then
//
//     let colour = radtex_sample_paged(atlas, pages, vec2i(W, H), n, uv, I, RADTEX_QUADRILINEAR);
//
// pages = (columns, rows, texels a page across, up): the export's "pages" and "page_texels".

// One texel's cell, which is a pixel of the atlas.
fn radtex_cell_paged(atlas: texture_2d_array<f32>, pages: vec4i, texel: vec2i, n: i32, cell: vec2i,
                     level: i32) -> vec4f {
    let size = vec2i(pages.z >> u32(level), pages.w >> u32(level));
    let page = texel / size;
    let pixel = (texel - page * size) * n + cell;
    let layer = page.y * pages.x + page.x;
    return textureLoad(atlas, pixel, layer, level);
}

// One texel's bucket at B, by cells or bilinear between the four around it, never beyond the bucket's own.
fn radtex_texel_paged(atlas: texture_2d_array<f32>, pages: vec4i, texel: vec2i, n: i32, B: vec2f, blend: bool,
                      level: i32) -> vec4f {
    let last = vec2i(n - 1, n - 1);
    let inner = f32(n) - 0.5;
    var position = (B + 1.0) * 0.5 * f32(n);
    if !blend {
        return radtex_cell_paged(atlas, pages, texel, n, clamp(vec2i(position), vec2i(0, 0), last), level);
    }
    position = clamp(position, vec2f(0.5, 0.5), vec2f(inner, inner));  // the bleed guard: B in [1/n - 1, 1 - 1/n]
    let low = vec2i(position - 0.5);
    let high = min(low + 1, last);
    let f = position - 0.5 - vec2f(low);
    let below = mix(radtex_cell_paged(atlas, pages, texel, n, low, level),
        radtex_cell_paged(atlas, pages, texel, n, vec2i(high.x, low.y), level), f.x);
    let above = mix(radtex_cell_paged(atlas, pages, texel, n, vec2i(low.x, high.y), level),
        radtex_cell_paged(atlas, pages, texel, n, high, level), f.x);
    return mix(below, above, f.y);
}

// The four texels around `uv`, each bilinear in its bucket. Level L averages blocks of 2^L x 2^L texels, cell by cell.
fn radtex_four_paged(atlas: texture_2d_array<f32>, pages: vec4i, texels: vec2i, n: i32, uv: vec2f, B: vec2f,
                     level: i32) -> vec4f {
    let position = uv * vec2f(texels) / f32(1 << u32(level)) - 0.5;
    let last = vec2i((texels.x - 1) >> u32(level), (texels.y - 1) >> u32(level));  // ceil(texels / 2^L) - 1
    let corner = vec2i(floor(position));
    let low = clamp(corner, vec2i(0, 0), last);
    let high = clamp(corner + 1, vec2i(0, 0), last);
    let f = fract(position);
    let below = mix(radtex_texel_paged(atlas, pages, low, n, B, true, level),
        radtex_texel_paged(atlas, pages, vec2i(high.x, low.y), n, B, true, level), f.x);
    let above = mix(radtex_texel_paged(atlas, pages, vec2i(low.x, high.y), n, B, true, level),
        radtex_texel_paged(atlas, pages, high, n, B, true, level), f.x);
    return mix(below, above, f.y);
}

// Radiance (rgb, premultiplied) and alpha that leave the surface at `uv` in the direction I of the frame.
fn radtex_sample_paged(atlas: texture_2d_array<f32>, pages: vec4i, texels: vec2i, n: i32, uv: vec2f, I: vec3f,
                       mode: i32) -> vec4f {
    let B = radtex_bucket(I);
    if mode == RADTEX_QUADRILINEAR { return radtex_four_paged(atlas, pages, texels, n, uv, B, 0); }
    let texel = clamp(vec2i(floor(uv * vec2f(texels))), vec2i(0, 0), texels - 1);
    return radtex_texel_paged(atlas, pages, texel, n, B, mode == RADTEX_LINEAR, 0);
}

// What a ray finds where it hits the surface at `uv`: radtex_sample towards where it comes from. `ray` leads to the
// surface, in the space of the other vectors, of any length but zero. One from behind the normal takes the rim: at a
// slant a smooth normal turns away from rays that do hit the front. A ray that meets a facet's back is no hit.
fn radtex_hit_paged(atlas: texture_2d_array<f32>, pages: vec4i, texels: vec2i, n: i32, uv: vec2f, ray: vec3f,
                    normal: vec3f, tangent: vec3f, bitangent_sign: f32, mode: i32) -> vec4f {
    let I = radtex_incidence(-ray, normal, tangent, bitangent_sign);
    return radtex_sample_paged(atlas, pages, texels, n, uv, I, mode);
}

// As radtex_sample, quadrilinear, between the mip levels around `level`, which is 0 or more and the atlas's last at most.
fn radtex_sample_level_paged(atlas: texture_2d_array<f32>, pages: vec4i, texels: vec2i, n: i32, uv: vec2f, I: vec3f,
                             level: f32) -> vec4f {
    let B = radtex_bucket(I);
    let low = i32(level);
    let sharper = radtex_four_paged(atlas, pages, texels, n, uv, B, low);
    if level == f32(low) { return sharper; }  // always so where the texture is magnified
    return mix(sharper, radtex_four_paged(atlas, pages, texels, n, uv, B, low + 1), level - f32(low));
}
