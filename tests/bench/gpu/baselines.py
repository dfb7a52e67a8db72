# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a lookup is compared with, in GLSL: `shade` for `drawing.Painter`, with as few fetches as it needs.

All take a map of the base colour and one of roughness and metallic, each times a material's factors, as
engines have them, and know the surroundings as a cube of levels of growing roughness.

DIFFUSE is a colour and one lamp. The probes are a lightmap of diffuse light and the split sum: Karis, "Real
Shading in Unreal Engine 4" (2013); `BOX` makes them parallax-corrected: Lagarde and Zanuttini, "Local
Image-Based Lighting with Parallax-Corrected Cubemaps" (2012).

PHYSICAL does what three.js's MeshPhysicalMaterial does without sheen and transmission, by the same published
formulas. Lamps: GGX (Walter et al., "Microfacet Models for Refraction through Rough Surfaces", 2007), Smith's
height-correlated masking (Heitz, "Understanding the Masking-Shadowing Function", 2014), Fresnel by Schlick
(1994), Lambert's diffuse light. Surroundings: two levels of a prefiltered picture, mixed, times a fitted
split sum (Karis, "Physically Based Shading on Mobile", 2014), with the light that bounces between microfacets
(Fdez-Agüera, "A Multiple-Scattering Microfacet Model for Real-Time Image-based Lighting", 2019), and diffuse
light from the roughest level. A coat of its own roughness lies over all; a thin film, `FILM`, is that of
Belcour and Barla, "A Practical Extension to Microfacet Theory for the Modeling of Varying Iridescence"
(2017), as KHR_materials_iridescence writes it down.
"""

from __future__ import annotations

from ..fidelity.thin_film import PLACE, SECOND, TO_REC709, VALUE, VARIANCE, WHITE

_BASE = """
uniform sampler2D base_map;
uniform vec3 base_factor;
vec3 base_colour() {
    return texture(base_map, uv).rgb * base_factor;
}
"""
DIFFUSE = (
    _BASE
    + """
vec4 shade() {
    return vec4(base_colour() * max(dot(normalize(normal), vec3(0.36, -0.48, 0.8)), 0.1), 1.0);
}
"""
)
_SURFACE = (
    _BASE
    + """
uniform sampler2D surface_map;
uniform vec3 surface_factor;  // roughness, metallic, frontal reflectance of what is no metal
uniform samplerCube probe_map;
"""
)
PROBE = (
    _SURFACE
    + """
uniform sampler2D light_map, split_map;
uniform vec4 light_range;  // part of the map, scale and offset
#ifdef BOX
uniform vec3 middle, low, high;
#endif
vec4 shade() {
    vec3 N = normalize(normal), V = normalize(camera - position), R = reflect(-V, N);
    vec2 given = texture(surface_map, uv).gb * surface_factor.xy;
    vec3 base = base_colour(), frontal = mix(vec3(surface_factor.z), base, given.y);
    float cosine = clamp(dot(N, V), 0.001, 1.0);
#ifdef BOX
    vec3 far = max((high - position) / R, (low - position) / R);
    R = position + R * min(min(far.x, far.y), far.z) - middle;
#endif
    vec3 mirrored = textureLod(probe_map, R, given.x * LAST_LEVEL).rgb;
    vec2 split = texture(split_map, vec2(cosine, given.x)).rg;
    vec3 share = frontal * split.x + split.y;
    vec3 light = texture(light_map, uv * light_range.xy).rgb * light_range.z + light_range.w;
    return vec4(base * light * (1.0 - given.y) * (1.0 - share) + share * mirrored, 1.0);
}
"""
)
_NUMBERS = f"""
const vec3 VALUE = vec3({VALUE[0]}, {VALUE[1]}, {VALUE[2]});
const vec3 PLACE = vec3({PLACE[0]}, {PLACE[1]}, {PLACE[2]});
const vec3 VARIANCE = vec3({VARIANCE[0]}, {VARIANCE[1]}, {VARIANCE[2]});
const vec3 SECOND = vec3({SECOND[0]}, {SECOND[1]}, {SECOND[2]});
const mat3 TO_REC709 = mat3({", ".join(str(value) for value in TO_REC709.T.ravel())});
const float WHITE = {WHITE};
"""
_FILM = (
    _NUMBERS
    + """
vec3 schlick_of(vec3 frontal, float cosine) {
    return frontal + (1.0 - frontal) * pow(1.0 - cosine, 5.0);
}

// The eye's response in Rec.709 to a path difference in nanometres, shifted.
vec3 sensitivity(float path, vec3 shift) {
    float phase = 6.2831853e-9 * path;
    vec3 xyz = VALUE * sqrt(6.2831853 * VARIANCE) * cos(PLACE * phase + shift)
        * exp(-phase * phase * VARIANCE);
    xyz.x += SECOND.x * sqrt(6.2831853 * SECOND.z) * cos(SECOND.y * phase + shift.x)
        * exp(-phase * phase * SECOND.z);
    return TO_REC709 * (xyz / WHITE);
}

