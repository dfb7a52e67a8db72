// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// A chrome ball: the mirrored ray's first hit on the baked mesh, looked up in the bake. Rays are in Blender's world, z up.

#include <common>
#include <fog_pars_fragment>
#include <logdepthbuf_pars_fragment>
#include <clipping_planes_pars_fragment>
in vec3 v_position, v_eye;
uniform vec3 u_centre, u_chrome, u_sky;
uniform float u_radius;
uniform sampler2D u_tree;
uniform int u_nodes;

vec3 to_blender(vec3 vector) {
    return vec3(vector.x, -vector.z, vector.y);
}

// What leaves a hit, premultiplied by its alpha.
vec4 left_by(RadtexMet met, vec3 ray) {
#ifdef LAYERED
    return vec4(radtex_layered_of(met.material, met.uv, met.position, normalize(met.normal), -ray), radtex_alpha(met.uv));
#else
    return light(met.uv, met.normal, met.tangent, -ray);
#endif
}

vec3 beyond(vec3 from, vec3 ray) {
#if defined(LAYERED) && (defined(RADTEX_MIRRORS) || defined(RADTEX_THROUGH))
    vec3 place = from - radtex_middle.xyz;
    return radtex_shown(place, ray, radtex_met(place, ray), radtex_world_levels.z, vec4(0.0, 0.0, 0.0, 1e6));
#else
    return u_sky;
#endif
}

vec3 mirrored(vec3 from, vec3 ray) {
    vec3 found = vec3(0.0);
    float clear = 1.0, least = 1e-4 * u_radius;
    for (int surface = 0; surface < SURFACES; surface++) {
        RadtexMet met = radtex_trace(u_tree, u_nodes, from, ray, least, CULLED);
        if (met.far < 0.0) return found + clear * beyond(from, ray);
        vec4 left = left_by(met, ray);
        found += clear * left.rgb;
        clear *= 1.0 - left.a;
        if (clear < 0.004) break;
        least = met.far + 1e-4 * u_radius;
    }
    return found;
}

void main() {
    #include <clipping_planes_fragment>
    #include <logdepthbuf_fragment>
    vec3 ray = normalize(isOrthographic ? -v_eye : v_position - v_eye);
    vec3 away = isOrthographic ? v_position - 4.0 * u_radius * ray - u_centre : v_eye - u_centre;
    float along = dot(away, ray), root = along * along - dot(away, away) + u_radius * u_radius;
    if (root < 0.0) discard;
    vec3 N = (away - (along + sqrt(root)) * ray) / u_radius;
    vec3 fresnel = u_chrome + (1.0 - u_chrome) * pow(clamp(1.0 + dot(ray, N), 0.0, 1.0), 5.0);
    vec3 from = u_centre + u_radius * N;
    gl_FragColor = vec4(fresnel * mirrored(to_blender(from), to_blender(reflect(ray, N))), 1.0);
    #include <tonemapping_fragment>
    #include <colorspace_fragment>
    #include <fog_fragment>
}
