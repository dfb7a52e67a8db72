// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// One bucket, a pixel a cell, for the inspector. Layered bakes have none in the surface's frame: they are looked up there.

uniform ivec2 u_texel;
uniform int u_side;
uniform vec2 u_point;
uniform vec3 u_normal;
uniform vec4 u_tangent;
out vec4 pixel;
#ifdef LAYERED
uniform vec3 u_place;
#endif
#ifdef RADTEX_IMAGES
uniform vec2 u_images;
#endif
#ifdef SUNLIT
uniform vec3 u_to_sun;
#endif

void main() {
#ifdef LAYERED
    surface_place = u_place;
#endif
#ifdef RADTEX_IMAGES
    surface_images = u_images;
#endif
#ifdef SUNLIT
    to_sun = u_to_sun;
#endif
    ivec2 cell = ivec2(gl_FragCoord.xy);
#ifdef STORED
    pixel = displayed(stored_cell(u_texel, cell));
#else
    vec2 B = (vec2(cell) + 0.5) / float(u_side) * 2.0 - 1.0;
    vec2 A = B * max(abs(B.x), abs(B.y)) / max(length(B), 1e-30);  // square to disc
    vec3 I = vec3(A * sqrt(2.0 - dot(A, A)), 1.0 - dot(A, A));     // disc to direction
    mat3 frame = mat3(radtex_incidence(vec3(1.0, 0.0, 0.0), u_normal, u_tangent.xyz, u_tangent.w),
                      radtex_incidence(vec3(0.0, 1.0, 0.0), u_normal, u_tangent.xyz, u_tangent.w),
                      radtex_incidence(vec3(0.0, 0.0, 1.0), u_normal, u_tangent.xyz, u_tangent.w));
    pixel = displayed(light(u_point, u_normal, u_tangent, I * frame));
#endif
}