// The frontal reflectance with which Schlick's formula gives that of a film at this cosine.
vec3 filmed(vec3 frontal, float cosine, float thickness, float ior) {
    float inner = sqrt(1.0 - (1.0 - cosine * cosine) / (ior * ior));
    float surface = (ior - 1.0) / (ior + 1.0);
    vec3 outer = schlick_of(vec3(surface * surface), cosine), passed = 1.0 - outer;
    vec3 root = sqrt(clamp(frontal, 0.0, 0.9999)), base = (1.0 + root) / (1.0 - root);
    vec3 gap = (base - ior) / (base + ior), under = schlick_of(gap * gap, inner);
    vec3 phase = vec3(3.1415927) + 3.1415927 * vec3(lessThan(base, vec3(ior)));
    vec3 both = clamp(outer * under, 1e-5, 0.9999);
    vec3 through = passed * passed * under / (1.0 - both), light = outer + through, bounce = through - passed;
    float path = 2.0 * ior * thickness * inner;
    for (int number = 1; number <= 2; number++) {
        bounce *= sqrt(both);
        light += 2.0 * bounce * sensitivity(float(number) * path, float(number) * phase);
    }
    float edge = min(pow(1.0 - cosine, 5.0), 0.9999);
    return clamp((max(light, 0.0) - edge) / (1.0 - edge), 0.0, 1.0);
}
"""
)
PHYSICAL = (
    _SURFACE
    + """
uniform vec3 coat;  // its weight, roughness and frontal reflectance
#ifdef FILM
uniform vec2 film;  // its thickness and index
"""
    + _FILM
    + """
#endif
#if LAMPS > 0
uniform vec3 lamp_place[LAMPS], lamp_light[LAMPS];  // irradiance of what faces it a unit away
#endif

vec3 surroundings(vec3 direction, float roughness) {
    float level = roughness * LAST_LEVEL, lower = floor(level);
    vec3 sharper = textureLod(probe_map, direction, lower).rgb;
    return mix(sharper, textureLod(probe_map, direction, min(lower + 1.0, LAST_LEVEL)).rgb, level - lower);
}

vec3 fresnel(vec3 frontal, float cosine) {
    float away = 1.0 - cosine, squared = away * away;
    return frontal + (1.0 - frontal) * (squared * squared * away);
}

// GGX's share of light from L that goes to V, without Fresnel.
float mirrored(float roughness, float NL, float NV, float NH) {
    float alpha = roughness * roughness, squared = alpha * alpha;
    float peak = NH * NH * (squared - 1.0) + 1.0;
    float masked = NL * sqrt(NV * NV * (1.0 - squared) + squared);
    masked += NV * sqrt(NL * NL * (1.0 - squared) + squared);
    return squared / (3.1415927 * peak * peak) * 0.5 / max(masked, 1e-6);
}

// Scale and bias of the frontal reflectance in even surroundings.
vec2 split_sum(float roughness, float cosine) {
    vec4 r = roughness * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    float a = min(r.x * r.x, exp2(-9.28 * cosine)) * r.x + r.y;
    return vec2(-1.04, 1.04) * a + r.zw;
}

vec4 shade() {
    vec3 N = normalize(normal), V = normalize(camera - position), R = reflect(-V, N);
    vec2 given = texture(surface_map, uv).gb * surface_factor.xy;
    float roughness = max(given.x, 0.0525), coated = max(coat.y, 0.0525), NV = clamp(dot(N, V), 0.001, 1.0);
    vec3 base = base_colour(), diffuse = base * (1.0 - given.y);
    vec3 frontal = mix(vec3(surface_factor.z), base, given.y);
#ifdef FILM
    frontal = film.x > 0.0 ? filmed(frontal, NV, film.x, film.y) : frontal;
#endif
    vec3 light = vec3(0.0), over = vec3(0.0);
#if LAMPS > 0
    for (int number = 0; number < LAMPS; number++) {
        vec3 towards = lamp_place[number] - position;
        float nearness = inversesqrt(dot(towards, towards));
        vec3 L = towards * nearness, H = normalize(L + V);
        float NL = max(dot(N, L), 0.0), NH = max(dot(N, H), 0.0), VH = clamp(dot(V, H), 0.0, 1.0);
        vec3 arriving = lamp_light[number] * (nearness * nearness * NL);
        over += arriving * fresnel(vec3(coat.z), VH) * mirrored(coated, NL, NV, NH);
        light += arriving * (fresnel(frontal, VH) * mirrored(roughness, NL, NV, NH) + diffuse / 3.1415927);
    }
#endif
    vec2 split = split_sum(roughness, NV);
    vec3 once = frontal * split.x + split.y, mean = frontal + (1.0 - frontal) / 21.0;
    float missing = 1.0 - split.x - split.y;
    vec3 again = once * mean / (1.0 - missing * mean) * missing;
    vec3 even = textureLod(probe_map, N, LAST_LEVEL).rgb;
    light += once * surroundings(normalize(mix(R, N, given.x * given.x)), roughness) + again * even;
    light += diffuse * (1.0 - max(max(once.r + again.r, once.g + again.g), once.b + again.b)) * even;
    vec2 of_coat = split_sum(coated, NV);
    over += (coat.z * of_coat.x + of_coat.y) * surroundings(R, coated);
    light = light * (1.0 - coat.x * fresnel(vec3(coat.z), NV)) + coat.x * over;
    return vec4(light, 1.0);
}
"""
)
