// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// A bake of kind `shadow`, white, in the light of a sun that gives a plane facing it a light of 1.

uniform highp RADTEX_BITS u_bits;
uniform ivec2 u_texels;
uniform int u_bucket;
vec3 to_sun;  // in the space of the surface, set before light()
uniform float u_sun_angle;

#ifdef RADTEX_SHADOW_LAYERS
#define HERE u_bits, here
#else
#define HERE here
#endif
const int POINTS = 32;  // of the sun's disc

vec4 light(vec2 uv, vec3 normal, vec4 tangent, vec3 V) {
    RadtexShadow here = radtex_shadow(u_bits, u_texels, uv);
    mat3 frame = radtex_frame(normal, tangent.xyz, tangent.w);
    vec3 L = to_sun * frame;
    float arriving = u_sun_angle > 0.0 ? radtex_sun(HERE, u_bucket, frame, to_sun, u_sun_angle, POINTS)
        : L.z > 0.0 ? L.z * radtex_visible(HERE, u_bucket, L) : 0.0;
    return vec4(vec3(arriving), 1.0);
}

// One cell of one texel's bucket: white where it is open.
vec4 stored_cell(ivec2 texel, ivec2 cell) {
    RadtexShadow here;
#ifdef RADTEX_SHADOW_LAYERS
    here.nearest = texel;
    here.texels = u_texels;
#else
    here.words[4] = texelFetch(u_bits, texel, 0).xy;
#endif
    return vec4(vec3(radtex_open(HERE, 4, cell.y * u_bucket + cell.x)), 1.0);
}
