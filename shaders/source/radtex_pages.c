// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
@for wgsl
//
// Look up a radiance texture in pages, an array texture: WGSL. Put it behind radtex.wgsl, then
//
//     vec4 colour = radtex_sample_paged(atlas, pages, ivec2(W, H), n, uv, I, RADTEX_QUADRILINEAR);
//
// pages = (columns, rows, texels a page across, up): the export's "pages" and "page_texels".

@again radtex paged RADTEX_PAGES
