// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// One lobe of a shared bake. For LOBE stands its name, mirror or through.

#ifdef CONDENSED
uniform sampler2D u_LOBE_weights, u_LOBE_ends_xy, u_LOBE_ends_zs, u_LOBE_gain, u_LOBE_rest;
uniform vec4 u_LOBE_ranges[12];

vec3 LOBE_light(vec2 uv, vec3 axis) {
    return radtex_condensed_lobe(u_LOBE_weights, u_LOBE_ends_xy, u_LOBE_ends_zs, u_LOBE_gain, u_LOBE_rest,
                                 u_LOBE_ranges, u_columns, u_bucket, u_texels, u_surroundings, u_around, uv, axis);
}
#else
uniform sampler2D u_LOBE_ends, u_LOBE_gain, u_LOBE_rest;

vec3 LOBE_light(vec2 uv, vec3 axis) {
    return radtex_lobe(u_LOBE_ends, u_LOBE_gain, u_LOBE_rest, u_bucket, u_surroundings, u_around, uv, axis);
}
#endif
