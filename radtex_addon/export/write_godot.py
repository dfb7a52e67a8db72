# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A small project for Godot: the mesh with its radiance texture, and a camera that orbits around it."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np

from ..core.arrays import Floats
from ..formats.containers.glb import Glb
from ..textures.godot_shader import GodotShader
from .gltf import extension_in
from .godot_mirror import SCRIPT, mirror_nodes, mirror_shader
from .pack import SHADERS, Pack

TEMPLATES = Path(__file__).with_name("godot_project")
_TO_BLENDER = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])  # the inverse of gltf.to_gltf


def write_godot(pack: Pack, folder: Path) -> None:
    """Make a pack's folder a project: the scene, a material with its shader, the includes, a README.txt."""
    manifest, name = pack.manifest, pack.name
    glb = Glb.read(folder / manifest.mesh)
    shader = manifest.form.godot_shader(manifest.bake, manifest.textures, baked_matrix(glb), manifest.culled)
    mirror = manifest.mirror
    files = {"MATERIAL": f"{name}.material.tres", "SHADER": f"{name}.gdshader", "MESH": manifest.mesh}
    paths = {word: quoted(f"res://{file}") for word, file in files.items()}
    materials = _materials(glb, name)
    ball = f"{name}.mirror.tres"
    resources, node = mirror_nodes(mirror, quoted(f"res://{ball}")) if mirror else ("", "")
    words = {"MIRROR_RESOURCES": resources and f"{resources}\n", "MIRROR_NODE": node and f"{node}\n"}
    facts = (
        paths
        | words
        | {"NAME": quoted(name), "MATERIALS": external_materials(glb.document["materials"], materials)}
    )
    for template in ("project.godot", "main.tscn", "orbit.gd"):
        write_template(folder / template, template, facts)
    write_template(folder / f"{manifest.mesh}.import", "mesh.import", facts)
    write_template(folder / "README.txt", "README.txt", {"NAME": name, **files})
    write_template(folder / files["SHADER"], shader.template, shader.words)
    for file, number in materials.items():
        material = material_text(shader, files["SHADER"], number)
        (folder / file).write_text(material, encoding="utf-8", newline="\n")
    included = dict.fromkeys(shader.includes)
    if mirror:
        own = mirror_shader(shader, manifest, mirror)
        included |= dict.fromkeys(own.includes)
        write_template(folder / SCRIPT, SCRIPT, {})
        write_template(folder / f"{name}.mirror.gdshader", own.template, own.words)
        text = material_text(own, f"{name}.mirror.gdshader")
        (folder / ball).write_text(text, encoding="utf-8", newline="\n")
    (folder / "shaders").mkdir()
    for file in (*(f"{include}.gdshaderinc" for include in included), "LICENSE"):
        shutil.copyfile(SHADERS / file, folder / "shaders" / file)


def _materials(glb: Glb, name: str) -> dict[str, int]:
    """The material files, in the order of the mesh's materials, and the number of each in the shader's."""
    numbers = [extension_in(each).get("material", 0) for each in glb.document["materials"]]
    ends = ["", *(f"-{place}" for place in range(1, len(numbers)))]
    return {f"{name}.material{end}.tres": number for end, number in zip(ends, numbers, strict=True)}


def external_materials(materials: Iterable[Mapping[str, Any]], files: Iterable[str]) -> str:
    """The lines of an import file by which a document's materials are replaced by those files."""
    found = (
        f'{quoted(each["name"])}: {{\n"use_external/enabled": true,\n'
        f'"use_external/path": {quoted(f"res://{file}")}\n}}'
        for each, file in zip(materials, files, strict=True)
    )
    return ",\n".join(found)


def baked_matrix(glb: Glb) -> Floats:
    """The matrix from places of the mesh in our .glb to Blender's world space, (3, 4) float64.

    Its first three columns are that of directions.
    """
    (node,) = (node for node in glb.document["nodes"] if "mesh" in node)
    return matrix_of(node)


def matrix_of(node: Mapping[str, Any]) -> Floats:
    """The same of one node of a document."""
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    turn = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ],
        dtype=np.float64,
    )
    turn *= np.array(node.get("scale", (1, 1, 1)), dtype=np.float64)
    return cast(Floats, _TO_BLENDER @ np.column_stack([turn, node.get("translation", (0, 0, 0))]))


def material_text(shader: GodotShader, file: str, material: int = 0) -> str:
    """A ShaderMaterial as Godot's text resource, to lie beside its textures and its shader, `file`.

    `material` is its number among the shader's.
    """
    lines = [f'[gd_resource type="ShaderMaterial" load_steps={len(shader.textures) + 2} format=3]', ""]
    lines.append(f'[ext_resource type="Shader" path={quoted(file)} id="0"]')
    for number, entry in enumerate(shader.textures.values(), 1):
        kind = "Texture2DArray" if entry.layers > 1 else "Texture2D"
        lines.append(f'[ext_resource type="{kind}" path={quoted(entry.file)} id="{number}"]')
    lines += ["", "[resource]", 'shader = ExtResource("0")']
    parameters = {**shader.parameters, **shader.materials[material]}
    lines += [f"shader_parameter/{name} = {value}" for name, value in parameters.items()]
    for number, uniform in enumerate(shader.textures, 1):
        lines.append(f'shader_parameter/{uniform} = ExtResource("{number}")')
    return "\n".join(lines) + "\n"


def quoted(text: str) -> str:
    """A string in the syntax of Godot's files."""
    return json.dumps(text, ensure_ascii=False)


def write_template(path: Path, template: str, words: Mapping[str, str]) -> None:
    """Write a file of the project: the template with each @WORD@ replaced by its value in `words`."""
    text = (TEMPLATES / template).read_text(encoding="utf-8")
    for word, value in words.items():
        text = text.replace(f"@{word}@", value)
    path.write_text(text, encoding="utf-8", newline="\n")
