# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The batch: what it understands, says and leaves. What is wrong is one line and an exit code."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.plan import Tile
from radtex_addon.bake.progress import Stage
from radtex_addon.cli import run_bake as baking
from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import BakeError
from radtex_addon.cycles.portal import PortalCapture
from radtex_addon.formats.containers.exr import read_atlas
from radtex_addon.forms.buckets import bake as buckets
from radtex_addon.forms.layered.files.layered_files import read_layered
from radtex_addon.preview.save import render_picture
from tests.blender import stage
from tests.blender.batch_process import BAKE, Batch, process, refusal
from tests.blender.unfinished import take_pieces

pytestmark = pytest.mark.one_blender

context: Any = bpy.context  # to the stubs, every pointer may be None

TINY = ("--texels", "8", "--bucket", "2", "--samples", "1", "--layout", "buckets")
QUIET = ("--progress", "none")


def saved(path: Path) -> Path:
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return path


def fill_scene() -> None:
    """One of everything that can be baked or refused."""
    bpy.ops.mesh.primitive_plane_add(size=2)
    context.object.name = "Card"
    context.object.data.materials.append(
        stage.material("white", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1))
    )
    bare = bpy.data.objects.new("No Faces", bpy.data.meshes.new("No Faces"))
    context.scene.collection.objects.link(bare)
    bpy.ops.object.light_add(type="POINT", location=(0, 0, 5))
    context.object.name = "Lamp"
    bpy.ops.mesh.primitive_cube_add(location=(9, 0, 0))
    context.object.name = "Box"
    data = context.object.data
    layers = {"Piled": np.tile([[0, 0], [1, 0], [1, 1], [0, 1]], (6, 1)), "Blank": np.zeros((24, 2))}
    for name, uv in layers.items():
        data.uv_layers.new(name=name).data.foreach_set("uv", uv.astype(np.float32).ravel())


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A .blend in white light, in a folder whose name wants quoting."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    fill_scene()
    stage.world()
    return saved(tmp_path_factory.mktemp("ein schöner Raum") / "room.blend")


