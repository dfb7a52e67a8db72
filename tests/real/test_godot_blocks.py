# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The project of a layered bake in blocks, in a real Godot, as it is exported: what blocks lose."""

from __future__ import annotations

from collections import deque
from pathlib import Path

import pytest

from radtex_addon.export.exporting import export_steps
from radtex_addon.textures.export_spec import ExportSpec, Target, TextureFormat
from tests.real.exhibit import CAMERAS, Exhibit, decibels
from tests.real.godot import RENDERERS, Shot, placed
from tests.real.root import Root

LEAST = {  # dB against the reference
    TextureFormat.AUTO: 38.0,
    TextureFormat.KTX2_BC6H: 38.0,
    TextureFormat.KTX2_RGBA16F: 40.0,
}


@pytest.mark.parametrize("form", LEAST)
def test_godot_shows_a_layered_bake_in_blocks(
    form: TextureFormat, exhibit: Exhibit, root: Root, tmp_path: Path
) -> None:
    bake = exhibit.layered
    deque(export_steps(bake.sidecar, ExportSpec(Target.GODOT, form), tmp_path / "project"), maxlen=0)
    place = placed(root, tmp_path / "project")
    shots = [Shot(camera) for camera in CAMERAS]
    for renderer in RENDERERS:
        for shot, picture in zip(shots, place.pictures(renderer, shots), strict=True):
            found = decibels(picture, bake.picture(shot.camera), bake.eroded(shot.camera))
            print(f"{form}, {renderer}, {shot.camera.name}: {found:.1f} dB")
            assert found >= LEAST[form]
