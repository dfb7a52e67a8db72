# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials that are shown by their own images: the page and Godot against the preview."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from radtex_addon.bake.progress import finished
from radtex_addon.export.exporting import export_steps
from radtex_addon.report.gbuffer import eroded
from radtex_addon.report.metrics import Picture
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.bench.engines.programs import blended
from tests.blender.image_stage import NAME, bake_behind_pane
from tests.finished_bakes import finished_bake
from tests.real.browser import Shown
from tests.real.exhibit import Bake, Camera, decibels
from tests.real.godot import ALL_RENDERERS, Shot, linear, placed
from tests.real.preview_shot import Shots
from tests.real.root import Root
from tests.real.web import Site, encoded

PLACE = (0.3, -0.2, 0.5)
CAMERAS = (
    Camera("whole", (3.6, -4.4, 3.2), PLACE),
    Camera("near", (0.9, -1.6, 3.0), (0.5, -0.35, 1.4), fovy=20.0),
)
LEAST = 34.0  # dB: images have mip levels in engines, and none in Cycles


@pytest.fixture(scope="module")
def wanted(crate: Bake, tmp_path_factory: pytest.TempPathFactory) -> list[Picture]:
    """The preview, as Cycles shows it."""
    return Shots(crate.preview, "cycles", tmp_path_factory.mktemp("shots"), NAME).pictures(CAMERAS)


@contextmanager
def page_of(web: Site, crate: Bake, name: str) -> Iterator[Shown]:
    web.add(name, crate)
    with web.opened(f"{name}/") as shown:
        yield shown.wait()


def held_to(what: str, camera: Camera, shown: Picture, wanted: Picture, crate: Bake) -> None:
    found = decibels(shown, wanted, crate.eroded(camera))
    print(f"{what}, {camera.name}: {found:.1f} dB")
    assert found > LEAST


def test_the_page_shows_what_the_preview_does(web: Site, crate: Bake, wanted: list[Picture]) -> None:
    with page_of(web, crate, f"images-{crate.folder.name}") as shown:
        for camera, picture in zip(CAMERAS, wanted, strict=True):
            shown.set_camera(camera)
            held_to("page", camera, shown.pixels()[..., :3].astype(np.float64), picture, crate)
        flat = shown.pixels(flat=True)
        assert flat.max() > 0.1  # the flat lightmap beside the .glb


def test_the_page_shows_what_lies_behind_a_clear_part(
    web: Site, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """By their middles the order of the parts would be wrong: those that are not clear are drawn first."""
    bake = Bake(finished_bake(tmp_path_factory.mktemp("pane"), bake_behind_pane))
    camera, folder = CAMERAS[0], tmp_path_factory.mktemp("shots")
    pane, box = (
        Shots(bake.preview, "cycles", folder, name).layers((camera,))[0] for name in ("A Pane", NAME)
    )
    behind = (box[..., 3] > 0.999) & (np.abs(pane[..., 3] - 0.5) < 0.05)  # edges of neither
    cover = pane.max(axis=2, keepdims=True).clip(1e-6, 1)  # light is encoded where it covers, then blended
    over = encoded(pane[..., :3] / cover) * cover
    wanted = linear(over + (1 - pane[..., 3:]) * encoded(box[..., :3]))
    web.add("pane", bake)
    with web.opened("pane/", width=camera.pixels, height=camera.pixels, device_scale_factor=1) as shown:
        shown.wait().set_camera(camera)
        picture = blended(shown, np.zeros((camera.pixels, camera.pixels, 3)))
    found = decibels(picture, wanted, eroded(eroded(behind)))
    print(f"page, behind a pane: {found:.1f} dB")
    assert found > LEAST


def test_godot_shows_what_the_preview_does(
    root: Root, crate: Bake, wanted: list[Picture], tmp_path: Path
) -> None:
    made = finished(export_steps(crate.sidecar, ExportSpec(Target.GODOT), tmp_path / "project"))
    project = placed(root, made.folder)
    shots = [Shot(camera) for camera in CAMERAS]
    for renderer in ALL_RENDERERS:
        for camera, shown, picture in zip(CAMERAS, project.pictures(renderer, shots), wanted, strict=True):
            held_to(renderer, camera, shown, picture, crate)
