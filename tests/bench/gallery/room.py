# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A hall with all that is in it, baked in one go: python -m tests.bench.gallery room

The bake, a quarter of an hour on two cores, is kept in dist/gallery-room; a new one needs that folder gone.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict

import bpy

from radtex_addon.report.gbuffer import eroded
from tests.real.exhibit import ROOT

from ..assets.judging import baked_parts, looked_up
from ..assets.views import Pictures, View, scene_cameras
from ..rooms.baking import bake, kept_costs, room_file, written
from .row import Row

_KEPT = ROOT / "dist/gallery-room"
_SCENE, _SAMPLES = "gallery", 256
_VIEWS = {"view0": "along the hall", "view2": "across", "view4": "a corner"}


def rows() -> Iterator[Row]:
    """Three views at eye height."""
    _KEPT.mkdir(parents=True, exist_ok=True)
    scene, bakes = room_file(_SCENE, _KEPT), _KEPT / "bake"
    bpy.ops.wm.open_mainfile(filepath=str(scene))
    costs = kept_costs(bakes) or bake(scene, [], bakes, [])
    pictures = Pictures(scene, _KEPT, _SAMPLES)
    views = [View(camera, pictures.traced(camera)) for camera in scene_cameras() if camera.name in _VIEWS]
    parts = baked_parts(bakes)
    facts = asdict(written(parts))
    note = (
        f"{len(parts)} objects in {facts['atlases']} atlases, {facts['draw_calls']} draw calls; "
        f"{costs.processor / 60:.0f} minutes of the processor, {facts['megabytes']:.0f} MB of EXR"
    )
    for view in views:
        shown, owner = looked_up(parts, view)
        mask = eroded((owner >= 0).all(axis=2))
        yield Row(f"Room, {_VIEWS[view.name]}", view.reference, shown, mask, note)


def kept_seconds() -> float:
    """What the kept bake has taken by the clock."""
    costs = kept_costs(_KEPT / "bake")
    return 0.0 if costs is None else costs.wall
