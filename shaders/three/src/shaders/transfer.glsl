// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// A bake of kind `transfer` in the light of a sun.

uniform SAMPLER u_transfer;
uniform ivec4 u_pages; // columns, rows, texels of a page across and up
uniform ivec2 u_texels;
uniform int u_bucket, u_views;
uniform vec3 u_irradiance;
vec3 to_sun;  // in the space of the surface, set before light()

#ifdef RADTEX_PAGES
#define ATLAS u_transfer, u_pages
#else
#define ATLAS u_transfer
#endif

vec4 light(vec2 uv, vec3 normal, vec4 tangent, vec3 V) {
    vec3 L = radtex_incidence(to_sun, normal, tangent.xyz, tangent.w);
#ifdef AROUND
    vec3 I = radtex_incidence(V, normal, tangent.xyz, tangent.w);
    vec4 answer = radtex_transfer_around(ATLAS, u_texels, u_views, u_bucket, uv, I, L);
#else
    vec4 answer = radtex_transfer(ATLAS, u_texels, u_bucket, uv, L);
#endif
    return answer * vec4(u_irradiance, 1.0);
}

// One cell of one texel's map, as it is stored, of the middle view: under an irradiance of 1.
vec4 stored_cell(ivec2 texel, ivec2 cell) {
    return radtex_sphere_cell(ATLAS, texel * u_views + u_views / 2, u_bucket, cell);
}
