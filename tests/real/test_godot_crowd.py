# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Instances of a MultiMesh in Godot, each turned in its own way: they look as the same nodes do.

A MultiMesh draws its instances in their order, and the backs of mirrored ones: what is blended does not
overlap here, and of the hull, which is culled, none is mirrored.
With RADTEX_FIGURES=docs/figures godot-crowd.png is kept: path traced, then instances.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from PIL import Image

from radtex_addon.core.arrays import Floats
from radtex_addon.export.exporting import export_steps
from radtex_addon.report.metrics import Picture, display
from radtex_addon.scene.demo import OBJECT
from radtex_addon.settings.spec import Kind
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.bench.gallery import looking
from tests.bench.gallery.looking import rendered
from tests.real.exhibit import CAMERAS, Bake, Camera, Exhibit, Form, decibels, stage
from tests.real.godot import RENDERERS, Placed, Shot, placed
from tests.real.kinds import KindBake, Sun
from tests.real.root import Root

FRONT = CAMERAS[0]
LEAST = 36.0  # dB against the reference, of small heads; 20 and less where each is lit as the node is turned
TRACED = 24.0  # dB against path tracing, of which a bake with two samples falls short; 19 and less likewise
SAME = 45.0  # dB between instances and nodes: a matrix is multiplied in another order
FIGURES = os.environ.get("RADTEX_FIGURES")
SUN = Sun(-40, 45, strength=3)


def turned(angle: float, axis: Sequence[float], place: Sequence[float], scale: Sequence[float]) -> Floats:
    """A matrix (4, 4) that scales, turns by `angle` degrees about an axis, and moves."""
    x, y, z = np.array(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    radians = np.radians(angle)
    turn = np.eye(3) + np.sin(radians) * cross + (1 - np.cos(radians)) * cross @ cross
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = turn * scale, place
    return matrix


STANDING = [(70, -0.75), (-120, 0.75)]  # degrees, and how far aside
SAMPLES = 64
FROM_GODOT = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
# Turned, of two sizes, stretched, mirrored: in Godot's axes, about the head's place.
COPIES = [
    turned(70, (0, 1, 0), (-0.8, 0.5, 0), (0.5, 0.5, 0.5)),
    turned(-130, (1, 2, 3), (0.8, 0.5, 0), (0.6, 0.6, 0.6)),
    turned(200, (0, 1, 1), (-0.6, -0.6, 0.3), (0.5, 0.35, 0.6)),
    turned(40, (1, 0, 1), (0.9, -0.5, 0), (-0.5, 0.5, 0.5)),
]


def project(sidecar: Path, root: Root, folder: Path) -> Placed:
    deque(export_steps(sidecar, ExportSpec(Target.GODOT), folder / "export"), maxlen=0)
    return placed(root, folder / "export")


def check_the_same(place: Placed, shot: Shot, name: str) -> None:
    """By both kinds of renderers, and what is seen is neither black nor all the same."""
    for renderer in RENDERERS:
        crowd, nodes = place.pictures(renderer, [replace(shot, as_nodes=way) for way in (False, True)])
        seen = nodes.max(axis=2) > 0.001
        found = decibels(crowd, nodes, seen)
        print(f"{name}, {renderer}: {found:.1f} dB over {seen.mean():.0%} of the picture")
        assert seen.mean() > 0.1
        assert np.std(nodes[seen]) > 0.01
        assert found > SAME


@pytest.mark.parametrize("form", Form)
def test_instances_look_as_nodes_do(form: Form, exhibit: Exhibit, root: Root, tmp_path: Path) -> None:
    bake: Bake = getattr(exhibit, form)
    check_the_same(project(bake.sidecar, root, tmp_path), Shot(FRONT, copies=COPIES), form)


def test_turned_instances_show_what_is_path_traced(exhibit: Exhibit, root: Root, tmp_path: Path) -> None:
    """Each as the head looks from where the camera stands before it; and nothing as its neighbour looks."""
    bake = exhibit.layered
    place = project(bake.sidecar, root, tmp_path)
    copies = [turned(angle, (0, 1, 0), (aside, 0.15, 0), (0.42,) * 3) for angle, aside in STANDING]
    cameras = [seen_by(copy) for copy in copies]
    (crowd,) = place.pictures("Compatibility", [Shot(FRONT, copies=copies)])
    stage(Form.LAYERED)
    traced = [path_traced(camera) for camera in cameras]
    expected = [bake.picture(camera) for camera in cameras]
    for number, camera in enumerate(cameras):
        mask = bake.eroded(camera)
        found, near = (decibels(crowd, light[number], mask) for light in (expected, traced))
        print(f"turned by {STANDING[number][0]}: {found:.1f} dB, path traced {near:.1f} dB")
        assert found > LEAST
        assert near > TRACED
    shown = zip(cameras, traced, strict=True)
    alone = [np.where(bake.inside(camera)[..., None], seen, 0) for camera, seen in shown]
    _keep("godot-crowd", [sum(alone[1:], alone[0]), crowd])


def seen_by(copy: Floats) -> Camera:
    """The camera that sees the head as FRONT sees a copy, which is turned about the vertical."""
    back = np.linalg.inv(FROM_GODOT @ copy @ FROM_GODOT.T)
    place, target = ((back @ [*each, 1])[:3] for each in (FRONT.place, FRONT.target))
    return replace(FRONT, place=tuple(place.tolist()), target=tuple(target.tolist()))


def path_traced(camera: Camera) -> Picture:
    """The open scene's light (H, W, 3), rows from the top, its head alone seen by the camera."""
    for item in bpy.data.objects:
        item.visible_camera = item.name == OBJECT
    lens = 18 / np.tan(np.radians(camera.fovy) / 2)
    seen: Picture = rendered(looking.Camera(camera.place, camera.target, lens=lens), SAMPLES)[..., :3]
    return seen


@pytest.mark.parametrize("kind", [Kind.SHADOW, Kind.TRANSFER, Kind.AO, Kind.PROXY])
def test_instances_of_other_kinds_look_as_nodes_do(
    kind: Kind, kind_bake: Callable[[Kind], KindBake], root: Root, tmp_path: Path
) -> None:
    lit: dict[str, Any] = {"sky": (1, 0)} if kind is Kind.AO else {"sun": SUN}
    place = project(kind_bake(kind).sidecar, root, tmp_path)
    copies = COPIES[:1] + COPIES[2:3] if kind is Kind.PROXY else COPIES
    check_the_same(place, Shot(FRONT, copies=copies, **lit), kind)


def _keep(name: str, strip: list[Picture]) -> None:
    """Keep pictures side by side, if somebody asked for them."""
    if FIGURES:
        shown = display(np.concatenate(strip, axis=1))
        image = Image.fromarray((shown * 255 + 0.5).astype(np.uint8))
        image.save(Path(FIGURES, f"{name}.png"), optimize=True)
