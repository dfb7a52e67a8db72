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
from tests.real.godot import ALL_RENDERERS, RENDERERS, Placed, Shot, linear, placed
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


# Two nodes, or instances, side by side.
BESIDE = [turned(0, (0, 1, 0), (aside, 0.15, 0), (0.42,) * 3) for aside in (-0.75, 0.75)]
TINT, EXPOSURE = "#60ffc0", 0.5
LIGHT = linear(np.array([0x60, 0xFF, 0xC0]) / 255)  # of that colour
NO_ROOM: dict[str, float | str] = {"object_tint": "#000000", "object_exposure": 0.0}  # what shaders read then
GREY = 128
HORIZON = 80  # the row of a picture
MULTIPLE = 32.0  # dB of a picture to a multiple of another one: of dark light Compatibility has a rough curve


def check_multiples(taken: Picture, plain: Picture, factors: Sequence[Floats], name: str) -> None:
    """Each half of a picture is its own multiple of what is shown without values."""
    half = FRONT.pixels // 2
    sides = [slice(0, half), slice(half, None)]
    wanted = np.concatenate(
        [plain[:, side] * factor for side, factor in zip(sides, factors, strict=True)], axis=1
    )
    wrong = np.concatenate(
        [plain[:, side] * factor for side, factor in zip(sides, factors[::-1], strict=True)], axis=1
    )
    seen = (plain.max(axis=2) > 0.001) & (np.maximum(plain, wanted).max(axis=2) < 0.99)
    found = decibels(taken, np.minimum(wanted, 1), seen)
    print(f"{name}: {found:.1f} dB, exchanged {decibels(taken, np.minimum(wrong, 1), seen):.1f} dB")
    assert seen.mean() > 0.03
    assert found > MULTIPLE
    if not np.array_equal(factors[0], factors[1]):
        assert decibels(taken, np.minimum(wrong, 1), seen) < MULTIPLE - 7


@pytest.mark.parametrize("form", Form)
def test_each_node_has_a_tint_and_an_exposure_of_its_own(
    form: Form, exhibit: Exhibit, root: Root, tmp_path: Path
) -> None:
    """By its instance shader parameters, in each renderer; the material, which they share, has both, too."""
    bake: Bake = getattr(exhibit, form)
    place = project(bake.sidecar, root, tmp_path)
    values: list[dict[str, float | str]] = [{"object_tint": TINT}, {"object_exposure": EXPOSURE}]
    factors = [LIGHT, np.full(3, EXPOSURE)]
    exposure = {"plain": 0.5, "layered": 2.0}[form]  # as light as can be without much that is clipped
    nodes = Shot(FRONT, {"exposure": exposure}, copies=BESIDE, as_nodes=True)
    shots = [
        nodes,
        replace(nodes, values=values),
        replace(nodes, values=[NO_ROOM, values[1]]),
        replace(nodes, parameters={"material_tint": TINT, "exposure": exposure}),
    ]
    for renderer in ALL_RENDERERS:
        plain, own, without, by_material = place.pictures(renderer, shots)
        check_multiples(own, plain, factors, f"{form}, {renderer}")
        check_multiples(without, plain, [np.ones(3), factors[1]], "without room for its values")
        check_multiples(by_material, plain, [LIGHT, LIGHT], "its material")
        if renderer == "Forward+":
            _keep(f"godot-tint-{form}", [plain, own])


@pytest.mark.parametrize("kind", [Kind.SHADOW, Kind.TRANSFER, Kind.AO])
def test_what_lights_fall_on_has_a_tint_and_an_exposure_too(
    kind: Kind, kind_bake: Callable[[Kind], KindBake], root: Root, tmp_path: Path
) -> None:
    lit: dict[str, Any] = {"sky": (1, 0)} if kind is Kind.AO else {"sun": SUN}
    place = project(kind_bake(kind).sidecar, root, tmp_path)
    nodes = Shot(FRONT, copies=BESIDE, as_nodes=True, **lit)
    values: list[dict[str, float | str]] = [{"object_tint": TINT}, {"object_exposure": EXPOSURE}]
    for renderer in ALL_RENDERERS:
        plain, own = place.pictures(renderer, [nodes, replace(nodes, values=values)])
        for picture in (plain, own):
            picture[:HORIZON] = 0  # above it the sky is seen
        check_multiples(own, plain, [LIGHT, np.full(3, EXPOSURE)], f"{kind}, {renderer}")


