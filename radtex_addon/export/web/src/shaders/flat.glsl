// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// The flat lightmap: one colour a point, from everywhere the same.

uniform sampler2D u_flat;
uniform float u_flat_scale;

vec4 light(vec2 uv, vec3 normal, vec4 tangent, vec3 V) {
    vec4 shown = texture(u_flat, uv);
    vec3 linear = mix(shown.rgb / 12.92, pow((shown.rgb + 0.055) / 1.055, vec3(2.4)), step(0.04045, shown.rgb));
    return vec4(linear / u_flat_scale * shown.a, shown.a);
}
