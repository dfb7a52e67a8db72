# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""`bake.py compare`: what it understands, says and leaves."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.cli.compare_arguments import parse_compare
from radtex_addon.core.errors import InputError
from radtex_addon.report.side_by_side import ComparisonSpec, difference, read_picture
from tests.blender import stage
from tests.blender.batch_process import Batch, refusal
from tests.blender.test_swap import GLOW, PLAIN, bake_of, ball

pytestmark = pytest.mark.one_blender

context: Any = bpy.context  # to the stubs, every pointer may be None
blocks: Any = bpy.data

QUICK = ("--pixels", "32", "--samples", "1")
IDENTITY = "1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1"
ABOVE = "--view=1,0,0,0,0,1,0,0,0,0,1,-5,0,0,0,1"
ASIDE = "--view=1,0,0,-50,0,1,0,0,0,0,1,-5,0,0,0,1"
FLAT = "--window=0.5,0,0,0,0,1,0,0,0,0,-0.002,0,0,0,0,1"


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A .blend with a glowing ball under a camera, and beside it, in "baked", its bake."""
    folder = tmp_path_factory.mktemp("ein schöner Raum")
    bake_of(PLAIN, folder / "baked")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    ball("Ball")
    stage.world((0.1, 0.1, 0.1))
    context.scene.camera = blocks.objects.new("Camera", blocks.cameras.new("Camera"))
    context.scene.collection.objects.link(context.scene.camera)
    context.scene.camera.location.z = 5
    context.scene.render.resolution_x, context.scene.render.resolution_y = 200, 100
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "room.blend"), copy=True)
    return folder / "room.blend"


@pytest.fixture
def baked(room: Path) -> Path:
    return room.parent / "baked"


def test_a_comparison_prints_json_lines_and_leaves_three_pictures(
    room: Path, baked: Path, out: Path, batch: Batch
) -> None:
    before = room.read_bytes()
    ended = batch(
        *("compare", room, "--object", "Ball", "--bake", baked, "--out", out),
        *("--pixels", "64", "--samples", "4", "--min-psnr", "100", "--progress", "json"),
    )
    assert ended.code == 3
    *progress, done, error = [json.loads(line) for line in ended.out.splitlines()]
    assert (error["event"], error["exit_code"]) == ("error", 3)
    assert ended.err == (
        f"radtex: Ball: {done['psnr']:.2f} dB, less than the 100 dB of --min-psnr: "
        "bake with more texels or samples\n"
    )
    assert {event["event"] for event in progress} == {"progress"}
    assert list(dict.fromkeys(event["stage"] for event in progress)) == ["reference", "compare"]
    names = ["Ball.traced.exr", "Ball.baked.exr", "Ball.difference.png"]
    assert done["files"] == [str(out / name) for name in names]
    assert sorted(path.name for path in out.iterdir()) == sorted(names)
    assert (done["event"], done["object"]) == ("done", "Ball")
    assert done["psnr"] > 30
    assert done["energy"] == pytest.approx(1, abs=0.03)
    assert done["summary"].startswith(f"Ball: {done['psnr']:.1f} dB from path traced")
    assert room.read_bytes() == before
    traced, shown = read_picture(Path(done["traced"])), read_picture(Path(done["baked"]))
    assert traced.shape == shown.shape == (32, 64, 3)
    for picture in (traced, shown):
        np.testing.assert_allclose(picture[16, 32], GLOW, rtol=0.02)
        np.testing.assert_allclose(picture[2, 2], 0.1, rtol=0.02)
    png: Any = blocks.images.load(str(out / names[2]))
    levels = np.array(png.pixels).reshape(32, 64, 4)[..., :3]
    np.testing.assert_allclose(levels, difference(traced, shown), atol=0.01)


def test_inside_blender_the_open_file_is_looked_at_by_a_view_of_ones_own(
    room: Path, baked: Path, out: Path, batch: Batch
) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(room))
    context.scene.camera = None
    where = (f"--bake={baked / 'Ball.radiance.json'}", f"--out={out}", ABOVE, FLAT)
    asked = ("compare", "--object=Ball", *where, *QUICK, "--progress=none")
    ended = batch(*asked, inside_blender=True)
    assert ended.code == 0
    assert ended.out.startswith("Ball: 99.0 dB from path traced")
    assert str(out / "Ball.difference.png") in ended.out
    picture = read_picture(out / "Ball.traced.exr")
    assert picture.shape == (16, 32, 3)
    np.testing.assert_allclose(picture[8, 16], GLOW, rtol=0.02)
    np.testing.assert_allclose(picture[8, 2], 0.1, rtol=0.02)
    assert batch(*asked, inside_blender=True).code == 0, "earlier pictures are replaced"


def test_the_folder_of_the_bakes_may_be_relative_to_where_the_program_runs(
    room: Path, out: Path, batch: Batch, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As docs/compare.md writes it: `blender -b scene.blend -P bake.py -- compare … --bake baked`."""
    monkeypatch.chdir(room.parent)
    asked = ("compare", "--object=Ball", "--bake=baked", f"--out={out}", *QUICK, "--progress=none")
    bpy.ops.wm.open_mainfile(filepath=str(room))
    ended = batch(*asked, inside_blender=True)
    assert (ended.code, ended.err) == (0, "")
    assert (out / "Ball.difference.png").is_file()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("Ball",), "there is no file"),
        (("{room}", "--object", "Boll"), "no object 'Boll' in scene 'Scene': did you mean 'Ball'?"),
        (("{room}", "--object", "Ball", "--bake", "/nowhere"), "there is no /nowhere"),
        (("{room}", "--object", "Camera", "--bake", "{room.parent}/baked"), "holds no bake of 'Camera'"),
        (
            ("{room}", "--object", "Ball", "--bake", "{room.parent}/baked", ASIDE, FLAT),
            "'Ball': not seen from here",
        ),
    ],
)
def test_what_cannot_be_compared_is_one_line(
    words: tuple[str, ...], message: str, room: Path, out: Path, batch: Batch
) -> None:
    arguments = [word.format(room=room) for word in words]
    if "--object" not in arguments:
        arguments += ["--object", "Ball"]
    assert message in refusal(batch("compare", *arguments, *QUICK, f"--out={out}", "--progress=none"))
    assert not out.exists()


