# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertices of a glTF in fewer bytes: 16 or 8 bits a number where nobody sees the difference.

Places stay floats: 16 bits save four bytes a vertex, but scale the node, by which lookups would see other
normals and tangents, and programs that move it another object space.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..formats.containers.glb import Glb, Values
from ..settings.targets import TargetTraits

QUANTIZATION = "KHR_mesh_quantization"
_MOST_TEXELS = 2048  # along an atlas's side: coordinates are at most 1/64 of a texel off


def quantise(glb: Glb, traits: TargetTraits, texels: tuple[int, int], layered: bool) -> None:
    """Store in fewer bits what the target's loaders read so, in place; `Glb.compact` drops the former values.

    `texels` are the width and height of the bake's atlas. Texture coordinates are core glTF; they stay floats
    where one of them is outside [0, 1], or if the atlas is so large that rounding could be seen. Normals and
    tangents need `KHR_mesh_quantization`. A normal has 16 bits, since chrome shows 8, and so has a tangent
    where a shader may take the nearest cell of a bucket; bakes that are `layered` are always interpolated.
    """
    frame = {"NORMAL": "<i2", "TANGENT": "i1" if layered else "<i2"} if traits.quantised else {}
    short = traits.short_coordinates and max(texels) <= _MOST_TEXELS
    done: dict[int, int] = {}
    for mesh in glb.document["meshes"]:
        for primitive in mesh["primitives"]:
            attributes = primitive["attributes"]
            for name, index in attributes.items():
                if index not in done:
                    done[index] = _stored(glb, name, index, frame, short)
                attributes[name] = done[index]
    if traits.quantised:
        for key in ("extensionsUsed", "extensionsRequired"):
            glb.document[key] = sorted({*glb.document.get(key, []), QUANTIZATION})


def _stored(glb: Glb, name: str, index: int, frame: Mapping[str, str], short: bool) -> int:
    """The index of an attribute's accessor in fewer bits, or its own."""
    if name in frame:
        return glb.add_vertices(glb.accessor(index), dtype=frame[name])
    if short and name.startswith("TEXCOORD_"):
        values = glb.accessor(index)
        if _in_unit(values):
            return glb.add_vertices(values, dtype="<u2")
    return index


def _in_unit(values: Values) -> bool:
    inside: Any = (values >= 0) & (values <= 1)
    return bool(inside.all())
