# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake draws its UV map, and warns where it wastes its atlas; the checker shows texels as they lie."""

from __future__ import annotations

import json
import logging
from dataclasses import replace
from pathlib import Path
from time import sleep
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.thumbnail import Thumbnail
from radtex_addon.cli.wording import worded
from radtex_addon.core.messages import Message
from radtex_addon.core.uv_map import island_colours
from radtex_addon.formats.sidecar import read_sidecar
from radtex_addon.job import bake_object
from radtex_addon.report.gbuffer import BakedSurface, CameraRays
from radtex_addon.report.map_pictures import map_pictures, square_for
from radtex_addon.report.views import TracedView
from radtex_addon.settings.spec import BakeSpec, Unwrap
from radtex_addon.ui.panel.labels import remark
from radtex_addon.worker.handover import hand_over, this_program
from radtex_addon.worker.job import JobMap, JobState
from radtex_addon.worker.orders import order_bake
from radtex_addon.worker.queue import Queue
from tests.blender.batch_process import Batch
from tests.blender.card_frame import give_frame
from tests.blender.test_unwrap_choice import quads

pytestmark = pytest.mark.one_blender
context: Any = bpy.context  # to the stubs, every pointer may be None

SPEC = BakeSpec(texels=64, bucket=2, samples=1)


def tube() -> Any:
    """A thin tube, fifty times as long as it is wide: its islands are narrow strips."""
    bpy.ops.mesh.primitive_cylinder_add(vertices=12, radius=0.02, depth=2, end_fill_type="NOTHING")
    item = context.object
    item.name = "Tube"
    item.data.shade_smooth()
    return item


@pytest.fixture
def room(tmp_path: Path) -> Path:
    """A file with two squares in a layer that is mostly empty."""
    quads((0, 0, 0.2), (0.5, 0.5, 0.2))
    path = tmp_path / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return path


def warned(caplog: pytest.LogCaptureFixture) -> list[Message]:
    """What was said of maps."""
    said = (record.msg for record in caplog.records if isinstance(record.msg, Message))
    return [message for message in said if message.problem.startswith("the map of")]


# maps that waste their atlas


def test_a_layer_that_leaves_most_of_the_atlas_empty_is_warned_of(
    out: Path, caplog: pytest.LogCaptureFixture
) -> None:
    quads((0, 0, 0.2), (0.5, 0.5, 0.2))
    with caplog.at_level(logging.WARNING):
        made = bake_object(context.scene, "Quads", replace(SPEC, uv_layer="Mine"), out)
    sidecar = read_sidecar(made.files.sidecar)
    assert sidecar.coverage == pytest.approx(0.08, abs=1e-3)
    assert sidecar.wasteful == "covers only 8% of 64 x 64 texels"
    (warning,) = warned(caplog)
    assert worded(warning) == (
        "the map of 'Quads' covers only 8% of 64 x 64 texels: fill the square with fewer, larger islands, "
        "or leave --uv out to have one made"
    )
    assert remark(warning).endswith("or leave UV Map empty to have one made")


def test_an_unwrap_that_is_all_seams_is_warned_of(out: Path, caplog: pytest.LogCaptureFixture) -> None:
    quads(*((0.125 * i, 0.125 * j, 0.1) for i in range(8) for j in range(8)))
    with caplog.at_level(logging.WARNING):
        bake_object(context.scene, "Quads", replace(SPEC, unwrap=Unwrap.BLENDER), out)
    (warning,) = warned(caplog)
    assert "of what it covers within a texel of seams" in warning.problem
    assert worded(warning).endswith(
        "give it more texels (--texels), or have a new one made (--unwrap uvunwrap)"
    )
    assert remark(warning).endswith("give it more texels (Resolution), or have a new one made (Unwrap)")
    caplog.clear()
    bake_object(context.scene, "Quads", replace(SPEC, unwrap=Unwrap.BLENDER, density=6.0), out / "dense")
    (warning,) = warned(caplog)
    assert "give it more texels (--density)" in worded(warning)


def test_good_maps_and_drafts_are_not_warned_of(out: Path, caplog: pytest.LogCaptureFixture) -> None:
    bpy.ops.mesh.primitive_cube_add()
    tube()
    quads((0, 0, 0.48), (0.52, 0, 0.48), (0, 0.52, 0.48))
    with caplog.at_level(logging.WARNING):
        for name in ("Cube", "Quads"):
            made = bake_object(context.scene, name, SPEC, out)
            assert read_sidecar(made.files.sidecar).wasteful == ""
            assert "wasteful" not in json.loads(made.files.sidecar.read_text())
        bake_object(context.scene, "Tube", replace(SPEC, texels=32), out)
    assert warned(caplog) == []


