// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// A bake of kind `transfer` in the light of a sun.

uniform sampler2D u_transfer;
uniform ivec2 u_texels;
uniform int u_bucket;
uniform vec3 u_to_sun, u_irradiance;

vec4 light(vec2 uv, vec3 normal, vec4 tangent, vec3 V) {
    vec3 L = radtex_incidence(u_to_sun, normal, tangent.xyz, tangent.w);
    return radtex_transfer(u_transfer, u_texels, u_bucket, uv, L) * vec4(u_irradiance, 1.0);
}

// One cell of one texel's map, as it is stored: under an irradiance of 1.
vec4 stored_cell(ivec2 texel, ivec2 cell) {
    return texelFetch(u_transfer, texel * u_bucket + cell, 0);
}
