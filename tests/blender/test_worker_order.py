# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a worker is asked for is what `bake.py` understands; what it says becomes plain data."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import fields, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from radtex_addon.bake.progress import Stage
from radtex_addon.bake.spec import BakeSpec, Layout
from radtex_addon.cli.arguments import Request, parse
from radtex_addon.cli.options import ProgressStyle
from radtex_addon.core.sampler import Filter
from radtex_addon.worker.job import Job, State
from radtex_addon.worker.order import Handover, Order, Program, arguments, command

FOLDER = Path("/some where/größer")
HANDOVER = Handover(FOLDER, FOLDER / "raum.blend", "-Scene", None, "cpu", 0.0)
CHOSEN: dict[str, Any] = {
    "kind": "incident",
    "texels": 31,
    "bucket": 5,
    "samples": 3,
    "uv_layer": "-UV = map",
    "capture": "panoramic",
    "seed": 9,
    "device": "optix",
    "half": False,
    "compression": "piz",
    "unwrap": "blender",
    "padding": 4,
    "memory_mb": 77,
}
SPECS = {
    "every choice": BakeSpec(**CHOSEN),
    "none": BakeSpec(device="cpu"),
    "a budget": BakeSpec(layout=Layout.SHARED, budget=800_000, device="cpu"),
    "a target": BakeSpec(layout=Layout.SHARED, target=42.5, bucket=10, device="cpu"),
}


def order(spec: BakeSpec) -> Order:
    return Order(HANDOVER, "--Vase", spec, FOLDER / "out")


def understood(asked: Order) -> Request:
    return parse(["scene.blend", *arguments(asked)], inside_blender=False)


def test_every_field_of_a_spec_is_among_the_cases() -> None:
    assert {field.name for field in fields(BakeSpec)} == CHOSEN.keys() | {"layout", "budget", "target"}


@pytest.mark.parametrize("case", SPECS)
def test_a_spec_arrives_as_it_was_ordered(case: str) -> None:
    request = understood(order(SPECS[case]))
    assert request.spec == SPECS[case]
    assert (request.objects, request.in_scene) == (("--Vase",), "-Scene")
    assert request.out == FOLDER / "out"
    assert (request.preview, request.overwrite) == (None, False)
    assert (request.progress, request.parent_pipe, request.unsaved_images) == (ProgressStyle.JSON, True, None)


def test_a_preview_overwriting_and_painted_images_arrive() -> None:
    handover = replace(HANDOVER, images=FOLDER / "images")
    asked = Order(handover, "Vase", BakeSpec(), FOLDER, Filter.NEAREST, overwrite=True, extra=("--verbose",))
    request = understood(asked)
    assert (request.preview, request.overwrite, request.verbose) == (Filter.NEAREST, True, True)
    assert request.unsaved_images == FOLDER / "images"


def test_auto_is_the_device_that_the_sessions_preferences_name() -> None:
    asked = Order(replace(HANDOVER, device="optix"), "Vase", BakeSpec(), FOLDER)
    assert understood(asked).spec.device == "optix"


def test_inside_blender_its_own_settings_and_scripts_of_the_file_are_left_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = ("/wheels/größer", "C:\\a'b")
    line = command(Program("/opt/blender", is_blender=True, paths=found), order(BakeSpec()))
    before, after = line[: line.index("--")], line[line.index("--") + 1 :]
    assert before[0] == "/opt/blender"
    assert {"--background", "--factory-startup", "--disable-autoexec"} <= set(before)
    assert before.index(str(HANDOVER.blend)) < before.index("--python-expr") < before.index("--python")
    assert Path(before[-1]).name == "bake.py"
    assert Path(before[-1]).is_file()
    code = before[before.index("--python-expr") + 1]
    monkeypatch.setattr(sys, "path", ["/wheels/größer"])
    exec(code)
    assert sys.path == list(found)
    assert parse(after, inside_blender=True).spec == replace(BakeSpec(), device="cpu")


def test_with_the_bpy_module_the_file_is_an_argument() -> None:
    line = command(Program("/usr/bin/python", is_blender=False), order(BakeSpec()))
    assert line[0] == "/usr/bin/python"
    assert line[2] == str(HANDOVER.blend)


# what a worker says


def progress(stage: Stage, done: int, total: int, left: float | None = None) -> Mapping[str, Any]:
    return {"event": "progress", "stage": str(stage), "done": done, "total": total, "seconds_left": left}


def job(spec: BakeSpec | None = None) -> Job:
    return Job.of(1, order(spec or BakeSpec()))


@pytest.mark.parametrize("case", SPECS)
def test_the_bar_runs_once_from_nothing_to_the_end(case: str) -> None:
    shared = SPECS[case].layout is Layout.SHARED
    absent = {Stage.PREVIEW, Stage.FILL if shared else Stage.FIT}
    if not SPECS[case].condensed:
        absent.add(Stage.CONDENSE)
    known, fractions = job(SPECS[case]), [0.0]
    for stage in Stage:
        for done in range(3) if stage not in absent else ():
            known = known.hears(progress(stage, done, 2))
            fractions.append(known.fraction)
    assert fractions == sorted(fractions)
    assert fractions[-1] == pytest.approx(1)
    assert max(later - earlier for earlier, later in pairwise(fractions)) < 0.5
    assert known.stage is Stage.WRITE


def test_the_bar_never_runs_back() -> None:
    known = job().hears(progress(Stage.CAPTURE, 3, 4))
    assert known.hears(progress(Stage.CAPTURE, 2, 9)).fraction == known.fraction


def test_the_time_left_covers_what_comes_after_a_stage() -> None:
    assert job().hears(progress(Stage.CAPTURE, 0, 4)).seconds_left is None
    half = job().hears(progress(Stage.CAPTURE, 2, 4, left=30))
    assert half.seconds_left is not None
    assert 30 < half.seconds_left < 60
    assert half.hears(progress(Stage.WRITE, 0, 1)).seconds_left == half.seconds_left
    condensed = job(SPECS["a budget"]).hears(progress(Stage.CAPTURE, 2, 4, left=30))
    assert condensed.seconds_left is not None
    assert condensed.seconds_left > 60, "fitting and condensing are to come"


def test_what_else_a_worker_says() -> None:
    known = job()
    for event in (
        {"event": "warning", "message": "no light"},
        {"event": "picture", "path": "/tmp/a.png"},
        {"event": "from a later version"},
        {"event": "done", "files": ["/out/a.exr"], "summary": "Vase: 16 x 16 texels"},
    ):
        known = known.hears(event)
    assert known.warnings == ("no light",)
    assert known.picture == Path("/tmp/a.png")
    done = known.ends(State.DONE, "")
    assert (done.files, done.message, done.fraction) == ((Path("/out/a.exr"),), "Vase: 16 x 16 texels", 1)
    assert done.ended
    assert not known.ended
