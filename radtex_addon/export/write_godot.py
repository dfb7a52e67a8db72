# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A small project for Godot: the bake, the addon that imports it, a scene with a camera and light."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from ..bake.kinds import Kind, Lit
from .godot_addon import copy_addon
from .pack import Pack
from .scene_manifest import ScenePack

TEMPLATES = Path(__file__).with_name("godot_project")
_MIRROR = """\
[node name="Mirror" type="MeshInstance3D" parent="."]
script = ExtResource("4")

"""
_SUN = """\
[node name="Sun" type="DirectionalLight3D" parent="."]
transform = Transform3D(0.7071, -0.4056, 0.5792, 0, 0.8192, 0.5736, -0.7071, -0.4056, 0.5792, 0, 0, 0)

"""
_BLACK = """\
background_mode = 1
background_color = Color(0, 0, 0, 1)
"""
_SKY = """\
background_mode = 2
sky = SubResource("5")
"""
_SKY_RESOURCES = """\
[sub_resource type="ProceduralSkyMaterial" id="6"]

[sub_resource type="Sky" id="5"]
sky_material = SubResource("6")

"""
_MIRROR_RESOURCE = '[ext_resource type="Script" path="res://addons/radtex/mirror.gd" id="4"]\n'


def write_godot(pack: Pack | ScenePack, folder: Path) -> None:
    """Make a pack's folder a project: the addon, a scene that shows its bakes, a README.txt."""
    manifests, name = pack.manifests, pack.name
    lit = {Kind(manifest.bake["kind"]).traits.lit for manifest in manifests}
    mirror = any(manifest.mirror is not None for manifest in manifests)
    words = {
        "NAME": quoted(name),
        "MESH": quoted(f"res://{name}.glb"),
        "MIRROR_RESOURCE": _MIRROR_RESOURCE if mirror else "",
        "MIRROR": _MIRROR if mirror else "",
        "SUN": _SUN if Lit.BY_LAMPS in lit else "",
        "SKY_RESOURCES": _SKY_RESOURCES if Lit.BY_SKY in lit else "",
        "BACKGROUND": _SKY if Lit.BY_SKY in lit else _BLACK,
    }
    for template in ("project.godot", "main.tscn", "orbit.gd"):
        _write(folder / template, template, words)
    _write(folder / "README.txt", "README.txt", {"NAME": name})
    copy_addon(folder)


def quoted(text: str) -> str:
    """A string in the syntax of Godot's files."""
    return json.dumps(text, ensure_ascii=False)


def _write(path: Path, template: str, words: Mapping[str, str]) -> None:
    """Write a file of the project: the template with each @WORD@ replaced by its value in `words`."""
    text = (TEMPLATES / template).read_text(encoding="utf-8")
    for word, value in words.items():
        text = text.replace(f"@{word}@", value)
    path.write_text(text, encoding="utf-8", newline="\n")