def test_without_a_camera_it_names_the_options_that_give_a_view(
    room: Path, baked: Path, out: Path, batch: Batch
) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(room))
    context.scene.camera = None
    asked = ("compare", "--object=Ball", f"--bake={baked}", f"--out={out}", *QUICK, "--progress=none")
    told = refusal(batch(*asked, inside_blender=True))
    assert told.endswith("scene 'Scene' has no camera: add one, or give a view by --view and --window\n")


@pytest.mark.parametrize(
    ("words", "inside", "message"),
    [
        ((), False, "which file?"),
        (("room.blend",), False, "which object?"),
        ((), True, "which object?"),
        (("room.blend", "--object=A"), True, "the open file is looked at: open room.blend by blender -b"),
        (("room.blend", "--object=A", f"--view={IDENTITY}"), False, "give --view and --window"),
        (("room.blend", "--object=A", "--view=1,0", FLAT), False, "give a matrix as 16 numbers"),
        (("room.blend", "--object=A", f"--view={IDENTITY}x", FLAT), False, "give a matrix as 16 numbers"),
        (("room.blend", "--object=A", ABOVE, f"--window={'0,' * 15}0"), False, "these matrices are no view"),
        (("room.blend", "--object=A", "--pixels=4"), False, "pixels 4: give a whole number from 16"),
    ],
)
def test_a_request_that_cannot_be_is_refused(words: tuple[str, ...], inside: bool, message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse_compare(list(words), inside)


def test_without_options_the_batchs_folder_and_the_camera_are_looked_at() -> None:
    request = parse_compare(["demo"], inside_blender=False)
    assert (request.demo, request.objects, request.bake, request.out) == (
        True,
        (),
        Path("radtex"),
        Path("radtex"),
    )
    assert (request.eye, request.spec) == (None, ComparisonSpec())
