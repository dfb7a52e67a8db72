// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// The mesh as its light shows it.

in vec3 v_position, v_normal;
in vec4 v_tangent;
in vec2 v_uv;
uniform vec3 cameraPosition;
out vec4 pixel;

void main() {
#ifdef LAYERED
    surface_place = v_position;
#endif
    vec4 seen = light(v_uv, v_normal, v_tangent, normalize(cameraPosition - v_position));
#ifdef CLEAR
    if (max(seen.a, max(seen.r, max(seen.g, seen.b))) < 0.002) discard;  // else it would hide what lies behind
#endif
    pixel = displayed(seen);
}