@pytest.fixture(scope="module")
def cellar(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A .blend without light."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.mesh.primitive_plane_add(size=2)
    for name in ("Card", "Second"):
        bpy.ops.mesh.primitive_plane_add()
        context.object.name = name
    return saved(tmp_path_factory.mktemp("cellar") / "cellar.blend")


# success


def test_a_bake_in_a_process_of_its_own_prints_json_lines_and_nothing_else(room: Path, out: Path) -> None:
    before = room.read_bytes()
    arguments = ("--object", "Card", "--object", "Box", *TINY, "--texels", 24, "--save-preview")
    ended = process(room, *arguments, "--out", out, "--progress", "json")
    assert (ended.code, ended.err) == (0, "")
    events = [json.loads(line) for line in ended.out.splitlines()]
    assert {event["event"] for event in events} == {"progress", "done"}
    stages = [event["stage"] for event in events if event.get("object") == "Box" and "stage" in event]
    layered = {Stage.SURROUNDINGS, Stage.FIT}
    order = [str(stage) for stage in Stage if stage not in layered]
    assert list(dict.fromkeys(stages)) == order
    assert all(0 <= event["done"] <= event["total"] for event in events if "stage" in event)
    done = [event for event in events if event["event"] == "done"]
    assert [event["object"] for event in done] == ["Card", "Box"]
    files = {Path(path) for event in done for path in event["files"]}
    endings = ("radiance.exr", "radiance.json", "preview.blend")
    assert files == {out / f"{name}.{ending}" for name in ("Card", "Box") for ending in endings}
    assert files == set(out.iterdir())
    assert done[0]["bucket"] == 2
    assert done[0]["paths"] == done[0]["covered_texels"] * 4
    pixels, _ = read_atlas(out / "Card.radiance.exr")
    assert 0.64 <= pixels[..., :3].astype(float).min() < 2  # a path may meet the box, once white too
    assert room.read_bytes() == before


def test_a_bake_without_a_terminal_says_its_stages_and_its_files(room: Path, out: Path, batch: Batch) -> None:
    ended = batch(room, "--object", "Card", *TINY, "--out", out)
    assert ended.code == 0
    assert ended.err.splitlines()[0] == "Card: reading the mesh"
    assert "Card: rendering the light" in ended.err.splitlines()
    assert len(set(ended.err.splitlines())) == len(ended.err.splitlines()), "each once"
    summary, *files = ended.out.splitlines()
    assert "8 x 8 texels of 2 x 2 cells at 1 spp" in summary
    assert [Path(line.strip()) for line in files] == [out / "Card.radiance.exr", out / "Card.radiance.json"]


def test_verbose_shows_blenders_own_words_but_not_among_the_json(room: Path, out: Path, batch: Batch) -> None:
    ended = batch(room, "--object", "Card", *TINY, "--out", out, "--progress", "json", "--verbose")
    assert "Saved" in ended.err
    assert all(json.loads(line)["event"] for line in ended.out.splitlines())


def test_standard_output_is_ours_again_afterwards(room: Path, out: Path, batch: Batch) -> None:
    batch(room, "--object", "Card", *TINY, *QUIET, "--out", out)
    assert "there is no" in batch("nowhere.blend", "--object", "Card").err
    ended = batch(room, "--object", "Card", *TINY, *QUIET, "--out", out / "again")
    assert (ended.code, ended.err, len(ended.out.splitlines())) == (0, "", 3)


def test_json_tells_the_layout_and_all_its_files(room: Path, out: Path, batch: Batch) -> None:
    arguments = ("--object", "Box", "--layout", "layered", "--texels", 16, "--samples", 1, "--out", out)
    ended = batch(room, *arguments, "--progress", "json")
    events = [json.loads(line) for line in ended.out.splitlines()]
    stages = [event["stage"] for event in events if event["event"] == "progress"]
    order = [str(stage) for stage in Stage if stage not in (Stage.DENOISE, Stage.FILL, Stage.PREVIEW)]
    assert list(dict.fromkeys(stages)) == order
    assert (events[-1]["layout"], events[-1]["bucket"]) == ("layered", 14)
    assert {Path(path) for path in events[-1]["files"]} == set(out.iterdir())
    atlas, sidecar = read_layered(out / "Box.radiance.json")
    assert len(events[-1]["files"]) == len(sidecar.shapes) + 1
    assert atlas.irradiance.max() > 0.1
    line = refusal(batch(room, *arguments, *QUIET))
    assert f"{out / 'Box.radiance.colour.exr'} is already there" in line


def test_an_object_that_is_named_twice_is_baked_once(room: Path, out: Path, batch: Batch) -> None:
    ended = batch(room, "--object", "Card", "--object", "Card", *TINY, *QUIET, "--out", out)
    assert ended.code == 0
    assert ended.out.count("Card.radiance.exr") == 1


def test_the_demo_bakes_and_shows_itself(out: Path, batch: Batch, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(baking, "render_picture", partial(render_picture, pixels=32, samples=2))
    small = [
        "--texels",
        "64",
        "--bucket",
        "2",
        "--samples",
        "1",
        "--unwrap",
        "blender",
        "--filter",
        "nearest",
        "--layout",
        "buckets",
    ]
    out.mkdir()
    (out / "Suzanne.radiance.exr").write_text("of an earlier demo")
    ended = batch("demo", *small, *QUIET, "--out", out)
    assert ended.code == 0
    (warning,) = ended.err.splitlines()
    assert warning.startswith("radtex: warning: the map of 'Suzanne' covers only ")
    assert warning.endswith("give it more texels (--texels), or have a new one made (--unwrap uvunwrap)")
    endings = ("radiance.exr", "radiance.json", "preview.blend", "preview.png")
    assert {path.name for path in out.iterdir()} == {f"Suzanne.{ending}" for ending in endings}
    picture: Any = bpy.data.images.load(str(out / "Suzanne.preview.png"))
    assert tuple(picture.size) == (32, 32)
    pixels = np.array(picture.pixels).reshape(32, 32, 4)
    red, green, blue, _ = pixels[12:20, 12:20].reshape(-1, 4).mean(axis=0)
    assert red > green > blue > 0.02, "a golden head, neither black nor the magenta of a missing image"


# bad input: one line that names the thing and the remedy, exit code 2, no file

BAD = {
    "no such object": (["--object", "Crad"], ["'Crad'", "did you mean 'Card'?"]),
    "no faces": (["--object", "No Faces"], ["'No Faces' has no faces", "give it some"]),
    "not a mesh": (["--object", "Lamp"], ["'Lamp' is a light", "name a mesh object"]),
    "an empty layer": (["--object", "Box", "--uv", "Blank"], ["'Blank'", "'Box'", "empty", "unwrap it"]),
    "an overlapping layer": (
        ["--object", "Box", "--uv", "Piled"],
        ["'Piled'", "'Box'", "overlaps", "separate its islands"],
    ),
    "no such layer": (["--object", "Box", "--uv", "None"], ["'Box'", "'None'", "choose 'UVMap'"]),
    "an unknown kind": (
        ["--object", "Card", "--kind", "shadows"],
        ["--kind shadows", "radiance, incident, reflection"],
    ),
    "an unknown filter": (["--object", "Card", "--filter", "cubic"], ["--filter cubic", "quadrilinear"]),
    "not a number": (["--object", "Card", "--samples", "many"], ["--samples many", "a whole number"]),
    "no samples": (["--object", "Card", "--samples", "0"], ["samples 0", "from 1 to"]),
    "an unknown option": (["--object", "Card", "--fast"], ["--fast", "--help"]),
    "no object": ([], ["which object?", "--object NAME"]),
    "a device that is not there": (
        ["--object", "Card", "--device", "optix"],
        ["no device 'optix'", "choose auto, or cpu (--device)"],
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_one_line(case: str, room: Path, out: Path, batch: Batch) -> None:
    arguments, words = BAD[case]
    before = room.read_bytes()
    size = ("--texels", "8", "--samples", "1")
    line = refusal(batch(room, *size, "--out", out, *QUIET, *arguments))
    assert [word for word in words if word not in line] == [], line
    assert not out.exists()
    assert room.read_bytes() == before


def test_the_line_comes_last_after_the_stages(room: Path, out: Path, batch: Batch) -> None:
    ended = batch(room, "--object", "Box", "--uv", "Blank", *TINY, "--out", out)
    *stages, last = ended.err.splitlines()
    assert all(line.startswith("Box: ") for line in stages)
    assert last.startswith("radtex: UV layer 'Blank'")


def test_json_tells_the_error_too(room: Path, out: Path, batch: Batch) -> None:
    ended = batch(room, "--object", "Lamp", "--out", out, "--progress", "json")
    error = json.loads(ended.out.splitlines()[-1])
    assert (error["event"], error["exit_code"]) == ("error", 2)
    assert ended.err == f"radtex: {error['message']}\n"


def test_all_objects_are_looked_at_before_the_first_is_baked(room: Path, out: Path, batch: Batch) -> None:
    ended = batch(room, "--object", "Card", "--object", "Crad", *TINY, *QUIET, "--out", out)
    assert "Crad" in refusal(ended)
    assert not out.exists()


def test_files_that_are_there_stay_without_overwrite(room: Path, out: Path, batch: Batch) -> None:
    out.mkdir()
    for name in ("Card.radiance.exr", "Card.radiance.json", "Card.preview.blend"):
        (out / name).write_text("mine")
        line = refusal(batch(room, "--object", "Card", *TINY, *QUIET, "--out", out, "--save-preview"))
        assert f"{out / name} is already there: overwrite it (--overwrite)" in line
        assert [path.read_text() for path in out.iterdir()] == ["mine"]
        (out / name).unlink()
    (out / "Card.radiance.exr").write_text("mine")
    (out / "other").write_text("mine")
    assert batch(room, "--object", "Card", *TINY, *QUIET, "--out", out, "--overwrite").code == 0
    assert read_atlas(out / "Card.radiance.exr")[1].kind == "radiance"
    assert (out / "other").read_text() == "mine"


def test_a_folder_in_a_files_place_is_never_removed(room: Path, out: Path, batch: Batch) -> None:
    (out / "Card.radiance.exr").mkdir(parents=True)
    line = refusal(batch(room, "--object", "Card", *TINY, "--out", out, "--overwrite"))
    assert "Card.radiance.exr is a folder" in line


def test_a_blend_that_is_missing(tmp_path: Path, batch: Batch) -> None:
    line = refusal(batch(tmp_path / "none.blend", "--object", "Card"))
    assert f"there is no file {tmp_path / 'none.blend'}" in line
    assert f"{tmp_path} is a folder" in refusal(batch(tmp_path, "--object", "Card"))
    assert "longlong" in refusal(batch(tmp_path / ("long" * 99), "--object", "Card"))
    assert "which file?" in refusal(batch("--object", "Card"))


def test_a_scene_without_light_is_a_warning_and_bakes(cellar: Path, out: Path, batch: Batch) -> None:
    ended = batch(cellar, "--object", "Card", "--object", "Second", *TINY, *QUIET, "--out", out)
    assert ended.code == 0
    assert ended.err.count("\n") == 1, "once, for two objects"
    assert ended.err.startswith("radtex: warning: scene 'Scene' has no light")
    assert len(list(out.iterdir())) == 4
    assert read_atlas(out / "Card.radiance.exr")[0][..., :3].max() == 0


def test_json_tells_warnings_too(cellar: Path, out: Path, batch: Batch) -> None:
    ended = batch(cellar, "--object", "Card", *TINY, "--progress", "json", "--out", out)
    assert (ended.code, ended.err) == (0, "")
    events = [json.loads(line) for line in ended.out.splitlines()]
    assert ["has no light" in event["message"] for event in events if event["event"] == "warning"] == [True]


# failures while baking: exit code 1


def failing(monkeypatch: pytest.MonkeyPatch, error: BaseException) -> None:
    """Let the capture raise `error` at its second tile."""

    class Failing(PortalCapture):
        def render(self, tile: Tile) -> Floats:
            if tile.first_row:
                raise error
            return super().render(tile)

    monkeypatch.setattr(buckets, "PortalCapture", Failing)


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (BakeError("Cycles cannot render: out of memory"), "radtex: Cycles cannot render: out of memory"),
        (MemoryError(), "radtex: out of memory: use fewer texels or cells"),
        (OSError(28, "No space left on device"), "radtex: the system refuses: [Errno 28] No space left"),
    ],
)
def test_a_failure_while_baking_is_one_line_and_exit_code_1(
    error: Exception, words: str, room: Path, out: Path, batch: Batch, monkeypatch: pytest.MonkeyPatch
) -> None:
    failing(monkeypatch, error)
    line = refusal(batch(room, "--object", "Card", *TINY, *QUIET, "--out", out), code=1)
    assert line.startswith(words)
    assert line.endswith("; what is finished of 'Card' is kept: go on with it (--resume)\n")
    assert take_pieces(out)
    assert not out.exists()


def test_a_mistake_of_ours_shows_its_traceback_and_never_exits_with_0(
    room: Path, out: Path, batch: Batch, monkeypatch: pytest.MonkeyPatch
) -> None:
    failing(monkeypatch, ZeroDivisionError("oh"))
    ended = batch(room, "--object", "Card", *TINY, *QUIET, "--out", out)
    assert ended.code == 1
    assert "ZeroDivisionError: oh" in ended.err
    assert ended.err.splitlines()[-1].startswith(
        "radtex: a mistake in RadTex (ZeroDivisionError): please report"
    )
    assert take_pieces(out)
    assert not out.exists()


def test_objects_that_were_done_before_a_failure_stay(
    room: Path, out: Path, batch: Batch, monkeypatch: pytest.MonkeyPatch
) -> None:
    two_done = iter([False, True])

    def sometimes(*arguments: Any, **options: Any) -> Any:
        if next(two_done):
            raise BakeError("planned")
        return PortalCapture(*arguments, **options)

    monkeypatch.setattr(buckets, "PortalCapture", sometimes)
    ended = batch(
        room, "--object", "Card", "--object", "Box", "--texels", 24, *TINY[2:], *QUIET, "--out", out
    )
    said = "radtex: planned; what is finished of 'Box' is kept: go on with it (--resume)\n"
    assert (ended.code, ended.err) == (1, said)
    assert take_pieces(out)
    assert {path.name for path in out.iterdir()} == {"Card.radiance.exr", "Card.radiance.json"}


# interruption

KEPT = "interrupted; what is finished of 'Card' is kept: go on with it (--resume)"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_either_signal_interrupts_and_handlers_are_put_back(
    number: signal.Signals, room: Path, out: Path, batch: Batch, monkeypatch: pytest.MonkeyPatch
) -> None:
    heard: list[int] = []
    before = signal.signal(number, lambda received, _frame: heard.append(received))
    ours = signal.getsignal(number)

    class Interrupted(PortalCapture):
        def render(self, tile: Tile) -> Floats:
            if tile.first_row == 0:
                signal.raise_signal(number)
            assert tile.first_row <= 1, "the next step is the last"
            return super().render(tile)

    monkeypatch.setattr(buckets, "PortalCapture", Interrupted)
    try:
        line = refusal(batch(room, "--object", "Card", *TINY, *QUIET, "--out", out), code=130)
        assert line == f"radtex: {KEPT}\n"
        assert heard == []
        assert signal.getsignal(number) is ours
    finally:
        signal.signal(number, before)
    assert take_pieces(out)
    assert not out.exists()


def test_a_reader_that_goes_ends_the_bake(room: Path, out: Path) -> None:
    command = [sys.executable, BAKE, str(room), "--object=Card", *TINY, "--progress=json", f"--out={out}"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
        assert running.stdout is not None
        assert running.stderr is not None
        running.stdout.close()
        err = running.stderr.read()
    assert running.returncode == 130
    assert "radtex: nobody reads the standard output" in err
    assert "Traceback" not in err
