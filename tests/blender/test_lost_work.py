# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs that stop between two of their files: going on makes what is missing, and no more.

Real kills at many more places: `python -m tests.bench.renames`.
"""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.core.errors import BakeError, InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.export.folder import is_whole
from radtex_addon.export.targets import web
from radtex_addon.formats.sidecar import read_sidecar
from radtex_addon.forms.layered import bake as layered
from radtex_addon.job import bake_object
from radtex_addon.job import baking as run
from radtex_addon.job.preflight import run_preflight
from radtex_addon.settings.spec import BakeSpec, Kind, Layout
from radtex_addon.store.output_files import images_of
from radtex_addon.textures.export_spec import Target
from tests.bench.renames import Bench, contents
from tests.blender.batch_process import Batch
from tests.blender.room import fill_room, save_room

context: Any = bpy.context  # to the stubs, every pointer may be None

SMALL = ("--layout", "buckets", "--uv", "UVMap", "--texels", "16", "--bucket", "2", "--samples", "1")
SPEC = BakeSpec(uv_layer="UVMap", texels=16, bucket=2, samples=1)
MORE = replace(SPEC, accumulate=True)

pytestmark = pytest.mark.one_blender  # each resumes bakes and exports (test_resume, test_export)


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return save_room(tmp_path_factory.mktemp("room") / "room.blend")


@pytest.fixture
def batch(batch: Batch, room: Path, out: Path) -> Batch:
    """The batch with the room, small bakes and the folder."""
    return partial(batch, room, *SMALL, "--out", out, "--progress", "none")


@pytest.fixture
def ball() -> None:
    fill_room()


def bake(out: Path, spec: BakeSpec = SPEC, preview: bool = True, **options: Any) -> Any:
    shown = Filter.NEAREST if preview else None
    return bake_object(context.scene, "Ball", spec, out, preview=shown, **options)


def fail_at(monkeypatch: pytest.MonkeyPatch, ending: str) -> None:
    """Let no file take a place whose name ends so, outside of hidden folders."""
    move = Path.replace

    def stopped(path: Path, place: Path) -> Path:
        if Path(place).name.endswith(ending) and ".radtex-unfinished" not in str(place):
            raise OSError(5, "Input/output error")
        return move(path, place)

    monkeypatch.setattr(Path, "replace", stopped)


def full(*_: object, **__: object) -> None:
    raise BakeError("the disk is full")


# several objects


def test_several_objects_are_gone_on_with_once_the_first_is_finished(batch: Batch, out: Path) -> None:
    assert batch("--object", "Ball").code == 0
    before = (out / "Ball.radiance.json").stat().st_mtime_ns
    ended = batch("--object", "Ball", "--object", "Floor", "--resume")
    assert (ended.code, ended.err) == (0, "")
    assert (out / "Floor.radiance.json").is_file()
    assert (out / "Ball.radiance.json").stat().st_mtime_ns == before, "what is finished is baked again"


def test_what_the_last_kill_left_of_finished_objects_goes(batch: Batch, out: Path) -> None:
    both = ("--object", "Ball", "--object", "Floor")
    assert batch(*both).code == 0
    whole = contents(out)
    left = out / "Ball.radiance.radtex-unfinished"  # killed behind the removal of its key
    left.mkdir()
    (left / "lock").touch()
    (left / "tile-000000-3.piece").write_bytes(b"of the bake")
    ended = batch(*both, "--resume")
    assert (ended.code, ended.err) == (0, "radtex: note: all 2 bakes are finished: nothing is left to do\n")
    assert contents(out) == whole


def test_an_object_that_was_baked_otherwise_is_not_taken_for_finished(batch: Batch) -> None:
    both = ("--object", "Ball", "--object", "Floor")
    assert batch(*both).code == 0
    for other in (("--bucket", "4"), ("--texels", "20"), ("--layer", "diffuse")):
        ended = batch(*both, "--resume", *other)
        assert ended.code == 2, other
        assert "Ball.radiance.json is already there" in ended.err


def test_several_objects_are_added_to_though_the_run_stopped_in_the_first(
    batch: Batch, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    both = ("--object", "Ball", "--object", "Floor", "--no-denoise")
    assert batch(*both).code == 0
    assert batch(*both, "--accumulate").code == 0
    with monkeypatch.context() as patch:
        fail_at(patch, "Ball.radiance.json")
        assert batch(*both, "--accumulate").code == 1
    ended = batch(*both, "--accumulate", "--resume")
    assert (ended.code, ended.err) == (0, "")
    assert [read_sidecar(out / f"{name}.radiance.json").samples for name in ("Ball", "Floor")] == [3, 3]
    assert batch(*both, "--accumulate", "--resume").code == 2
    assert {path.suffix for path in out.iterdir()} == {".exr", ".json"}


def test_the_second_object_and_exports_are_overwritten_though_the_run_stopped_before_them(
    batch: Batch, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Old files, of the same specification, look as if they were made by the run."""
    asked = ("--object", "Ball", "--object", "Floor", "--save-preview", "--export", "raw")
    assert batch(*asked).code == 0
    made = [out / "Floor.radiance.json", out / "Floor.raw" / "Floor.export.json"]
    whole, before = contents(out), [path.stat().st_mtime_ns for path in made]
    with monkeypatch.context() as patch:
        fail_at(patch, "Ball.radiance.exr")
        assert batch(*asked, "--overwrite").code == 1
    ended = batch(*asked, "--resume")
    assert (ended.code, ended.err) == (0, "")
    assert contents(out) == whole
    assert all(path.stat().st_mtime_ns > old for path, old in zip(made, before, strict=True))


