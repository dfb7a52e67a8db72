// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// The flat lightmap: one colour a point, from everywhere the same. Its texture is glTF's, whose v grows downwards.

uniform sampler2D u_flat;
uniform float u_flat_scale;

vec4 light(vec2 uv, vec3 normal, vec4 tangent, vec3 V) {
    vec4 shown = texture(u_flat, vec2(uv.x, 1.0 - uv.y));
    return vec4(shown.rgb / u_flat_scale * shown.a, shown.a);
}
