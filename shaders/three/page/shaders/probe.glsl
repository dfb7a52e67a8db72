// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// What a lookup at one point comes to, in three pixels: the direction that is asked for, in the frame, where it lies
// in the bucket, in [-1, 1]^2, and the light.

uniform vec2 u_point;
uniform vec3 u_normal, u_viewer;
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

#ifdef SUNLIT
#define ASKED u_to_sun
#else
#define ASKED u_viewer
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
    vec3 I = radtex_incidence(ASKED, u_normal, u_tangent.xyz, u_tangent.w);
#ifdef SPHERE
    vec2 B = radtex_sphere(I) * 2.0 - 1.0;
#else
    vec2 B = radtex_bucket(I);
#endif
    int which = int(gl_FragCoord.x);
    vec4 seen = light(u_point, u_normal, u_tangent, u_viewer);
    pixel = which == 0 ? vec4(I, 0.0) : which == 1 ? vec4(B, 0.0, 0.0) : seen;
}
