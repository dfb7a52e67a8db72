// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// Light of a bake in the layout `shared`. Its directions are Blender's: z up; the page's y is up.

vec3 of_blender(vec3 direction) {
    return vec3(direction.x, -direction.z, direction.y);
}

// Light towards the viewer in the unit direction V; there is no alpha.
vec4 light(vec2 uv, vec3 normal, vec4 tangent, vec3 V) {
    vec3 N = of_blender(normalize(normal));
    V = of_blender(V);
    vec3 sum = radtex_diffuse(u_colour, u_fine, u_irradiance, u_texels, u_falloff, uv, dot(N, V));
#ifdef MIRROR
    sum += mirror_light(uv, reflect(-V, N));
#endif
#ifdef THROUGH
    sum += through_light(uv, -V);
#endif
    return vec4(max(sum, 0.0), 1.0);
}
