# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a worker is ordered arrives as it was; what it says becomes plain data."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import fields, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mathutils import Euler, Matrix

from radtex_addon.bake.progress import Stage
from radtex_addon.cli.options import ProgressStyle
from radtex_addon.cli.run_work import parse_work, read_order
from radtex_addon.core.errors import FormatError, InputError
from radtex_addon.core.messages import Message
from radtex_addon.core.sampler import Filter
from radtex_addon.report.side_by_side import ComparisonSpec
from radtex_addon.report.viewpoint import Viewpoint
from radtex_addon.settings.choices import Backs
from radtex_addon.settings.estimate import EXPORT
from radtex_addon.settings.options import MARKED
from radtex_addon.settings.spec import BakeSpec, Kind, Layer, Layout, Split, View
from radtex_addon.settings.time_left import time_left
from radtex_addon.textures.export_spec import (
    Arrangement,
    ExportSpec,
    ExportStep,
    ExportTask,
    Target,
    TextureFormat,
)
from radtex_addon.worker.job import Job, JobState
from radtex_addon.worker.order import Handover, Order, Program, Work, command_line, write_order
from radtex_addon.worker.orders import (
    EXPORTING,
    exported_part,
    order_assembly,
    order_bake,
    order_comparison,
    order_export,
    order_preparation,
    order_scene_export,
)

pytestmark = pytest.mark.one_blender

FOLDER = Path("/some where/größer")
ORDER = FOLDER / "order.json"
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
    "memory_mb": 777,
    "sheet": 512,
    "denoise": True,
}
MARKS: dict[str, dict[str, Any]] = {name: {name: True} for name in MARKED}
SPECS = {
    "every choice": BakeSpec(**CHOSEN),
    "none": BakeSpec(device="cpu"),
    "layered": BakeSpec(layout=Layout.LAYERED, device="cpu"),
    "layers": BakeSpec(layers=(Layer.DIFFUSE, Layer.NORMAL), device="cpu"),
    "a proxy": BakeSpec(kind=Kind.PROXY, content="-Shelf", device="cpu"),
    "another object's": BakeSpec(source="-High", extrusion=0.05, device="cpu"),
    "another object's, from a cage": BakeSpec(source="-High", cage="-Cage", device="cpu"),
    "more samples": BakeSpec(accumulate=True, device="cpu"),
    "what has changed": BakeSpec(refresh=True, device="cpu"),
    "some places": BakeSpec(accumulate=True, where="--Rim, upper", device="cpu"),
    "what is near": BakeSpec(kind=Kind.AO, ao_distance=0.25, device="cpu"),
    "a view": BakeSpec(kind=Kind.TRANSFER, view=View.CAMERA, device="cpu"),
    "a density": BakeSpec(density=1500.5, device="cpu"),
    "no backs": BakeSpec(backs=Backs.NONE, device="cpu"),
    "painted weights": BakeSpec(texel_weights="-More, here", device="cpu"),
    "a frame": BakeSpec(frame=7, unwrap_at=1, device="cpu"),
    "objects in one atlas": BakeSpec(objects=("--Vase", "Cup"), device="cpu"),
    "a part": BakeSpec(split=Split.UDIM, uv_layer="Layer", part="1002", device="cpu"),
    "a name of its own": BakeSpec(bake_name="--{object}.{{draft", device="cpu"),
    "some lamps": BakeSpec(lights=("Key, left", "-Fill"), device="cpu"),
    **{name: BakeSpec(device="cpu", **chosen) for name, chosen in MARKS.items()},
}


def order(spec: BakeSpec) -> Order:
    return order_bake(HANDOVER, "--Vase", spec, FOLDER / "out")


def understood(asked: Order, tmp_path: Path, inside_blender: bool = False) -> Any:
    return read_order(parse_work([str(write_order(replace(asked, folder=tmp_path)))], inside_blender))


def test_every_field_of_a_spec_is_among_the_cases() -> None:
    names = {field.name for field in fields(BakeSpec)}
    default = BakeSpec()
    assert names == {
        name for name in names for spec in SPECS.values() if getattr(spec, name) != getattr(default, name)
    }


@pytest.mark.parametrize("case", SPECS)
def test_a_spec_arrives_as_it_was_ordered(case: str, tmp_path: Path) -> None:
    request = understood(order(SPECS[case]), tmp_path)
    bakes = request.bakes
    assert bakes.spec == SPECS[case]
    assert (bakes.objects, request.in_scene) == (SPECS[case].objects or ("--Vase",), "-Scene")
    assert bakes.names == ("--Vase",)
    assert bakes.folder == FOLDER / "out"
    assert (bakes.preview, bakes.overwrite, bakes.resume) == (None, False, False)
    assert (request.progress, request.parent_pipe, request.unsaved_images) == (ProgressStyle.JSON, True, None)


