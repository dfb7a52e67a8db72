# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A Godot project of a whole scene: the meshes with their radiance textures, and a camera."""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..formats.containers.glb import Glb
from ..formats.sidecar import safe_name
from .export_manifest import Manifest
from .gltf import extension_in
from .pack import SHADERS
from .scene_manifest import ScenePack
from .write_godot import external_materials, material_text, matrix_of, quoted, write_template

_README = """\
{name}, a scene of radiance textures: open project.godot in Godot 4.6 and press F5; drag to turn, wheel to
come closer. Exposure and filter are parameters of the objects' materials, NAME.material.tres.
For a project of yours copy all but project.godot, main.tscn and orbit.gd, side by side.
Levels of detail are in {mesh}, but Godot does not import them.
"""


def write_godot_scene(pack: ScenePack, folder: Path) -> None:
    """Make a scene's folder a project: scene, materials with their shaders, includes, a README.txt."""
    glb = Glb.read(folder / pack.mesh)
    materials: dict[str, str] = {}  # files, by the names of the glTF's materials
    manifests = {each.node: each.manifest for entry in pack.entries for each in (entry, *entry.levels)}
    for node in glb.document["nodes"]:
        shape = glb.document["meshes"][node["mesh"]]
        used = [glb.document["materials"][part["material"]] for part in shape["primitives"]]
        materials |= _write_materials(node, used, manifests[node["name"]], folder)
    named = {each["name"]: each for each in glb.document["materials"]}
    lines = external_materials([named[name] for name in materials], materials.values())
    words = {
        "NAME": quoted(pack.name),
        "MESH": quoted(f"res://{pack.mesh}"),
        "MATERIALS": lines,
        "MIRROR_RESOURCES": "",
        "MIRROR_NODE": "",
    }
    for template in ("project.godot", "main.tscn", "orbit.gd"):
        write_template(folder / template, template, words)
    write_template(folder / f"{pack.mesh}.import", "mesh.import", words)
    text = _README.format(name=pack.name, mesh=pack.mesh)
    (folder / "README.txt").write_text(text, encoding="utf-8", newline="\n")


def _write_materials(
    node: Mapping[str, Any], used: list[dict[str, Any]], manifest: Manifest, folder: Path
) -> dict[str, str]:
    """Write a node's materials with their shader and its includes; their files by the materials' names."""
    shader = manifest.form.godot_shader(manifest.bake, manifest.textures, matrix_of(node), manifest.culled)
    shader_file = f"{manifest.name}.gdshader"
    write_template(folder / shader_file, shader.template, shader.words)
    shaders = folder / "shaders"
    shaders.mkdir(exist_ok=True)
    for file in (*(f"{include}.gdshaderinc" for include in shader.includes), "LICENSE"):
        shutil.copyfile(SHADERS / file, shaders / file)
    files = {}
    for place, material in enumerate(used):
        end = f"-{place}" if place else ""
        file = f"{safe_name(node['name'])}.material{end}.tres"
        text = material_text(shader, shader_file, extension_in(material).get("material", 0))
        (folder / file).write_text(text, encoding="utf-8", newline="\n")
        files[material["name"]] = file
    return files