# the picture of a map


def test_a_bake_draws_its_map_before_its_light(out: Path, tmp_path: Path) -> None:
    quads((0, 0, 0.48), (0.52, 0, 0.48), (0, 0.52, 0.48))
    told: list[Any] = []
    path = tmp_path / "map.png"
    thumbnail = Thumbnail(tmp_path / "a.png", told.append, path, told.append)
    bake_object(context.scene, "Quads", SPEC, out, thumbnail=thumbnail)
    uv_map = told[0]
    assert (uv_map.islands, round(uv_map.coverage, 3)) == (3, 0.691)
    picture: Any = bpy.data.images.load(str(path))
    assert tuple(picture.size) == (256, 256)
    pixels = np.array(picture.pixels).reshape(256, 256, 4)[..., :3]
    colours = {tuple(np.round(pixels[row, column], 2)) for row, column in ((60, 60), (60, 200), (200, 60))}
    assert len(colours) == 3, "each island has its colour"
    assert pixels[200, 200].max() < 0.1, "nothing is there"


def test_a_worker_tells_of_the_map_while_it_bakes(out: Path, tmp_path: Path) -> None:
    quads((0, 0, 0.2), (0.5, 0.5, 0.2))
    handover = hand_over(context.scene, tmp_path / "cache")
    path = tmp_path / "a.png"
    queue = Queue(this_program())
    queue.add(order_bake(handover, "Quads", replace(SPEC, uv_layer="Mine"), out, picture=path))
    while queue.advance():
        sleep(0.05)
    (job,) = queue.snapshot()
    assert job.state is JobState.DONE, job.message
    assert job.map == JobMap(tmp_path / "a.map.png", 2, 0.08)
    assert job.map.picture.read_bytes()[:4] == b"\x89PNG"
    assert (job.facts["islands"], job.facts["coverage"]) == (2, 0.08)
    assert job.facts["wasteful"] == "covers only 8% of 64 x 64 texels"
    assert any("covers only 8%" in warning.problem for warning in job.warnings)


def test_the_batch_says_what_the_map_covers_and_warns(room: Path, out: Path, batch: Batch) -> None:
    plain = ("--texels", 64, "--bucket", 2, "--samples", 1, "--layout", "buckets", "--progress", "none")
    ended = batch(room, "--object", "Quads", *plain, "--uv", "Mine", "--out", out)
    assert ended.code == 0
    assert "(2 islands on 8% of the atlas)" in ended.out
    assert "radtex: warning: the map of 'Quads' covers only 8% of 64 x 64 texels: fill the" in ended.err


# the checker


@pytest.mark.parametrize(("texels", "square"), [(8, 1), (32, 1), (64, 2), (128, 4), (256, 8), (2048, 64)])
def test_squares_are_few_enough_to_be_seen(texels: int, square: int) -> None:
    assert square_for(texels) == square


def test_a_checker_lies_on_the_texels() -> None:
    card = bpy.data.meshes.new("card")
    card.from_pydata(
        [(-3, -3, 0), (3, -3, 0), (3, 3, 0), (-3, 3, 0)], [], [(0, 1, 2), (0, 2, 3)]
    )  # 6 x 6 wide
    layer: Any = card.uv_layers.new(name="Baked")
    for loop in card.loops:
        place = card.vertices[loop.vertex_index].co
        layer.uv[loop.index].vector = [place[0] / 6 + 0.5, place[1] / 6 + 0.5]
    give_frame(card)
    surface = BakedSurface(card, np.eye(4), "Baked")
    rays = CameraRays.of_camera(
        (0, 0, 500), np.eye(3), 5 / 500, 40, 4
    )  # 10 x 10 wide, from afar: 4 pixels a unit
    nothing = np.zeros((40, 40, 3))
    view = TracedView("View 1", nothing, None, rays, np.full(len(rays.away), np.inf))
    found = map_pictures(surface, [view], 6, 6)  # a texel is a unit
    assert (found.islands, found.square) == (1, 1)
    assert found.coverage == pytest.approx(1)
    assert found.density == pytest.approx(1)
    (checker,) = found.checkers
    assert checker[..., 3].sum() == pytest.approx(24 * 24)
    column, row = np.meshgrid(np.arange(24) // 4, 5 - np.arange(24) // 4)
    (colour,) = island_colours(np.array([0]))
    shown = np.where(((row + column) % 2)[..., None], 0.4, 1.0) * colour
    np.testing.assert_allclose(checker[8:32, 8:32, :3], shown, atol=1e-3)
