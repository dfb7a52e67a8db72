// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
//
// Look up a radiance texture in pages, an array texture: WGSL. Put it behind radtex.wgsl, then
//
//     let colour = radtex_sample_paged(atlas, pages, vec2i(W, H), n, uv, I, RADTEX_QUADRILINEAR);
//
// pages = (columns, rows, texels a page across, up): the export's "pages" and "page_texels".

// Where a texel begins, in pixels, and in which layer.
fn radtex_page(pages: vec4i, texel: vec2i, n: i32, level: i32) -> vec3i {
    let size = pages.zw >> vec2u(u32(level));
    let page = texel / size;
    return vec3i((texel - page * size) * n, page.y * pages.x + page.x);
}

// As radtex_texel.
fn radtex_texel_paged(atlas: texture_2d_array<f32>, pages: vec4i, texel: vec2i, n: i32, B: vec2f, blend: bool,
                      level: i32) -> vec4f {
    let page = radtex_page(pages, texel, n, level);
    if !blend {
        let cell = clamp(vec2i((B + 1.0) * 0.5 * f32(n)), vec2i(0), vec2i(n - 1));
        return textureLoad(atlas, page.xy + cell, page.z, level);
    }
    let c = radtex_cells(n, B);
    return radtex_mix(textureLoad(atlas, page.xy + c.low, page.z, level),
                      textureLoad(atlas, page.xy + vec2i(c.high.x, c.low.y), page.z, level),
                      textureLoad(atlas, page.xy + vec2i(c.low.x, c.high.y), page.z, level),
                      textureLoad(atlas, page.xy + c.high, page.z, level), c.f);
}

// As radtex_four.
fn radtex_four_paged(atlas: texture_2d_array<f32>, pages: vec4i, texels: vec2i, n: i32, uv: vec2f, B: vec2f,
                       level: i32) -> vec4f {
    let t = radtex_around(texels, uv, level);
    return radtex_mix(radtex_texel_paged(atlas, pages, t.low, n, B, true, level),
                      radtex_texel_paged(atlas, pages, vec2i(t.high.x, t.low.y), n, B, true, level),
                      radtex_texel_paged(atlas, pages, vec2i(t.low.x, t.high.y), n, B, true, level),
                      radtex_texel_paged(atlas, pages, t.high, n, B, true, level), t.f);
}

// As radtex_sample.
fn radtex_sample_paged(atlas: texture_2d_array<f32>, pages: vec4i, texels: vec2i, n: i32, uv: vec2f, I: vec3f,
                       mode: i32) -> vec4f {
    let B = radtex_bucket(I);
    if mode == RADTEX_QUADRILINEAR { return radtex_four_paged(atlas, pages, texels, n, uv, B, 0); }
    let texel = clamp(vec2i(floor(uv * vec2f(texels))), vec2i(0), texels - 1);
    return radtex_texel_paged(atlas, pages, texel, n, B, mode == RADTEX_LINEAR, 0);
}

// As radtex_hit.
fn radtex_hit_paged(atlas: texture_2d_array<f32>, pages: vec4i, texels: vec2i, n: i32, uv: vec2f, ray: vec3f,
                    normal: vec3f, tangent: vec3f, bitangent_sign: f32, mode: i32) -> vec4f {
    let I = radtex_incidence(-ray, normal, tangent, bitangent_sign);
    return radtex_sample_paged(atlas, pages, texels, n, uv, I, mode);
}

// As radtex_sample_level.
fn radtex_sample_level_paged(atlas: texture_2d_array<f32>, pages: vec4i, texels: vec2i, n: i32, uv: vec2f, I: vec3f,
                             level: f32) -> vec4f {
    let B = radtex_bucket(I);
    let low = i32(level);
    let sharper = radtex_four_paged(atlas, pages, texels, n, uv, B, low);
    if level == f32(low) { return sharper; }
    return mix(sharper, radtex_four_paged(atlas, pages, texels, n, uv, B, low + 1), level - f32(low));
}
