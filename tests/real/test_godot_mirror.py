# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The Godot project's mirror ball in a real Godot, against Cycles' pictures of the same ball.

With RADTEX_FIGURES=docs/figures the pictures are kept: path traced above, Godot's below.
"""

from __future__ import annotations

from collections import deque
from pathlib import Path

import pytest

from radtex_addon.export.exporting import export_steps
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.real.exhibit import Form, decibels
from tests.real.godot import ALL_RENDERERS, Shot, placed
from tests.real.mirror_scene import CAMERA, LEAST, PLACES, RADIUS, SKY, Stage, keep_row
from tests.real.root import Root


@pytest.mark.parametrize("form", Form)
def test_the_ball_shows_what_cycles_shows(
    form: Form, stages: dict[Form, Stage], root: Root, tmp_path: Path
) -> None:
    stage = stages[form]
    spec = ExportSpec(Target.GODOT, mirror=True, sky=SKY)
    deque(export_steps(stage.bake.sidecar, spec, tmp_path / "project"), maxlen=0)
    project = placed(root, tmp_path / "project")
    shots = [Shot(CAMERA, mirror=(*place, RADIUS)) for place in PLACES]
    shots.append(Shot(CAMERA, turn=70, mirror=(*PLACES[0], RADIUS)))
    for renderer in ALL_RENDERERS:
        taken = project.pictures(renderer, shots)
        keep_row(f"mirror-godot-{form}-{renderer}", [*stage.pictures], taken[: len(PLACES)])
        for number, picture in enumerate(taken):
            which = number % len(PLACES)
            found = decibels(picture, stage.reference(which), stage.inside[which])
            print(
                f"{renderer} {form}, ball at {PLACES[which]}, turned by {shots[number].turn}: {found:.1f} dB"
            )
            assert found >= LEAST
            other = (which + 1) % len(PLACES)
            assert decibels(picture, stage.reference(other), stage.inside[which]) < LEAST
