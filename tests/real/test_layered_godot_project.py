# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A project with a bake in the layered layout, in a real Godot, against the reference sampler's pictures.

The bake is made up, the mesh is the exhibit's head, so that what is wrong about the places is seen.
"""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.fragments import Fragments
from radtex_addon.export.exporting import export_steps
from radtex_addon.export.gltf import extension_in
from radtex_addon.formats.containers.glb import Glb
from radtex_addon.formats.containers.ktx2 import write_ktx2
from radtex_addon.formats.containers.texture import PixelFormat, encode_texture
from radtex_addon.forms.layered.lookup.atlas import sample_layered
from radtex_addon.forms.layered.shader_values import FULL, shader_facts
from radtex_addon.report.metrics import Picture
from radtex_addon.textures.entry import Arranged, Container, TextureEntry
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.layered_lookups import Case, case_of
from tests.real.exhibit import CAMERAS, Bake, Camera, Exhibit, decibels
from tests.real.godot import RENDERERS, Shot, placed
from tests.real.root import Root

LEAST = 48.0  # dB
MATERIAL = 1
FRONT = CAMERAS[0]


def texture(layer: str, levels: list[Floats], folder: Path) -> TextureEntry:
    """Write a layer's texture; its entry.

    Godot wants all mip levels or none: those after the last are never seen.
    """
    filled, levels = [], list(levels)
    while len(levels) > 1 and len(levels[-1]) > 1:
        levels.append(levels[-1][::2, ::2])
    for level in levels:
        four = np.ones((1, *level.shape[:2], 4), np.float32)
        four[0, ..., : level.shape[2]] = level
        filled.append(four)
    name = f"Head.{layer}.ktx2"
    write_ktx2(folder / name, encode_texture(filled, PixelFormat.RGBA16F), zstd=False, premultiplied=False)
    size = (levels[0].shape[1], levels[0].shape[0])
    kind, arranged = PixelFormat.RGBA16F, Arranged.IMAGE
    return TextureEntry(
        name, Container.KTX2, kind, False, arranged, size, 1, size, size, len(levels), (1, 1), size
    )


def project(bake: Bake, case: Case, folder: Path) -> Path:
    """The exhibit's plain bake, exported; what its .glb says of the bake replaced by a layered one's."""
    place = folder / "project"
    deque(export_steps(bake.sidecar, ExportSpec(Target.GODOT), place), maxlen=0)
    (path,) = place.glob("*.glb")
    glb = Glb.read(path)
    (material,) = glb.document["materials"]
    facts = extension_in(material)
    facts["shader"] = shader_facts(case.sidecar, case.stored, FULL)
    entries = {layer: texture(layer, levels, place) for layer, levels in case.textures.items()}
    facts["textures"] = {layer: entry.facts() for layer, entry in entries.items()}
    facts["material"] = MATERIAL
    glb.write(path)
    return place


def reference(bake: Bake, case: Case, camera: Camera) -> Picture:
    """What the reference sampler sees, (H, W, 3)."""
    buffer = bake.buffer(camera)
    hit = buffer.hit
    fields = (buffer.uv, buffer.normal, buffer.incoming, buffer.position, buffer.tangent, buffer.bitangent)
    uv, normal, viewer, position, tangent, bitangent = (field[hit].astype(np.float32) for field in fields)
    material = np.full(len(uv), MATERIAL)
    seen = sample_layered(case.atlas, Fragments(uv, normal, viewer, position, material, tangent, bitangent))
    return buffer.resolve(buffer.spread(seen))


@pytest.mark.parametrize("name", ["made up", "opaque, in ranges"])
def test_godot_shows_a_layered_bake(name: str, exhibit: Exhibit, root: Root, tmp_path: Path) -> None:
    bake, case = exhibit.plain, case_of(name)
    place = placed(root, project(bake, case, tmp_path))
    shots = [*(Shot(camera) for camera in CAMERAS), Shot(FRONT, turn=70), Shot(FRONT, {"exposure": 0.25})]
    for renderer in RENDERERS:
        for shot, picture in zip(shots, place.pictures(renderer, shots), strict=True):
            wanted = reference(bake, case, shot.camera) * shot.parameters.get("exposure", 1)
            found = decibels(picture, wanted, bake.eroded(shot.camera))
            print(f"{renderer} {name}, {shot.camera.name}, turned by {shot.turn}: {found:.1f} dB")
            assert found > LEAST
    wrong = replace(case.atlas, around=replace(case.atlas.around, middle=case.atlas.around.middle + 0.5))
    elsewhere = reference(bake, replace(case, atlas=wrong), FRONT)
    assert decibels(elsewhere, reference(bake, case, FRONT), bake.eroded(FRONT)) < LEAST
