# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What engines' importers make of a mesh in glTF, after their public sources, written anew."""

from __future__ import annotations

from typing import Any

import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.formats.containers.glb import Glb

CENTIMETRES = 100


def gltfast(attributes: dict[str, Floats]) -> dict[str, Floats]:
    """Unity's package com.unity.cloud.gltfast 6.14, Runtime/Scripts/Jobs.cs: its jobs of float32.

    x of positions and normals is negated, but z of tangents, whose w is kept; each v becomes 1 - v.
    """
    flips = {"POSITION": [-1, 1, 1], "NORMAL": [-1, 1, 1], "TANGENT": [1, 1, -1, 1]}
    return {name: _each(name, values, flips) for name, values in attributes.items()}


def unreal(attributes: dict[str, Floats]) -> dict[str, Floats]:
    """Unreal's GLTFCore, ConvertVec3: y and z are exchanged, metres become centimetres, uv is as in glTF."""
    found = {}
    for name, values in attributes.items():
        turned = values if name.startswith("TEXCOORD") else values[:, [0, 2, 1]]
        found[name] = (turned * (CENTIMETRES if name == "POSITION" else 1)).astype(np.float32)
    return found


def attributes_of(glb: Glb, primitive: int = 0) -> dict[str, Floats]:
    """The attributes of the one mesh's primitive, by name."""
    (mesh,) = glb.document["meshes"]
    indices: dict[str, Any] = mesh["primitives"][primitive]["attributes"]
    return {name: glb.accessor(index) for name, index in indices.items()}


def _each(name: str, values: Floats, flips: dict[str, list[int]]) -> Floats:
    values = values.astype(np.float32)
    if name.startswith("TEXCOORD"):
        return np.stack([values[:, 0], np.float32(1) - values[:, 1]], axis=1)
    return np.asarray(values * np.array(flips[name], np.float32))
