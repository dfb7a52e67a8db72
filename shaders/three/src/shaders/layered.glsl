// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// Light of a bake in the layout `layered`. Its places and directions are Blender's: z up; the page's y is up.

vec3 surface_place;  // in the page's world, set before light()
#ifdef RADTEX_IMAGES
vec2 surface_images;  // texture coordinates of the material's own images, likewise
#endif

vec3 of_blender(vec3 vector) {
    return vec3(vector.x, -vector.z, vector.y);
}

// Light towards the viewer in the unit direction V, premultiplied by alpha.
vec4 light(vec2 uv, vec3 normal, vec4 tangent, vec3 V) {
    vec3 N = of_blender(normalize(normal)), place = of_blender(surface_place);
#ifdef RADTEX_IMAGES
    vec3 face = of_blender(normal), along = of_blender(tangent.xyz);
    vec3 seen = radtex_layered_images(uv, surface_images, place, along, tangent.w * cross(face, along), face, of_blender(V));
#elif defined(RADTEX_THROUGH)
    vec3 T = of_blender(tangent.xyz);
    T = normalize(T - dot(T, N) * N);
    vec3 seen = radtex_layered_through(uv, place, N, of_blender(V), T, tangent.w * cross(N, T));
#else
    vec3 seen = radtex_layered(uv, place, N, of_blender(V));
#endif
    return vec4(seen, radtex_alpha(uv));
}
