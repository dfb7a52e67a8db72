# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""`bake.py report`: what it understands, says and leaves."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.cli.report_arguments import parse_report
from radtex_addon.core.errors import InputError
from radtex_addon.job import bake_object
from radtex_addon.report.report_bake import ReportSpec
from radtex_addon.settings.spec import BakeSpec
from tests.blender import stage
from tests.blender.batch_process import Batch, refusal

pytestmark = pytest.mark.one_blender

context: Any = bpy.context  # to the stubs, every pointer may be None

QUICK = ("--views", "1", "--pixels", "32", "--samples", "1")
QUIET = ("--progress", "none")


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A .blend with a white ball in white light, and beside it its bake."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2)
    context.object.name = "Ball"
    context.object.data.materials.append(
        stage.material("white", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1))
    )
    stage.world()
    folder = tmp_path_factory.mktemp("ein schöner Raum")
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "room.blend"), copy=True)
    bake_object(context.scene, "Ball", BakeSpec(texels=24, bucket=4, samples=4), folder / "baked")
    return folder / "room.blend"


@pytest.fixture
def baked(room: Path) -> Path:
    return room.parent / "baked"


@pytest.fixture
def page(tmp_path: Path) -> Path:
    return tmp_path / "page.html"


def test_a_report_prints_json_lines_and_leaves_one_page(room: Path, baked: Path, batch: Batch) -> None:
    before, files = room.read_bytes(), set(baked.iterdir())
    ended = batch("report", baked, "--scene", room, *QUICK, "--min-psnr", "20", "--progress", "json")
    assert (ended.code, ended.err) == (0, "")
    *progress, done = [json.loads(line) for line in ended.out.splitlines()]
    assert {event["event"] for event in progress} == {"progress"}
    stages = list(dict.fromkeys(event["stage"] for event in progress))
    assert [stage for stage in stages if stage != "unwrap"] == [
        "find mesh",
        "find views",
        "reference",
        "compare",
        "page",
    ]
    left = baked / "Ball.report.html"
    assert set(baked.iterdir()) == files | {left}
    left.unlink()
    assert (done["event"], done["object"], done["files"]) == ("done", "Ball", [str(left)])
    assert done["psnr"] > 30
    assert done["energy"] == pytest.approx(1, abs=0.05)
    assert done["summary"].startswith("Ball as baked is ")
    assert room.read_bytes() == before


def test_inside_blender_the_open_file_is_looked_at(room: Path, baked: Path, page: Path, batch: Batch) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(room))
    words = ("--out", page, *QUICK, "--object", "Ball")
    code, out, err = batch("report", baked / "Ball.radiance.json", *words, inside_blender=True)
    assert code == 0
    assert err.splitlines()[0] == "Ball: finding its UV layer"
    assert "Ball: rendering the original" in err.splitlines()
    assert out.splitlines()[1] == f"  {page}"
    assert page.read_text(encoding="utf-8").startswith("<!doctype html>")


def test_a_bake_below_the_least_psnr_is_reported_and_ends_with_3(
    room: Path, baked: Path, page: Path, batch: Batch
) -> None:
    words = ("--scene", room, "--out", page, *QUICK, "--min-psnr", "99", "--progress", "json")
    code, out, err = batch("report", baked, *words)
    assert code == 3
    done, error = [json.loads(line) for line in out.splitlines() if line.startswith("{")][-2:]
    assert (done["event"], done["files"], page.exists()) == ("done", [str(page)], True)
    assert (error["event"], error["exit_code"]) == ("error", 3)
    assert f"Ball: {done['psnr']:.2f} dB, less than the 99 dB of --min-psnr" in err


def test_variants_are_told_apart(room: Path, baked: Path, page: Path, batch: Batch) -> None:
    code, out, err = batch("report", baked, "--scene", room, "--out", page, "--variants", *QUICK)
    assert code == 0
    for part in ("samples", "cells", "texels"):
        assert f"Ball, half the {part}: rendering the light" in err.splitlines()
    assert "halving any costs less than" in out or "First give it more " in out


def test_a_request_is_what_was_said() -> None:
    request = parse_report(["baked", "--scene", "demo", "--variants", "--views", "5"], inside_blender=False)
    assert (request.bake, request.scene, request.demo, request.out) == (Path("baked"), None, True, None)
    assert request.spec == ReportSpec(views=5, variants=True)


@pytest.mark.parametrize(
    ("arguments", "inside", "words"),
    [
        ([], False, "which bake"),
        (["baked"], False, r"which scene\? .* --scene FILE\.blend, or --scene demo"),
        (["baked", "--scene", "a.blend"], True, "inside Blender the open file is looked at"),
        (["baked", "--scene", "demo", "--out", "a.png"], False, "the page is an .html file"),
        (["baked", "--scene", "demo", "--views", "0"], False, "views 0: give a whole number from 1"),
        (["baked", "--scene", "demo", "--min-psnr", "good"], False, "--min-psnr good: give a number of dec"),
        (["baked", "--scene", "demo", "--min-psnr", "nan"], False, "--min-psnr nan: give a number of dec"),
        (["baked", "--scene", "demo", "--views", "x"], False, "--views x: give a whole number"),
    ],
)
def test_what_is_missing_is_asked_for(arguments: list[str], inside: bool, words: str) -> None:
    with pytest.raises(InputError, match=words):
        parse_report(arguments, inside)


@pytest.mark.parametrize(
    ("name", "words"),
    [("nowhere", "there is no "), ("empty", "holds no bake"), ("foreign.json", "is not JSON")],
)
def test_what_is_no_bake_is_one_line(name: str, words: str, room: Path, tmp_path: Path, batch: Batch) -> None:
    (tmp_path / "empty").mkdir()
    (tmp_path / "foreign.json").write_text("mine")
    assert words in refusal(batch("report", tmp_path / name, "--scene", room, *QUIET))


def test_an_object_that_is_not_in_the_scene_is_one_line_and_no_page(
    baked: Path, tmp_path: Path, page: Path, batch: Batch
) -> None:
    bpy.ops.mesh.primitive_cube_add()
    other = tmp_path / "other.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(other), copy=True)
    ended = batch("report", baked, "--scene", other, "--out", page, *QUIET)
    assert "no object 'Ball' in scene" in refusal(ended)
    assert not page.exists()
