# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports of `shadow` and `ao`: the very bits in a KTX2, and what is refused by name."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.progress import finished
from radtex_addon.bake.spec import BakeSpec
from radtex_addon.core.errors import InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.export.export_manifest import read_manifest
from radtex_addon.export.exporting import export_steps
from radtex_addon.formats.containers.ktx2 import read_ktx2
from radtex_addon.formats.containers.texture import PixelFormat
from radtex_addon.formats.shadow_files import read_shadow_of
from radtex_addon.job import bake_object
from radtex_addon.textures.entry import Arranged
from radtex_addon.textures.export_spec import ExportSpec, Target, TextureFormat

pytestmark = pytest.mark.one_blender
context: Any = bpy.context


def baked(kind: str, out: Path, cells: int = 8) -> Path:
    """The sidecar of a floor's bake, below a ball."""
    bpy.ops.mesh.primitive_plane_add(size=2)
    context.object.name = "Floor"
    bpy.ops.mesh.primitive_ico_sphere_add(radius=0.4, location=(0.2, 0.1, 0.5))
    spec = BakeSpec(kind=kind, texels=12, bucket=cells, samples=2)  # type: ignore[arg-type]
    return bake_object(context.scene, "Floor", spec, out, preview=Filter.NEAREST).files.sidecar


@pytest.mark.parametrize(
    ("cells", "kind", "vk_format", "layers"),
    [
        (5, PixelFormat.R32UI, 98, 1),
        (8, PixelFormat.RG32UI, 101, 1),
        (12, PixelFormat.RG32UI, 101, 3),
    ],
)
def test_a_shadows_words_come_back_bit_by_bit(
    out: Path, cells: int, kind: PixelFormat, vk_format: int, layers: int
) -> None:
    sidecar = baked("shadow", out, cells)
    made = finished(export_steps(sidecar, ExportSpec(Target.RAW)))
    assert "shaders/radtex_shadow.glsl" in made.files
    manifest = read_manifest(made.folder / "Floor.export.json")
    entry = manifest.textures["shadow"]
    assert (entry.format, entry.layers, entry.arrangement) == (kind, layers, Arranged.WORDS)
    file = made.folder / entry.file
    assert struct.unpack_from("<I", file.read_bytes(), 12) == (vk_format,)
    texture = read_ktx2(file)
    assert texture.is_array is (layers > 1)
    words, facts = read_shadow_of(sidecar)
    stored = np.ascontiguousarray(texture.levels[0]).view("<u4")  # layers, rows, columns, words
    joined = stored.transpose(1, 2, 0, 3).reshape(facts.height, facts.width, -1)
    np.testing.assert_array_equal(joined[..., : words.shape[2]], words)
    assert not joined[..., words.shape[2] :].any()


def test_bits_have_one_format(out: Path) -> None:
    sidecar = baked("shadow", out)
    with pytest.raises(InputError, match="holds bits, not light: leave the format out"):
        finished(export_steps(sidecar, ExportSpec(Target.RAW, TextureFormat.KTX2_RGBA16F)))
    with pytest.raises(InputError, match="not blended: leave the arrangement and the levels out"):
        finished(export_steps(sidecar, ExportSpec(Target.RAW, levels=2)))