@pytest.mark.parametrize("form", Form)
def test_instances_of_a_multimesh_have_colours(
    form: Form, exhibit: Exhibit, root: Root, tmp_path: Path
) -> None:
    """They multiply the light as they are, above 1 as well."""
    bake: Bake = getattr(exhibit, form)
    place = project(bake.sidecar, root, tmp_path)
    colours = [(0.25, 1.0, 0.5, 1.0), (0.5, 0.25, 1.5, 1.0)]
    shots = [Shot(FRONT, copies=BESIDE), Shot(FRONT, copies=BESIDE, colours=colours)]
    for renderer in ALL_RENDERERS:
        plain, own = place.pictures(renderer, shots)
        check_multiples(own, plain, [np.array(colour[:3]) for colour in colours], f"{form}, {renderer}")


def test_what_is_blended_has_an_opacity(
    kind_bake: Callable[[Kind], KindBake], root: Root, tmp_path: Path
) -> None:
    """Of each node, of each instance and of the material: of the hull, which is seen from outside alone. It
    covers as much less of black, and of grey, as displayed in Compatibility, as light elsewhere."""
    place = project(kind_bake(Kind.PROXY).sidecar, root, tmp_path)
    Image.new("RGB", (8, 8), (GREY, GREY, GREY)).save(place.folder / "grey.png")
    behind = f"{place.place.removeprefix('res://')}/grey.png"
    nodes = Shot(FRONT, {"exposure": 0.4}, copies=BESIDE, as_nodes=True)
    ways = {
        "whole": nodes,
        "nodes": replace(nodes, values=[{"object_opacity": 0.25}, {"object_opacity": 0.75}]),
        "instances": replace(nodes, as_nodes=False, colours=[(1, 1, 1, 0.25), (1, 1, 1, 0.75)]),
        "material": replace(nodes, parameters={"material_opacity": 0.25}),
    }
    before_grey = [replace(nodes, parameters={"material_opacity": 1.0}, behind=behind)]
    before_grey += [replace(ways[name], behind=behind) for name in ("nodes", "instances", "material")]
    share = np.full((1, FRONT.pixels, 1), 0.25)
    share[:, FRONT.pixels // 2 :] = 0.75
    for renderer in ALL_RENDERERS:
        to = shown if renderer == "Compatibility" else np.asarray
        grey = to(linear(np.full(3, GREY / 255)))
        taken = [to(picture) for picture in place.pictures(renderer, [*ways.values(), *before_grey])]
        whole, whole_before_grey = taken[0], taken[len(ways)]
        seen = (whole.max(axis=2) > 0.01) & (whole.max(axis=2) < 0.99)  # what is brighter covers more
        assert seen.mean() > 0.03
        alpha = 1 - (whole_before_grey - whole) / grey
        for number, name in enumerate(list(ways)[1:], 1):
            part = 0.25 if name == "material" else share
            for picture, wanted in (
                (taken[number], part * whole),
                (taken[len(ways) + number], part * whole + (1 - part * alpha) * grey),
            ):
                error = np.abs(picture - wanted)[seen]
                print(f"{renderer}, {name}: off by {error.mean():.4f}, at most {error.max():.3f}")
                assert error.mean() < 0.02
                assert np.abs(picture - whole)[seen].mean() > 0.02


def shown(light: Picture) -> Picture:
    """sRGB values of linear light."""
    found: Picture = np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055)
    return found


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
