# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The frame in uv sets, and the mesh turned and scaled as its node says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.export.unity_unreal import apply_turn_and_scale, baked_matrix, carry_frame
from radtex_addon.formats.containers.glb import Glb

NORMAL, TANGENT = np.array([0.6, 0.0, 0.8]), np.array([0.8, 0.0, -0.6])


def triangle(scale: tuple[float, float, float]) -> Glb:
    """One triangle that its normal points away from, under a turned and scaled node."""
    up = np.cross(NORMAL, TANGENT)
    node = {"mesh": 0, "rotation": [0.5, 0.5, 0.5, 0.5], "scale": list(scale), "translation": [1, 2, 3]}
    document: dict[str, Any] = {"nodes": [node], "meshes": [{"primitives": [{"attributes": {}}]}]}
    glb = Glb(document, bytearray())
    values = {
        "POSITION": np.stack([np.zeros(3), TANGENT, up]),
        "NORMAL": np.tile(NORMAL, (3, 1)),
        "TANGENT": np.tile([*TANGENT, 1.0], (3, 1)),
    }
    (primitive,) = document["meshes"][0]["primitives"]
    primitive["attributes"] = {name: glb.add_vertices(array) for name, array in values.items()}
    view = glb.add_view(np.arange(3, dtype="<u2").tobytes())
    document["accessors"].append({"bufferView": view, "componentType": 5123, "count": 3, "type": "SCALAR"})
    primitive["indices"] = 3
    return glb


def corners(glb: Glb) -> Floats:
    """The triangle's corners in the world of the bake, in order, (3, 3)."""
    (primitive,) = glb.document["meshes"][0]["primitives"]
    baked = baked_matrix(glb)
    places = glb.accessor(primitive["attributes"]["POSITION"]) @ baked[:, :3].T + baked[:, 3]
    return np.asarray(places[glb.accessor(primitive["indices"])])


@pytest.mark.parametrize("scale", [(1.0, 1.0, 1.0), (2.0, 0.5, 3.0), (-2.0, 0.5, 3.0)])
def test_the_frame_is_the_bakes_and_the_mesh_stays_where_it_was(scale: tuple[float, float, float]) -> None:
    glb = triangle(scale)
    baked, before = baked_matrix(glb)[:, :3], corners(glb)
    carry_frame(glb)
    apply_turn_and_scale(glb)
    (primitive,) = glb.document["meshes"][0]["primitives"]
    sets = [glb.accessor(primitive["attributes"][f"TEXCOORD_{k}"])[0] for k in range(1, 5)]
    tangent, side, normal = np.array([*sets[0], sets[1][0]]), sets[1][1], np.array([*sets[2], sets[3][0]])
    np.testing.assert_allclose(tangent, baked @ TANGENT, atol=1e-6)
    assert abs(normal @ tangent) < 1e-6  # normals stay at right angles to the surface
    assert abs(normal @ (baked @ np.cross(NORMAL, TANGENT))) < 1e-6
    # The bitangent, where v grows, is mirrored with the mesh.
    assert side * np.cross(normal, tangent) @ (baked @ np.cross(NORMAL, TANGENT)) > 0
    after = corners(glb)
    np.testing.assert_allclose(np.sort(after, axis=0), np.sort(before, axis=0), atol=1e-6)
    outwards = np.cross(after[1] - after[0], after[2] - after[0])
    assert outwards @ normal > 0  # its front is where it was
    assert set(glb.document["nodes"][0]) == {"mesh", "translation"}
