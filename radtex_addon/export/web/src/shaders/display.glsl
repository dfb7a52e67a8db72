// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// From light to what a screen shows. The tone curves are three.js's (tonemapping_pars_fragment).

uniform int u_tone;  // -1: light as it is, for readers of numbers

vec4 displayed(vec4 light) {
    if (u_tone < 0) return light;
    vec3 shown = u_tone == 1 ? ACESFilmicToneMapping(light.rgb)
        : u_tone == 2 ? AgXToneMapping(light.rgb)
        : u_tone == 3 ? NeutralToneMapping(light.rgb)
        : light.rgb * toneMappingExposure;
    shown = clamp(shown, 0.0, 1.0);
    return vec4(mix(shown * 12.92, 1.055 * pow(shown, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, shown)), light.a);
}
