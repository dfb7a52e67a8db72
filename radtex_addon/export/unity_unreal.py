# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the folders for Unity and Unreal share: the frame in the mesh, and materials as HLSL."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import cast

import numpy as np

from ..core.arrays import Floats
from ..core.frame import normalised
from ..formats.containers.glb import Glb
from ..forms.hlsl_lookup import HlslLookup, Number
from ..scene.mesh.copy import MATERIAL
from ..textures.entry import TextureEntry

IMAGE_SETS = "RADTEX_IMAGE_UVS"  # defined where uv set 0 is that of materials' own images
_TO_GLTF = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # from Blender's axes: gltf.to_gltf
_TO_BLENDER = _TO_GLTF.T


def define_lines(defines: Mapping[str, int | str]) -> str:
    """The #defines, one a line."""
    return "\n".join(f"#define {name} {value}" for name, value in defines.items())


def constant_lines(constants: Iterable[Number]) -> str:
    """Constants of a file, outside functions."""
    lines = []
    for each in constants:
        if each.count:
            rows = ",\n    ".join(each.rows)
            lines.append(f"static const {each.kind} {each.name}[{each.count}] = {{\n    {rows}\n}};")
        else:
            lines.append(f"static const {each.kind} {each.name} = {each.rows[0]};")
    return "\n".join(lines)


def texture_type(entry: TextureEntry) -> str:
    """A texture's type in HLSL."""
    return "Texture2DArray" if entry.layers > 1 else "Texture2D"


def material_numbers(glb: Glb) -> dict[str, int]:
    """The mesh's materials by name, in order, and the number of each among the shader's."""
    return {each["name"]: each.get("extras", {}).get(MATERIAL, 0) for each in glb.document["materials"]}


def is_clear(glb: Glb, lookup: HlslLookup) -> bool:
    """Whether something of the surface lets what is behind it be seen.

    Materials that are shown by their own images may be clear by the bake's map alone.
    """
    blended = any(each.get("alphaMode") == "BLEND" for each in glb.document["materials"])
    return blended or "RADTEX_ALPHA" in lookup.defines


def attributes_line(images: bool) -> str:
    """What the mesh's uv sets hold, for a README; `images` where materials have images of their own."""
    if images:
        return "TEXCOORD_0 is that of the images, TEXCOORD_1 the baked UV layer, TEXCOORD_2 to 5 its frame."
    return "TEXCOORD_0 is the baked UV layer, TEXCOORD_1 to 4 its frame."


def identifier(name: str, kind: str) -> str:
    """A name for assets and for files of code; C# and Python take it behind a letter or underscore."""
    return re.sub(r"\W", "_", f"{name}_{kind}", flags=re.ASCII)


def indented(text: str, depth: int = 4) -> str:
    """Lines that begin so many spaces farther in."""
    return "\n".join(f"{' ' * depth}{line}" if line else line for line in text.removesuffix("\n").split("\n"))


def baked_matrix(glb: Glb) -> Floats:
    """The matrix from places of the mesh in our .glb to Blender's world space, (3, 4) float64.

    Its first three columns are that of directions.
    """
    (node,) = (node for node in glb.document["nodes"] if "mesh" in node)
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


def carry_frame(glb: Glb) -> None:
    """Move each primitive's tangents into four more uv sets, with the normals, both in the world of the bake.

    They are not normalised, so that they are interpolated as the bake's own are; but where materials are
    shown by their own images: a normal map weighs one by the other. TANGENT goes away: what no shader reads,
    an importer need not turn. NORMAL stays, for the shadows of engines.
    """
    baked = baked_matrix(glb)[:, :3]
    of_normals, mirrored = np.linalg.inv(baked).T, np.sign(np.linalg.det(baked))
    for mesh in glb.document["meshes"]:
        for primitive in mesh["primitives"]:
            attributes = primitive["attributes"]
            of_file: Floats = glb.accessor(attributes["NORMAL"])
            frame: Floats = glb.accessor(attributes.pop("TANGENT"))
            normal: Floats = of_file @ of_normals.T
            tangent: Floats = frame[:, :3] @ baked.T
            side = frame[:, 3] * mirrored
            of_images = "TEXCOORD_1" in attributes
            if of_images:
                normal, tangent = normalised(normal), normalised(tangent)
            sets = [
                tangent[:, :2],
                np.column_stack([tangent[:, 2], side]),
                normal[:, :2],
                np.column_stack([normal[:, 2], np.zeros(len(normal))]),
            ]
            for number, values in enumerate(sets, 2 if of_images else 1):
                attributes[f"TEXCOORD_{number}"] = glb.add_vertices(values)
    glb.compact()


def apply_turn_and_scale(glb: Glb) -> None:
    """Turn and scale the mesh as its node does, which then only moves it.

    For importers that make an asset of the mesh alone, which is to be as large as it was in Blender. The
    frame must have been carried before.
    """
    (node,) = (node for node in glb.document["nodes"] if "mesh" in node)
    turned = _TO_GLTF @ baked_matrix(glb)[:, :3]
    of_normals = np.linalg.inv(turned).T
    for mesh in glb.document["meshes"]:
        for primitive in mesh["primitives"]:
            attributes = primitive["attributes"]
            places = glb.accessor(attributes["POSITION"]) @ turned.T
            normals = np.asarray(glb.accessor(attributes["NORMAL"]) @ of_normals.T, dtype=np.float64)
            attributes["POSITION"] = glb.add_vertices(places, bounds=True)
            attributes["NORMAL"] = glb.add_vertices(normalised(normals))
            if np.linalg.det(turned) < 0:  # a mirrored triangle goes around the other way
                _reverse_triangles(glb, primitive["indices"])
    node.pop("rotation", None)
    node.pop("scale", None)
    glb.compact()


def _reverse_triangles(glb: Glb, index: int) -> None:
    """Exchange the first and the last corner of each triangle, in place."""
    triangles = np.ascontiguousarray(glb.accessor(index).reshape(-1, 3)[:, ::-1])
    accessor = glb.document["accessors"][index]
    view = glb.document["bufferViews"][accessor["bufferView"]]
    first = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    glb.buffer[first : first + triangles.nbytes] = triangles.tobytes()
