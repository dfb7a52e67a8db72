// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// Light of a bake in the layout `buckets`, whose matrix or slices are the texture u_radiance; of kind `ao` its grey.

uniform highp SAMPLER u_radiance;
uniform ivec2 u_texels;
uniform int u_bucket;
#ifdef RADTEX_PAGES
uniform ivec4 u_pages;
#define ATLAS u_radiance, u_pages
#else
#define ATLAS u_radiance
#endif

#ifdef AMBIENT  // alpha is how much is open, the rest a direction
#define SHOWN(seen) vec4((seen).aaa, 1.0)
#else
#define SHOWN(seen) seen
#endif

// Light (rgb, premultiplied) and alpha towards the viewer in the unit direction V.
vec4 light(vec2 uv, vec3 normal, vec4 tangent, vec3 V) {
    vec3 I = radtex_incidence(V, normal, tangent.xyz, tangent.w);
#if defined(SLICES)
    return SHOWN(radtex_slices(u_radiance, u_bucket, uv, I));
#elif defined(LEVELS)
    return SHOWN(radtex_sample_level(ATLAS, u_texels, u_bucket, uv, I, radtex_level(uv, u_texels, LEVELS)));
#else
    return SHOWN(radtex_sample(ATLAS, u_texels, u_bucket, uv, I, FILTER));
#endif
}

// One cell of one texel's bucket, as it is stored.
vec4 stored_cell(ivec2 texel, ivec2 cell) {
#ifdef SLICES
    return SHOWN(texelFetch(u_radiance, ivec3(texel, cell.y * u_bucket + cell.x), 0));
#else
    vec2 B = (vec2(cell) + 0.5) / float(u_bucket) * 2.0 - 1.0;
    return SHOWN(radtex_texel(ATLAS, texel, u_bucket, B, false, 0));
#endif
}