def test_all_else_about_a_bake_arrives(tmp_path: Path) -> None:
    handover, targets = replace(HANDOVER, images=FOLDER / "images"), (Target.WEB, Target.RAW)
    options: Any = {"overwrite": True, "resume": True, "exports": targets}
    asked = order_bake(
        handover, "Vase", BakeSpec(), FOLDER, Filter.NEAREST, picture=FOLDER / "a.png", **options
    )
    request = understood(asked, tmp_path)
    bakes = request.bakes
    assert (bakes.preview, bakes.overwrite, bakes.resume) == (Filter.NEAREST, True, True)
    assert bakes.exports == targets
    assert (request.thumbnail, request.map_picture) == (FOLDER / "a.png", FOLDER / "a.map.png")
    assert request.unsaved_images == FOLDER / "images"


def test_auto_is_the_device_that_the_sessions_preferences_name(tmp_path: Path) -> None:
    asked = order_bake(replace(HANDOVER, device="optix"), "Vase", BakeSpec(), FOLDER)
    assert understood(asked, tmp_path).bakes.spec.device == "optix"


def test_an_order_that_no_bake_can_have_is_refused(tmp_path: Path) -> None:
    file = write_order(replace(order(BakeSpec()), folder=tmp_path))
    file.write_text(
        file.read_text(encoding="utf-8").replace('"texels": 128', '"texels": -1'), encoding="utf-8"
    )
    with pytest.raises(FormatError, match=r"order-.*\.json.*a bake that cannot be"):
        read_order(parse_work([str(file)], inside_blender=False))
    with pytest.raises(InputError, match="a worker takes one order"):
        parse_work([], inside_blender=False)


