# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The mirror ball of a Godot project: its shader, its material, and its node."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ..formats.containers.texture import PixelFormat
from ..textures.godot_shader import GodotShader, number_list
from .export_manifest import Manifest
from .mirror import Mirror

SCRIPT, TRACE = "mirror.gd", "radtex_trace"
_LAYERED = """\
    vec3 N = normalize(met.normal);
    return vec4(radtex_layered_of(met.material, met.uv, met.position, N, -ray), radtex_alpha(met.uv));"""
_BUCKETS = """\
    return radtex_hit({atlas}, texels, cells, met.uv, ray, met.normal, met.tangent.xyz, met.tangent.w,
                      RADTEX_QUADRILINEAR);"""


def mirror_shader(shader: GodotShader, manifest: Manifest, mirror: Mirror) -> GodotShader:
    """The ball's shader, made of that of the bake."""
    facts = manifest.form.shader_facts(manifest.bake, manifest.textures)
    layered = facts is not None
    opaque = not any(entry.format is PixelFormat.RGBA16F for entry in shader.textures.values())
    defines = {} if facts is None else dict(facts["defines"])
    clear = "RADTEX_ALPHA" in defines if layered else not opaque
    paged = not layered and any(entry.layers > 1 for entry in shader.textures.values())
    own = {"SURFACES": 4 if clear else 1, "CULLED": str(manifest.culled).lower()}
    if facts is not None:
        own["RADTEX_MATERIALS"] = len(facts["materials"])
        if {"RADTEX_MIRRORS", "RADTEX_THROUGH"} & set(defines):
            own["SURROUNDED"] = 1
    else:
        own["RADTEX_PAGES" if paged else "RADTEX_HARDWARE_LINEAR"] = 1
    includes = ("radtex_layered" if layered else "radtex", TRACE)
    words = {
        "DEFINES": "\n".join(f"#define {name} {value}" for name, value in (defines | own).items()),
        "INCLUDES": "\n".join(f'#include "shaders/{name}.gdshaderinc"' for name in includes),
        "UNIFORMS": "" if layered else shader.words["UNIFORMS"],
        "LOOKUP": _LAYERED if layered else _BUCKETS.format(atlas="atlas, pages" if paged else "atlas"),
    }
    values = {name: value for name, value in shader.parameters.items() if not name.startswith("baked")}
    values |= {"nodes": str(mirror.nodes), "sky": f"Vector3({number_list(mirror.sky)})"}
    if facts is not None:
        values |= _of_all(facts["materials"])
    textures = {**shader.textures, "tree": mirror.entry}
    return replace(
        shader,
        template="mirror.gdshader",
        words=words,
        includes=includes,
        parameters=values,
        textures=textures,
        materials=({},),
    )


def _of_all(materials: list[dict[str, Any]]) -> dict[str, str]:
    """The uniforms of all materials, one behind the other."""
    found = {name: [row for each in materials for row in each[name]] for name in materials[0]}
    return {name: f"PackedVector4Array({number_list(rows)})" for name, rows in found.items()}


def mirror_nodes(mirror: Mirror, material: str) -> tuple[str, str]:
    """What a scene file has of the ball: its resources, and its node. `material` is a quoted path."""
    path = mirror.path
    x, y, z = path.middle
    resources = (
        f'[ext_resource type="Script" path="res://{SCRIPT}" id="5"]\n'
        f'[ext_resource type="Material" path={material} id="6"]\n\n'
        '[sub_resource type="SphereMesh" id="7"]\nradial_segments = 128\nrings = 64'
    )
    node = (
        '[node name="Mirror" type="MeshInstance3D" parent="."]\n'
        'mesh = SubResource("7")\nmaterial_override = ExtResource("6")\nscript = ExtResource("5")\n'
        f"middle = Vector3({number_list((x, z, -y))})\nacross = Vector2({number_list(path.across)})\n"
        f"radius = {float(path.radius)!r}\n"
    )
    return resources, node
