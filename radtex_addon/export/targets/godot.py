# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A small project for Godot: the bake, the addon that imports it, a scene with a camera and light.

The addon imports our .glb files; it is its sources with the shader includes that it needs.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path

from ...core.quoting import godot_string, in_comment
from ...settings.kinds import Kind, Lit
from ..export_manifest import Manifest
from ..pack import SHADERS, Pack, ScenePack, filled, write_text_file
from . import Writer

ADDON = Path("addons", "radtex")  # where Godot's asset library and every project have it
TEMPLATES = Path(__file__).parents[1] / "godot_project"
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


def copy_addon(project: Path) -> Path:
    """Copy the addon into a project's folder, where it must not be yet; returns its folder there."""
    addon = project / ADDON
    shutil.copytree(SHADERS / "godot" / ADDON, addon)
    (addon / "lookups").mkdir()
    for lookup in SHADERS.glob("*.gdshaderinc"):
        shutil.copyfile(lookup, addon / "lookups" / lookup.name)
    return addon


def write_godot(pack: Pack | ScenePack, folder: Path) -> None:
    """Make a pack's folder a project: the addon, a scene that shows its bakes, a README.txt."""
    manifests, name = pack.manifests, pack.name
    lit = {Kind(manifest.bake["kind"]).traits.lit for manifest in manifests}
    mirror = any(manifest.mirror is not None for manifest in manifests)
    words = {
        "NAME": godot_string(name),
        "MESH": godot_string(f"res://{name}.glb"),
        "MIRROR_RESOURCE": _MIRROR_RESOURCE if mirror else "",
        "MIRROR": _MIRROR if mirror else "",
        "SUN": _SUN if Lit.BY_LAMPS in lit else "",
        "SKY_RESOURCES": _SKY_RESOURCES if Lit.BY_SKY in lit else "",
        "BACKGROUND": _SKY if Lit.BY_SKY in lit else _BLACK,
    }
    for template in ("project.godot", "main.tscn", "orbit.gd"):
        write_text_file(folder / template, filled(TEMPLATES / template, words))
    about = "a radiance texture" if len(manifests) == 1 else f"a scene of {len(manifests)} radiance textures"
    files = "\n".join(map(in_comment, _files_to_copy(manifests)))
    readme = {"NAME": in_comment(name), "WHAT": about, "FILES": files}
    write_text_file(folder / "README.txt", filled(TEMPLATES / "README.txt", readme))
    copy_addon(folder)


def _files_to_copy(manifests: Sequence[Manifest]) -> list[str]:
    """The names of the files that the addon reads: the glTF, and the textures of each bake."""
    textures = [entry.file for manifest in manifests for entry in manifest.textures.values()]
    mirrors = [manifest.mirror.entry.file for manifest in manifests if manifest.mirror is not None]
    return list(dict.fromkeys([manifests[0].mesh, *textures, *mirrors]))


WRITER = Writer(write_godot, write_godot)
