# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The baselines' lookups in GLSL, as an engine would write them: `shade` for `drawing.Painter`."""

from __future__ import annotations

_FLAT = """
uniform sampler2D colour, light;
vec3 diffuse() { return texture(colour, uv).rgb * texture(light, uv).rgb; }
"""
_FRAME = """
vec3 in_frame(vec3 direction) {
    vec3 N = normalize(normal), T = normalize(tangent.xyz - N * dot(N, tangent.xyz));
    return vec3(dot(direction, T), dot(direction, tangent.w * cross(N, T)), dot(direction, N));
}
"""
LIGHTMAP = (
    _FLAT
    + """
uniform sampler2D rest;
vec4 shade() { return vec4(diffuse() + texture(rest, uv).rgb, 1.0); }
"""
)
_HARMONICS = (
    "0.282095", "0.488603 * d.y", "0.488603 * d.z", "0.488603 * d.x", "1.092548 * d.x * d.y",
    "1.092548 * d.y * d.z", "0.315392 * (3.0 * d.z * d.z - 1.0)", "1.092548 * d.x * d.z",
    "0.546274 * (d.x * d.x - d.y * d.y)", "0.590044 * d.y * (3.0 * d.x * d.x - d.y * d.y)",
    "2.890611 * d.x * d.y * d.z", "0.457046 * d.y * (5.0 * d.z * d.z - 1.0)",
    "0.373176 * d.z * (5.0 * d.z * d.z - 3.0)", "0.457046 * d.x * (5.0 * d.z * d.z - 1.0)",
    "1.445306 * d.z * (d.x * d.x - d.y * d.y)", "0.590044 * d.x * (d.x * d.x - 3.0 * d.y * d.y)",
)  # fmt: skip


def harmonics(count: int) -> str:
    """Of 9 or 16 spherical harmonics, in an array texture of as many layers."""
    terms = "".join(
        f"    seen += ({term}) * texture(layers, vec3(uv, {number}.0)).rgb;\n"
        for number, term in enumerate(_HARMONICS[:count])
    )
    return f"""{_FLAT}{_FRAME}
uniform sampler2DArray layers;
vec4 shade() {{
    vec3 d = in_frame(normalize(camera - position)), seen = diffuse();
{terms}    return vec4(max(seen, vec3(0.0)), 1.0);
}}
"""


def gaussians(count: int) -> str:
    """Of spherical Gaussians, in an array texture of as many layers; `axes` is a uniform."""
    return f"""{_FLAT}{_FRAME}
uniform sampler2DArray layers;
uniform vec3 axes[{count}];
uniform float sharpness;
vec4 shade() {{
    vec3 d = in_frame(normalize(camera - position)), seen = diffuse();
    for (int lobe = 0; lobe < {count}; lobe++)
        seen += exp(sharpness * (dot(axes[lobe], d) - 1.0)) * texture(layers, vec3(uv, float(lobe))).rgb;
    return vec4(seen, 1.0);
}}
"""


PROBE = (
    _FLAT
    + """
uniform sampler2D surface, occlusion, split_sum;
uniform samplerCube probe;
uniform vec3 middle, low, high;
vec4 shade() {
    vec3 N = normalize(normal), V = normalize(camera - position), R = reflect(-V, N);
    vec3 given = texture(surface, uv).rgb;  // metallic, roughness, specular level
    float cosine = clamp(dot(N, V), 0.001, 1.0), alpha = given.y * given.y;
    vec3 towards = mix(R, N, alpha * alpha);
    vec3 far = max((high - position) / towards, (low - position) / towards);
    vec3 met = position + towards * min(min(far.x, far.y), far.z) - middle;
    vec3 mirrored = textureLod(probe, met, given.y * 6.0).rgb;
    vec3 base = texture(colour, uv).rgb, frontal = mix(vec3(0.08 * given.z), base, given.x);
    vec2 split = texture(split_sum, vec2(cosine, given.y)).rg;
    vec3 share = frontal * split.x + split.y;
    share *= 1.0 + frontal * (1.0 / max(split.x + split.y, 0.001) - 1.0);
    float open = texture(occlusion, uv).r;
    float visible = clamp(pow(cosine + open, exp2(-16.0 * alpha - 1.0)) - 1.0 + open, 0.0, 1.0);
    vec3 diffused = base * texture(light, uv).rgb * (1.0 - share) * (1.0 - given.x);
    return vec4(diffused + share * mirrored * visible, 1.0);
}
"""
)
FETCHES = {"lightmap": 3, "sh": 11, "sh3": 18, "sg": 11, "probe": 6}
