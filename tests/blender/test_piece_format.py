# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pieces of another format are neither gone on with nor deleted unasked, in both layouts and on farms."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.bake.key import workers
from radtex_addon.bake.piece_format import PIECE_FORMAT
from radtex_addon.bake.progress import Stage
from radtex_addon.bake.spec import BakeSpec, Layout
from radtex_addon.core.errors import FormatError, InputError
from radtex_addon.formats.disk.hidden_folder import mark_of
from radtex_addon.job import bake_object, bake_steps
from tests.blender.farming import BOX, assembled, build_moving_scene, prepared
from tests.blender.killed import digests
from tests.blender.room import fill_room

pytestmark = pytest.mark.one_blender

context: Any = bpy.context  # to the stubs, every pointer may be None

FOLDER = "Ball.radiance.radtex-unfinished"
SPECS = {
    "tiles": (BakeSpec(texels=16, bucket=4, samples=1), Stage.CAPTURE),
    "fills of hidden cells": (BakeSpec(texels=16, bucket=4, samples=1), Stage.FILL),
    "layered": (BakeSpec(layout=Layout.LAYERED, texels=24, bucket=14, samples=1), Stage.CAPTURE),
}


def ended_in(at: Stage, spec: BakeSpec, out: Path) -> list[str]:
    """End a bake in a stage, once something of it is done; the names of what is left."""
    steps = bake_steps(context.scene, "Ball", spec, out)
    for step in steps:
        if step.stage is at and step.done:
            steps.close()
            break
    return sorted(path.name for path in (out / FOLDER).iterdir())


@pytest.mark.parametrize("what", SPECS)
def test_pieces_of_another_format_are_refused_and_a_new_bake_is_whole(
    what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill_room()
    spec, at = SPECS[what]
    out = tmp_path / "out"
    with monkeypatch.context() as earlier:
        earlier.setattr("radtex_addon.bake.piece_format.PIECE_FORMAT", PIECE_FORMAT - 1)
        kept = ended_in(at, spec, out)
    assert any(name.endswith(".piece") for name in kept)
    said = (
        f"holds pieces of format {PIECE_FORMAT - 1}, this RadTex makes those of format {PIECE_FORMAT}: "
        "go on with the RadTex that made them, or begin anew"
    )
    with pytest.raises(InputError, match=said):
        bake_object(context.scene, "Ball", spec, out, resume=True)
    with pytest.raises(InputError, match="holds an unfinished bake"):
        bake_object(context.scene, "Ball", spec, out)
    assert sorted(path.name for path in (out / FOLDER).iterdir()) == kept, "nothing is deleted unasked"
    left = out / f"{mark_of(workers(out / FOLDER)[0])}left"  # as when it was killed while it wrote
    left.touch()
    bake_object(context.scene, "Ball", spec, out, overwrite=True)
    assert not left.exists()
    bake_object(context.scene, "Ball", spec, tmp_path / "whole")
    assert digests(out) == digests(tmp_path / "whole")


def test_frames_of_another_format_are_not_joined(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    spec = BakeSpec(texels=16, bucket=2, samples=1)
    scene = build_moving_scene(tmp_path)
    with monkeypatch.context() as earlier:
        earlier.setattr("radtex_addon.bake.piece_format.PIECE_FORMAT", PIECE_FORMAT + 1)
        farm = prepared(scene, spec, tmp_path / "far").files.folder
    frames = digests(farm)
    said = (
        f"are of format {PIECE_FORMAT + 1}, this RadTex joins those of format {PIECE_FORMAT}: assemble with"
    )
    with pytest.raises(FormatError, match=re.escape(said)):
        assembled(farm)
    assert digests(farm) == frames
    assert not list((tmp_path / "far").glob(f"{BOX}.radiance.exr"))
