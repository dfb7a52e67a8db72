// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// From light to what a screen shows. The tone curves are three.js's (tonemapping_pars_fragment).

uniform int u_tone;  // -1: light as it is, for readers of numbers

// Browsers blend display values: the curves are those of the light where it covers, and it may cover more than its
// alpha says where it is brighter than white, or glows without hiding anything.
vec4 displayed(vec4 light) {
    if (u_tone < 0) return light;
    vec3 exposed = light.rgb * toneMappingExposure;
    float cover = clamp(max(light.a, max(max(exposed.r, exposed.g), exposed.b)), 1e-6, 1.0);
    vec3 own = light.rgb / cover;
    vec3 shown = u_tone == 1 ? ACESFilmicToneMapping(own)
        : u_tone == 2 ? AgXToneMapping(own)
        : u_tone == 3 ? NeutralToneMapping(own)
        : own * toneMappingExposure;
    shown = clamp(shown, 0.0, 1.0);
    shown = mix(shown * 12.92, 1.055 * pow(shown, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, shown));
    return vec4(shown * cover, light.a);
}
