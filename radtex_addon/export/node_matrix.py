# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How an exported glTF's node stood in Blender's world."""

from __future__ import annotations

from typing import cast

import numpy as np

from ..core.arrays import Floats
from ..formats.containers.glb import Glb

_TO_BLENDER = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])  # the inverse of gltf.to_gltf


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
