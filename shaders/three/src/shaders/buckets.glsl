// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
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
#elif defined(NORMALS)
#define SHOWN(seen) vec4((seen).rgb * 0.5 + 0.5, 1.0)
#else
#define SHOWN(seen) seen
#endif

#if defined(SLICES)
#define LOOKUP(atlas) radtex_slices(atlas, u_bucket, uv, I)
#elif defined(LEVELS)
#define LOOKUP(atlas) radtex_sample_level(atlas, u_texels, u_bucket, uv, I, radtex_level(uv, u_texels, LEVELS))
#else
#define LOOKUP(atlas) radtex_sample(atlas, u_texels, u_bucket, uv, I, FILTER)
#endif

#if defined(BASE_ALONE) || defined(BASE_ADDED)  // one value a texel, blended as four texels are
uniform sampler2D u_base;
vec3 base_light(vec2 uv) {
    if (FILTER == RADTEX_QUADRILINEAR) return textureLod(u_base, uv, 0.0).rgb;
    return texelFetch(u_base, clamp(ivec2(floor(uv * vec2(u_texels))), ivec2(0), u_texels - 1), 0).rgb;
}
#endif

#ifdef COVERED  // a layer has no alpha of its own
uniform highp SAMPLER u_whole;
#ifdef RADTEX_PAGES
#define WHOLE u_whole, u_pages
#else
#define WHOLE u_whole
#endif
#define COVER LOOKUP(WHOLE).a
#else
#define COVER 1.0
#endif

// Light (rgb, premultiplied) and alpha towards the viewer in the unit direction V.
vec4 light(vec2 uv, vec3 normal, vec4 tangent, vec3 V) {
    vec3 I = radtex_incidence(V, normal, tangent.xyz, tangent.w);
#if defined(BASE_ALONE)
    return vec4(base_light(uv), COVER);
#elif defined(BASE_ADDED)
    return vec4(base_light(uv) + LOOKUP(ATLAS).rgb, COVER);
#elif defined(COVERED)
    vec4 seen = SHOWN(LOOKUP(ATLAS));
    return vec4(seen.rgb, COVER);
#else
    return SHOWN(LOOKUP(ATLAS));
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
