# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh that is compressed by EXT_meshopt_compression, read again by the extension's specification."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import FormatError, InputError
from radtex_addon.export.quantised import MESHOPT, QUANTIZATION, compress, quantise
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.textures.export_spec import ExportSpec, MeshPacking, Target
from tests.reference.meshopt import expanded

SIDE = 40  # quads along each side


def ball(parts: int = 2) -> Glb:
    """A ball of unconnected triangles in so many primitives, as a glTF of floats, with an image behind."""
    glb = Glb(
        {"asset": {"version": "2.0"}, "meshes": [{"primitives": []}], "nodes": [{"mesh": 0}]}, bytearray()
    )
    u, v = np.meshgrid(np.linspace(0, 1, SIDE + 1), np.linspace(0.02, 0.98, SIDE + 1), indexing="ij")
    row, column = np.divmod(np.arange(SIDE * SIDE), SIDE)
    corner = row * (SIDE + 1) + column
    quad = np.stack(
        [corner, corner + SIDE + 1, corner + SIDE + 2, corner, corner + SIDE + 2, corner + 1], axis=1
    )
    for part in np.array_split(np.random.default_rng(1).permutation(quad.reshape(-1, 3)), parts):
        u_, v_ = u.ravel()[part.ravel()], v.ravel()[part.ravel()]
        around, down = 2 * np.pi * u_, np.pi * v_
        normal = np.stack(
            [np.sin(down) * np.cos(around), np.cos(down), np.sin(down) * np.sin(around)], axis=1
        )
        tangent = np.stack([-np.sin(around), 0 * around, np.cos(around), np.where(u_ < 0.5, 1, -1)], axis=1)
        attributes = {
            "POSITION": glb.add_vertices(3 * normal + [7, -1, 0], bounds=True),
            "NORMAL": glb.add_vertices(normal),
            "TANGENT": glb.add_vertices(tangent),
            "TEXCOORD_0": glb.add_vertices(np.stack([u_, v_], axis=1)),
        }
        indices = glb.add_indices(np.arange(len(u_)))
        glb.document["meshes"][0]["primitives"].append({"attributes": attributes, "indices": indices})
    image = glb.add_view(bytes(range(251)))
    glb.document["images"] = [{"bufferView": image, "mimeType": "image/png"}]
    return glb


def corners(glb: Glb, part: dict[str, Any]) -> dict[str, Floats]:
    """What each triangle's corners have, in an order that does not depend on that of the file."""
    indices = glb.accessor(part["indices"]).reshape(-1, 3)
    values = {name: glb.accessor(index) for name, index in part["attributes"].items()}
    uv = np.rint(values["TEXCOORD_0"].astype(np.float64) * 4 * SIDE)
    key = (uv[:, 0] * 1000 + uv[:, 1])[indices]
    turn = (key.argmin(axis=1)[:, None] + np.arange(3)) % 3
    indices = np.take_along_axis(indices, turn, axis=1)
    indices = indices[np.lexsort(np.take_along_axis(key, turn, axis=1).T)]
    return {name: each[indices] for name, each in values.items()}


def written(glb: Glb, path: Path) -> Glb:
    glb.compact()
    compress(glb)
    glb.write(path)
    return Glb.read(path)


def test_a_compressed_mesh_is_the_same_in_fewer_bytes(tmp_path: Path) -> None:
    exact, plain, packed = ball(), ball(), ball()
    quantise(plain, Target.WEB.traits, (512, 512))
    plain.compact()
    plain.write(tmp_path / "plain.glb")
    quantise(packed, Target.WEB.traits, (512, 512), compressed=True)
    found = written(packed, tmp_path / "packed.glb")
    document = found.document
    for key in ("extensionsUsed", "extensionsRequired"):
        assert document[key] == [MESHOPT, QUANTIZATION]
    first, second = document["buffers"]
    assert second["extensions"] == {MESHOPT: {"fallback": True}}
    assert 0 <= len(found.buffer) - first["byteLength"] < 4
    with pytest.raises(FormatError, match=f"compressed by {MESHOPT}"):
        found.accessor(0)
    assert (tmp_path / "packed.glb").stat().st_size < (tmp_path / "plain.glb").stat().st_size / 4
    read = expanded(found)
    image = document["bufferViews"][document["images"][0]["bufferView"]]
    assert bytes(read.buffer[image["byteOffset"] :][: image["byteLength"]]) == bytes(range(251))
    for one, other in zip(
        exact.document["meshes"][0]["primitives"], document["meshes"][0]["primitives"], strict=True
    ):
        before, after = corners(exact, one), corners(read, other)
        np.testing.assert_allclose(after["POSITION"], before["POSITION"], atol=6 / 2**20)
        for name in ("NORMAL", "TANGENT"):
            np.testing.assert_allclose(after[name], before[name], atol=1.6e-4)
        np.testing.assert_array_equal(after["TANGENT"][..., 3], before["TANGENT"][..., 3])
        np.testing.assert_allclose(after["TEXCOORD_0"], before["TEXCOORD_0"], atol=0.51 / 65535)
        accessor = document["accessors"][other["attributes"]["POSITION"]]
        places = read.accessor(other["attributes"]["POSITION"])
        assert accessor["count"] < 3 * SIDE * SIDE, "equal vertices are one"
        assert (accessor["min"], accessor["max"]) == (
            places.min(axis=0).tolist(),
            places.max(axis=0).tolist(),
        )


def test_pieces_of_a_mesh_still_meet(tmp_path: Path) -> None:
    """Places that were equal are equal, also where one primitive is far smaller than the other."""
    glb = ball(parts=7)
    quantise(glb, Target.WEB.traits, (512, 512), compressed=True)
    read = expanded(written(glb, tmp_path / "packed.glb"))
    parts = read.document["meshes"][0]["primitives"]
    places = np.concatenate([read.accessor(part["attributes"]["POSITION"]) for part in parts])
    rounded = np.unique(np.rint(places * 1000), axis=0)
    assert len(np.unique(places, axis=0)) == len(rounded)


def test_what_would_not_get_smaller_stays_as_it_is(tmp_path: Path) -> None:
    """A single triangle: no program needs the extension for it."""
    glb = ball(parts=1)
    (part,) = glb.document["meshes"][0]["primitives"]
    part["indices"] = glb.add_indices(np.arange(3))
    quantise(glb, Target.WEB.traits, (512, 512), compressed=True)
    found = written(glb, tmp_path / "one.glb")
    assert MESHOPT not in found.document["extensionsUsed"]
    assert found.accessor(found.document["meshes"][0]["primitives"][0]["indices"]).tolist() == [0, 1, 2]


def test_who_gets_a_compressed_mesh() -> None:
    assert ExportSpec(Target.WEB).compressed
    assert not ExportSpec(Target.WEB, mesh=MeshPacking.PLAIN).compressed
    assert not ExportSpec(Target.GLTF).compressed
    assert ExportSpec(Target.GLTF, mesh=MeshPacking.MESHOPT).compressed
    with pytest.raises(InputError, match="mesh meshopt: unity does not read it, web, gltf do"):
        ExportSpec(Target.UNITY, mesh=MeshPacking.MESHOPT)