def test_inside_blender_its_own_settings_and_scripts_of_the_file_are_left_out(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = ("/wheels/größer", "C:\\a'b")
    line = command_line(Program("/opt/blender", is_blender=True, paths=found), order(BakeSpec()), ORDER)
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
    assert after == ["work", str(ORDER)]


def test_with_the_bpy_module_the_worker_opens_the_file(tmp_path: Path) -> None:
    line = command_line(Program("/usr/bin/python", is_blender=False), order(BakeSpec()), ORDER)
    assert (line[0], line[2:]) == ("/usr/bin/python", ["work", str(ORDER)])
    asked = order(BakeSpec())
    assert understood(asked, tmp_path).scene == HANDOVER.blend
    assert understood(asked, tmp_path, inside_blender=True).scene is None, "Blender has opened it"


def test_an_export_arrives_as_it_was_ordered(tmp_path: Path) -> None:
    line: list[str] = []
    chosen = ExportSpec(Target.RAW, TextureFormat.EXR, False, Arrangement.SLICES, 3, 512)
    vase = ("Vase", FOLDER / "-Vase.json", FOLDER / "out")
    cup = ("Cup", FOLDER / "Cup.json", FOLDER / "Cup.raw")
    for spec, bakes, overwrite in ((chosen, [vase], True), (ExportSpec(Target.WEB), [vase, cup], False)):
        asked = order_export(FOLDER, bakes, spec, overwrite=overwrite)
        line = command_line(Program("/opt/blender", is_blender=True), asked, ORDER)
        request = understood(asked, tmp_path, inside_blender=True)
        assert request.bakes == tuple((sidecar, out) for _, sidecar, out in bakes)
        assert (request.spec, request.scene) == (spec, None)
        assert isinstance(request.spec.format, TextureFormat)
        assert (request.overwrite, request.progress) == (overwrite, ProgressStyle.JSON)
    assert line[line.index("--python-exit-code") + 2] == "--python-expr", "no file is opened"


def test_an_export_of_a_scene_arrives_as_it_was_ordered(tmp_path: Path) -> None:
    sidecars = [FOLDER / "A.json", FOLDER / "B.json"]
    asked = order_scene_export(FOLDER, sidecars, "Room", ExportSpec(Target.WEB), FOLDER / "out")
    request = understood(asked, tmp_path)
    assert request.bakes == tuple((sidecar, FOLDER / "out") for sidecar in sidecars)
    assert request.scene == "Room"
    assert (asked.object, asked.about) == ("Room", "web")


def test_a_comparison_arrives_as_it_was_ordered(tmp_path: Path) -> None:
    matrix = Matrix.LocRotScale((3.3, -1e-5, 12), Euler((0.1, 0.2, 0.3)), None)
    eye = Viewpoint(np.array(matrix), np.diag([0.5, 1.0, -0.002, 1.0]))
    spec, handover = ComparisonSpec(77, 5), replace(HANDOVER, images=FOLDER / "images", device="optix")
    asked = order_comparison(handover, ["--Vase", "B"], FOLDER / "baked", eye, spec, FOLDER / "out")
    request = understood(asked, tmp_path)
    assert (request.scene, request.in_scene, request.objects) == (HANDOVER.blend, "-Scene", ("--Vase", "B"))
    assert (request.bake, request.spec) == (FOLDER / "baked", replace(spec, device="optix"))
    assert (request.out, request.unsaved_images) == (FOLDER / "out", FOLDER / "images")
    assert (request.progress, request.parent_pipe) == (ProgressStyle.JSON, True)
    assert request.eye is not None
    np.testing.assert_allclose(request.eye.matrix, eye.matrix, atol=1e-6)
    np.testing.assert_array_equal(request.eye.projection, eye.projection)
    assert asked.object == "--Vase, B"


def test_a_farm_arrives_as_it_was_ordered(tmp_path: Path) -> None:
    handover = replace(HANDOVER, images=FOLDER / "images", original=FOLDER / "raum.blend", device="optix")
    bakes = [("--Vase", SPECS["every choice"]), ("Cup", BakeSpec()), ("Cup", SPECS["a frame"])]
    farm = FOLDER / "out" / "raum.radtex-farm"
    asked = order_preparation(handover, bakes, farm, Filter.NEAREST, overwrite=True)
    request = understood(asked, tmp_path)
    assert (request.bakes, request.folder, request.preview) == (tuple(bakes), FOLDER / "out", Filter.NEAREST)
    assert request.bakes[1][1].device == "auto", "each machine of a farm has its own"
    assert (request.overwrite, request.blend) == (True, FOLDER / "raum.blend")
    assert (request.scene, request.in_scene) == (HANDOVER.blend, "-Scene")
    assert (request.unsaved_images, request.parent_pipe) == (FOLDER / "images", True)
    assert (asked.object, asked.out) == ("--Vase, Cup", FOLDER / "out")
    plain = understood(order_preparation(HANDOVER, bakes[:1], farm), tmp_path)
    assert (plain.preview, plain.overwrite, plain.blend) == (None, False, Path())


def test_an_assembly_arrives_as_it_was_ordered(tmp_path: Path) -> None:
    farm, line = FOLDER / "raum.radtex-farm", [""]
    for overwrite, overwrite_any in ((False, False), (True, False), (True, True)):
        asked = order_assembly(
            FOLDER,
            farm,
            ["Vase", "Cup"],
            FOLDER / "out",
            overwrite=overwrite,
            overwrite_any=overwrite_any,
        )
        request = understood(asked, tmp_path)
        assert (request.farm, request.folder) == (farm, FOLDER / "out")
        assert (request.overwrite, request.overwrite_any) == (overwrite, overwrite_any)
        line = command_line(Program("/opt/blender", is_blender=True), asked, ORDER)
    assert line[line.index("--python-exit-code") + 2] == "--python-expr", "no file is opened"


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        (
            order_export(FOLDER, [("Vase", FOLDER, FOLDER)], ExportSpec(Target.RAW)),
            "the export ended early (x): ",
        ),
        (order_bake(HANDOVER, "Vase", BakeSpec(), FOLDER), "the bake ended early (x): bake again, "),
        (
            order_preparation(HANDOVER, [("Vase", BakeSpec())], FOLDER / "Vase.radtex-farm"),
            "the preparation ended early (x): prepare ",
        ),
        (order_assembly(FOLDER, FOLDER, ["Vase"], FOLDER), "the assembly ended early (x): assemble "),
    ],
)
def test_an_order_says_what_to_do_when_it_ended_early(asked: Order, words: str) -> None:
    assert asked.ended_early("x").startswith(words)


# what a worker says


def progress(stage: Stage, done: int, total: int) -> Mapping[str, Any]:
    return {"event": "progress", "stage": str(stage), "done": done, "total": total, "seconds_left": None}


def job(spec: BakeSpec | None = None) -> Job:
    return Job(1, order(spec or BakeSpec()))


@pytest.mark.parametrize("case", SPECS)
def test_the_bar_runs_once_from_nothing_to_the_end(case: str) -> None:
    layered = SPECS[case].layout is Layout.LAYERED
    absent = {Stage.PREVIEW, Stage.FILL if layered else Stage.FIT}
    if not SPECS[case].denoise:
        absent.add(Stage.DENOISE)
    known, fractions = job(SPECS[case]), [0.0]
    for stage in Stage:
        for done in range(3) if stage not in absent else ():
            known = known.hears(progress(stage, done, 2))
            fractions.append(known.fraction)
    assert fractions == sorted(fractions)
    assert fractions[-1] == pytest.approx(1)
    assert max(later - earlier for earlier, later in pairwise(fractions)) < 0.5
    assert known.stage == Stage.WRITE


def test_the_bar_never_runs_back() -> None:
    known = job().hears(progress(Stage.CAPTURE, 3, 4))
    assert known.hears(progress(Stage.CAPTURE, 2, 9)).fraction == known.fraction


