# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A whole scene exported for Godot: each of its objects is shown by its own bake."""

from __future__ import annotations

from pathlib import Path

import pytest
from scipy.ndimage import binary_dilation

from radtex_addon.bake.progress import finished
from radtex_addon.export.exporting_scene import export_scene_steps
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.real.exhibit import CAMERAS, Bake, Exhibit, Form, decibels
from tests.real.godot import Shot, placed
from tests.real.root import Root

LEAST = 38.0  # dB


@pytest.mark.parametrize("form", Form)
def test_an_object_in_a_scene_looks_as_the_reference(
    form: Form, exhibit: Exhibit, room: list[Path], root: Root, tmp_path: Path
) -> None:
    bake: Bake = getattr(exhibit, form)
    sidecars = [room[-3], bake.sidecar, *room[-2:]]
    made = finished(export_scene_steps(sidecars, ExportSpec(Target.GODOT), "Room", tmp_path / "project"))
    project = placed(root, made.folder)
    parameters = {"filtering": 2.0} if form is Form.PLAIN else {}
    shots = [Shot(camera, parameters) for camera in CAMERAS]
    for shot, picture in zip(shots, project.pictures("Compatibility", shots), strict=True):
        found = decibels(picture, bake.picture(shot.camera), bake.eroded(shot.camera))
        print(f"{form}, {shot.camera.name}: {found:.1f} dB")
        assert found > LEAST
        beside = picture[~binary_dilation(bake.inside(shot.camera), iterations=2)]
        assert (beside.max() > 0.1) == (shot.camera.name == "left"), "behind the head are the trees, once"
