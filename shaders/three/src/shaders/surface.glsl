// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// The mesh as its light shows it, with what three.js adds: tone mapping, fog, clipping planes, logarithmic depth.

#include <common>
#include <fog_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
// Centroid: at the rim of a triangle a pixel's middle may lie beyond it, where the mesh, and its map, has nothing.
centroid in vec3 v_position, v_normal, v_eye;
centroid in vec4 v_tangent;
centroid in vec2 v_uv;
flat in vec4 v_instance;
#ifndef LAMPS
uniform vec3 u_own;
#endif
uniform vec3 u_tint;
uniform float u_exposure, u_opacity;
#ifdef IMAGES
centroid in vec2 v_uv_images;
#endif
#ifdef SUNLIT
centroid in vec3 v_to_sun;
#endif

void main() {
    #include <clipping_planes_fragment>
    float opacity = u_opacity * v_instance.a;
    if (opacity <= 0.0) discard;  // else it would hide what lies behind
    #include <logdepthbuf_fragment>
#ifdef LAYERED
    surface_place = v_position;
#endif
#ifdef IMAGES
    surface_images = v_uv_images;
#endif
#ifdef SUNLIT
    to_sun = normalize(v_to_sun);
#endif
    vec3 V = normalize(isOrthographic ? v_eye : v_eye - v_position);
    vec4 seen = light(v_uv, v_normal, v_tangent, V);
#ifdef LAMPS
    seen.rgb = light_of_lamps(seen.rgb, v_position, v_uv, v_normal, v_tangent, V);
#else
    seen.rgb *= u_own;
#endif
    seen.rgb *= u_exposure * u_tint * v_instance.rgb;
#ifdef CLEAR
    if (max(seen.a, max(seen.r, max(seen.g, seen.b))) < 0.002) discard;  // else it would hide what lies behind
#endif
#ifdef BLENDED
    // Browsers blend display values: tone and fog act on the light where it covers, and it may cover more than its
    // alpha says where it is brighter than white, or glows without hiding anything.
    vec3 exposed = seen.rgb;
#ifdef TONE_MAPPING
    exposed *= toneMappingExposure;
#endif
    float cover = clamp(max(seen.a, max(max(exposed.r, exposed.g), exposed.b)), 1e-6, 1.0);
    gl_FragColor = vec4(seen.rgb / cover, seen.a);
#elif defined(SOLID)
    gl_FragColor = vec4(seen.rgb, 1.0);  // the canvas is blended over the page
#else
    gl_FragColor = seen;
#endif
    #include <tonemapping_fragment>
    #include <colorspace_fragment>
    #include <fog_fragment>
#ifdef BLENDED
    gl_FragColor.rgb *= cover;
#endif
    gl_FragColor *= opacity;  // premultiplied
}
