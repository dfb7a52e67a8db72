// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// What a lookup at one point comes to, in three pixels: I, then B, then the light.

uniform vec2 u_point;
uniform vec3 u_normal, u_viewer;
uniform vec4 u_tangent;
out vec4 pixel;

void main() {
    vec3 I = radtex_incidence(u_viewer, u_normal, u_tangent.xyz, u_tangent.w);
    int which = int(gl_FragCoord.x);
    vec4 seen = light(u_point, u_normal, u_tangent, u_viewer);
    pixel = which == 0 ? vec4(I, 0.0) : which == 1 ? vec4(radtex_bucket(I), 0.0, 0.0) : seen;
}