# exports and previews


def test_an_export_that_failed_is_made_by_going_on(
    batch: Batch, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = ("--object", "Ball", "--save-preview", "--frames", "1,2", "--export", "raw")
    with monkeypatch.context() as patch:
        patch.setattr("radtex_addon.export.exporting.write_manifest", full)
        ended = batch(*asked)
    assert ended.code == 1
    assert (
        ended.err
        == "radtex: the disk is full; what is finished of 'Ball' is kept: go on with it (--resume)\n"
    )
    assert not (out / "Ball-0001.raw").exists()
    before = (out / "Ball-0001.radiance.json").stat().st_mtime_ns
    ended = batch(*asked, "--resume")
    assert (ended.code, ended.err) == (0, "")
    assert all(is_whole(out / f"Ball-000{frame}.raw") for frame in (1, 2))
    assert (out / "Ball-0001.radiance.json").stat().st_mtime_ns == before, "it is only the export that lacked"
    assert not list(out.glob(".*")) + list(out.glob("*unfinished"))


def test_a_finished_frame_whose_export_is_missing_gets_it(batch: Batch, out: Path) -> None:
    asked = ("--object", "Ball", "--save-preview", "--frames", "1,2")
    assert batch(*asked).code == 0
    before = contents(out)
    ended = batch(*asked, "--export", "gltf", "--resume")
    assert (ended.code, ended.err) == (0, "")
    assert "Ball, frame 1 (1 of 2): was baked already" in ended.out
    assert is_whole(out / "Ball-0001.gltf")
    assert is_whole(out / "Ball-0002.gltf")
    assert before.items() <= contents(out).items()


@pytest.mark.usefixtures("ball")
def test_a_finished_bake_gets_the_preview_and_the_exports_that_it_lacks(out: Path) -> None:
    bake(out, preview=False)
    before = contents(out)
    made = bake(out, resume=True, exports=(Target.RAW,))
    assert made.was_finished
    assert made.exported == (out / "Ball.raw",)
    assert is_whole(out / "Ball.raw")
    assert {"Ball.preview.blend", "Ball.raw", *before} == {path.name for path in out.iterdir()}
    assert before.items() <= contents(out).items(), "the atlas is touched"
    with pytest.raises(InputError, match="nothing of object 'Ball' is unfinished"):
        bake(out, resume=True, exports=(Target.RAW,))


@pytest.mark.usefixtures("ball")
def test_no_preview_is_made_of_a_mesh_that_is_another_now(out: Path) -> None:
    bake(out, preview=False)
    before = contents(out)
    context.scene.objects["Ball"].data.vertices[0].co.x += 0.01
    with pytest.raises(InputError, match=r"is no longer what .*Ball\.radiance\.json is of.*bake it anew"):
        bake(out, resume=True)
    assert contents(out) == before


@pytest.mark.usefixtures("ball")
def test_an_old_export_beside_an_overwritten_bake_is_made_anew(
    out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bake(out, exports=(Target.RAW,))
    light = context.scene.objects["Lamp"].data
    light.energy *= 2
    bake(out.with_name("whole"), exports=(Target.RAW,))
    with monkeypatch.context() as patch:
        patch.setattr(run, "export_steps", full)
        with pytest.raises(BakeError, match="full"):
            bake(out, exports=(Target.RAW,), overwrite=True)
    bake(out, exports=(Target.RAW,), resume=True)
    assert contents(out) == contents(out.with_name("whole"))


def test_a_web_page_that_was_not_built_is_missed_before_the_bake(
    batch: Batch, out: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(web, "BUILT", tmp_path / "built")
    ended = batch("--object", "Ball", "--save-preview", "--export", "web")
    assert ended.code == 2
    assert ended.err.startswith("radtex: the web page lacks index.html: build it")
    assert not out.exists()


@pytest.mark.usefixtures("ball")
def test_the_panel_foresees_what_an_export_lacks(
    out: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(web, "BUILT", tmp_path / "built")
    found = run_preflight(context.scene, ["Ball"], SPEC, out, preview=True, targets=(Target.WEB,))
    assert tuple(map(str, found.errors)) == (
        "the web page lacks index.html: build it with `uv run .ci/build_web.py`",
    )
    monkeypatch.setattr("radtex_addon.export.gltf.find_spec", lambda _: None)
    found = run_preflight(context.scene, ["Ball"], SPEC, out, preview=True, targets=(Target.RAW,))
    assert str(found.errors[0]).startswith("this Blender has no glTF exporter")


# more samples, and other light


@pytest.mark.usefixtures("ball")
@pytest.mark.parametrize("again", ["accumulate", "refresh"])
@pytest.mark.parametrize("ending", [".exr", ".json", ".preview.blend"])
def test_what_was_added_to_an_atlas_is_gone_on_with_wherever_it_stops(
    again: str, ending: str, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    spec = replace(SPEC, accumulate=again == "accumulate", refresh=again == "refresh")
    whole = out.with_name("whole")
    for folder in (out, whole):
        bake(folder, replace(SPEC, seed=5))
    bake(whole, spec)
    with monkeypatch.context() as patch:
        fail_at(patch, ending)
        with pytest.raises(BakeError, match=rf"out/Ball\S*{ending} could not be written: Input/output error"):
            bake(out, spec)
    bake(out, spec, resume=True)
    assert contents(out) == contents(whole)


@pytest.mark.usefixtures("ball")
def test_more_samples_may_be_begun_anew_though_the_earlier_ones_have_half_of_their_files(
    out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = out.with_name("whole")
    for folder in (out, whole):
        bake(folder)
    for _ in range(2):
        bake(whole, MORE)
    with monkeypatch.context() as patch:
        fail_at(patch, ".json")
        with pytest.raises(BakeError):
            bake(out, MORE)
    bake(out, MORE, overwrite=True)
    assert contents(out) == contents(whole)


# every layout


@pytest.mark.usefixtures("ball")
@pytest.mark.parametrize(
    "spec",
    [
        replace(SPEC, kind=Kind.SHADOW),
        replace(SPEC, kind=Kind.AO),
        replace(SPEC, kind=Kind.TRANSFER),
        replace(SPEC, layout=Layout.LAYERED, bucket=14),
    ],
    ids=lambda spec: f"{spec.kind}-{spec.layout}",
)
def test_all_files_of_a_layout_get_their_places_without_a_second_bake(
    spec: BakeSpec, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = out.with_name("whole")
    bpy.data.objects["Floor"].hide_render = True  # the layered layout would take pictures of it
    bake(whole, spec)
    with monkeypatch.context() as patch:
        fail_at(patch, ".json")
        with pytest.raises(BakeError, match=r"out/Ball\S*\.json could not be written"):
            bake(out, spec)
    monkeypatch.setattr(run, "form_for", full)
    monkeypatch.setattr(layered, "fit_layered", full)
    made = bake(out, spec, resume=True)
    assert made.paths > 0
    assert contents(out) == contents(whole)


# real kills


@pytest.mark.skipif(sys.platform == "win32", reason="there are no signals")
def test_a_kill_at_a_rename_costs_nothing(tmp_path: Path) -> None:
    outcome = Bench(tmp_path).run("accumulate", 1, 0.2)
    assert (outcome.kills, outcome.problems) == (1, [])


def test_an_overwrite_in_another_layout_that_stopped_leaves_none_of_the_earlier_images(
    batch: Batch, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = ("--object", "Ball", "--layout", "layered", "--bucket", "14")
    assert batch("--object", "Ball", "--layer", "diffuse").code == 0
    with monkeypatch.context() as patch:
        fail_at(patch, "Ball.radiance.json")
        assert batch(*other, "--overwrite").code == 1
    assert batch(*other, "--resume").code == 0
    names = {path.name for path in out.iterdir()}
    assert "Ball.radiance.colour.exr" in names
    assert not names & {"Ball.radiance.exr", "Ball.radiance.diffuse.exr"}


def test_layers_that_radtex_never_wrote_are_no_images_of_it(ball: None, out: Path) -> None:
    sidecar = bake(out, preview=False).files.sidecar
    facts = json.loads(sidecar.read_text())
    for layer in ("../../else", "a/b", "\0", "x" * 300):
        sidecar.write_text(json.dumps(facts | {"layers": [layer, "diffuse"]}))
        found = {path.name for path in images_of(sidecar)}
        assert found == {"Ball.radiance.exr", "Ball.radiance.diffuse.exr", "Ball.radiance.diffuse.dds"}


def test_an_accumulation_that_never_began_is_not_taken_for_finished(batch: Batch) -> None:
    """It lacks the preview, and the atlas has as many samples as are to be added."""
    assert batch("--object", "Ball").code == 0
    ended = batch("--object", "Ball", "--accumulate", "--save-preview", "--resume")
    assert ended.code == 2
    assert ended.err.endswith("it has 1 samples a cell: leave --resume out for more\n")