def test_the_time_left_covers_what_comes_after_a_stage() -> None:
    def left(known: Job, now: float) -> float:
        assert known.course is not None
        return time_left(known.course, now).seconds

    def half_of(known: Job) -> Job:
        return known.hears(progress(Stage.CAPTURE, 0, 4), 5.0).hears(progress(Stage.CAPTURE, 2, 4), 35.0)

    half, layered = half_of(job()), half_of(job(SPECS["layered"]))
    assert left(half, 35.0) > 20.0
    assert left(layered, 35.0) > left(half, 35.0), "fitting is to come"
    written = half.hears(progress(Stage.WRITE, 0, 1), 65.0)
    assert left(written, 65.0) < left(half, 35.0) / 2
    assert left(half, 35.0) - left(half, 40.0) == pytest.approx(5.0, abs=3.0), "time goes by between reports"


def test_the_exports_of_a_bake_are_in_its_time_left() -> None:
    known = Job(
        1, order_bake(HANDOVER, "Vase", BakeSpec(), FOLDER, exports=(Target.RAW, Target.WEB))
    ).begins()
    assert known.course is not None
    assert known.course.to_come[EXPORT] > 0
    exporting = known.hears({**progress(Stage.WRITE, 0, 1), "stage": "textures"}, 20.0)
    exporting = exporting.hears({**progress(Stage.WRITE, 0, 1), "stage": "pack"}, 23.0)
    assert exporting.course is not None
    assert (exporting.course.stage, exporting.stage) == (EXPORT, "pack")
    assert not exporting.course.to_come
    ended = exporting.ends(JobState.DONE, Message("done"), 25.0).course
    assert ended is not None
    assert ended.took[EXPORT] == pytest.approx(5.0)


def test_a_bakes_bar_gives_each_stage_what_it_typically_takes() -> None:
    few, many = (order(BakeSpec(texels=n, layout=Layout.LAYERED)).stages for n in (32, 512))
    for stages in (few, many):
        assert sum(stages.values()) == pytest.approx(1)
        assert list(stages) == list(Stage)
        assert stages["fill"] == stages["denoise"] == stages["preview"] == 0
    assert few["surroundings"] > few["capture"] > 0  # a few texels are quicker than the pictures around them
    assert many["capture"] > 2 * many["surroundings"] > 0
    plain = order(BakeSpec(texels=64)).stages
    assert plain["fit"] == plain["surroundings"] == 0 < plain["fill"]


def test_an_exports_bar_runs_over_its_own_stages() -> None:
    known = Job(1, order_export(FOLDER, [("Vase", FOLDER, FOLDER)], ExportSpec(Target.RAW)))
    fractions = []
    for task in ExportTask:
        known = known.hears({**progress(Stage.WRITE, 0, 1), "stage": str(task)})
        fractions.append(known.fraction)
    assert (known.work, known.stage) == (Work.EXPORT, "pack")
    assert all(later > earlier for earlier, later in pairwise(fractions))
    assert known.hears(progress(Stage.WRITE, 1, 1)).fraction == known.fraction, (
        "of a stage that is none of its"
    )


def test_the_bar_of_several_exports_counts_bakes() -> None:
    bakes = [(name, FOLDER / f"{name}.json", FOLDER / f"{name}.raw") for name in ("Vase", "Cup", "Jug")]
    known = Job(1, order_export(FOLDER, bakes, ExportSpec(Target.RAW)))
    fractions = []
    for number in range(3):
        for task in ExportTask:
            done = number + exported_part(ExportStep(task, 0, 1))
            event = {"event": "progress", "stage": EXPORTING, "done": done, "total": 3, "seconds_left": None}
            known = known.hears(event)
            fractions.append(known.fraction)
    assert fractions[:: len(ExportTask)] == pytest.approx([0, 1 / 3, 2 / 3])
    assert all(later > earlier for earlier, later in pairwise(fractions))
    assert exported_part(ExportStep(ExportTask.PACK, 1, 1)) == pytest.approx(1)


def test_what_else_a_worker_says() -> None:
    known = job()
    for event in (
        {"event": "warning", "message": "no light", "problem": "no light", "remedies": []},
        {"event": "picture", "path": "/tmp/a.png"},
        {"event": "from a later version"},
        {"event": "done", "files": ["/out/a.exr"], "summary": "Vase: 16 x 16 texels"},
    ):
        known = known.hears(event)
    assert list(map(str, known.warnings)) == ["no light"]
    assert known.picture == Path("/tmp/a.png")
    done = known.ends(JobState.DONE, Message(""))
    assert (done.files, str(done.message), done.fraction) == (
        (Path("/out/a.exr"),),
        "Vase: 16 x 16 texels",
        1,
    )
    assert done.ended
    assert not known.ended
