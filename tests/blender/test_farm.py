# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A farm's frames make what a local bake makes; what is wrong with them is said in one go."""

from __future__ import annotations

import json
import re
import shlex
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.bake.progress import finished
from radtex_addon.core.errors import BakeError, FormatError, InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.farm.assemble_farm import assemble_steps
from radtex_addon.farm.frame_list import frame_list
from radtex_addon.farm.prepare_farm import prepare_steps
from radtex_addon.job import bake_object
from radtex_addon.settings.spec import BakeSpec, Layer
from radtex_addon.store.checkpoint import Checkpoint
from tests.blender.batch_process import Batch, refusal
from tests.blender.farming import BOX, assembled, build_moving_scene, prepared, render, rewrite_frame
from tests.blender.killed import digests

SPEC = BakeSpec(texels=16, bucket=4, samples=1, seed=3, sheet=16, layers=(Layer.DIFFUSE,), denoise=True)
FRAMES = 4


@dataclass(frozen=True)
class Rendered:
    """A farm all of whose frames are there, and the folder of the same bake, made here."""

    farm: Path
    local: Path


@pytest.fixture(scope="module")
def rendered(tmp_path_factory: pytest.TempPathFactory) -> Rendered:
    """Prepared, rendered far from here, and baked here."""
    folder = tmp_path_factory.mktemp("farm")
    scene = build_moving_scene(folder)
    bake_object(scene, BOX, SPEC, folder / "local", preview=Filter.QUADRILINEAR)
    farm = prepared(scene, SPEC, folder / "far", preview=True).files.folder
    assert json.loads((farm / "farm.json").read_text())["frames"] == [1, FRAMES]
    away = folder / "node"
    away.mkdir()
    for name in ("farm.blend", "render_frames.py"):  # a node needs no more
        shutil.copy(farm / name, away)
    render(away, f"1..{FRAMES}")
    shutil.rmtree(farm / "frames")
    shutil.move(away / "frames", farm / "frames")
    return Rendered(farm, folder / "local")


@pytest.fixture
def farm(rendered: Rendered, tmp_path: Path) -> Path:
    """A copy to do harm to."""
    return Path(shutil.copytree(rendered.farm, tmp_path / rendered.farm.name))


def test_frames_become_what_a_local_bake_makes(rendered: Rendered, out: Path) -> None:
    result = assembled(rendered.farm, out).result
    names = {path.name for path in result.files.all}
    assert names == {path.name for path in out.iterdir()}
    assert names == {path.name for path in rendered.local.iterdir()}
    for name in names - {f"{BOX}.preview.blend"}:
        assert (out / name).read_bytes() == (rendered.local / name).read_bytes(), name


def test_the_preview_shows_the_copy_with_the_atlas(rendered: Rendered, out: Path) -> None:
    preview = assembled(rendered.farm, out).result.files.preview
    bpy.ops.wm.open_mainfile(filepath=str(preview))
    box = bpy.data.objects[BOX]
    assert "radtex_tangent" in box.data.attributes
    paths = {bpy.path.abspath(image.filepath) for image in bpy.data.images if image.filepath}
    assert str(out / f"{BOX}.radiance.exr") in paths
    assert "Cloth" in bpy.data.objects


def test_the_file_needs_no_other_and_holds_nobodys_animation(rendered: Rendered) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(rendered.farm / "farm.blend"))
    scene = bpy.context.scene
    assert bpy.utils.blend_paths(absolute=True, packed=False) == []
    assert (scene.frame_start, scene.frame_end, scene.render.filepath) == (1, FRAMES, "//frames/####")
    moving = [item.name for item in bpy.data.objects if item.animation_data]
    assert moving == []
    lamp: Any = bpy.data.lights[0]
    assert lamp.animation_data is None
    assert lamp.energy == 70
    assert bpy.data.texts[:] == []


@pytest.mark.one_blender
def test_all_bad_frames_are_named_at_once_and_what_renders_them(farm: Path, out: Path) -> None:
    frames = farm / "frames"
    (frames / "0001.exr").unlink()
    cut = (frames / "0002.exr").read_bytes()
    (frames / "0002.exr").write_bytes(cut[: len(cut) // 2])
    shutil.copy(frames / "0004.exr", frames / "0003.exr")
    shutil.copy(frames / "0004.exr", frames / "copy.exr")
    with pytest.raises(BakeError) as caught:
        assembled(farm, out)
    said = str(caught.value)
    assert "3 of 4 frames cannot be used: 1 missing; 3 another frame's picture (3 is 4); 2 damaged" in said
    assert "copy.exr (a duplicate of 4)" in said
    assert f"{farm / 'farm.blend'} -f 1..3 " in said
    assert not out.exists()
    runner = re.search(r"python (\S+/render_frames.py -f \S+?);", said)
    assert runner is not None
    script, _, listed = shlex.split(runner[1])
    (frames / "copy.exr").unlink()
    render(Path(script).parent, listed)
    assembled(farm, out)


def _foreign(frame: Path) -> None:
    rewrite_frame(frame, Note="RadTex job of somebody else")


def _unstamped(frame: Path) -> None:
    rewrite_frame(frame, Note="", Frame="")


def _scratched(frame: Path) -> None:
    spoilt = bytearray(frame.read_bytes())
    middle = len(spoilt) // 2
    spoilt[middle : middle + 64] = bytes(64)
    frame.write_bytes(bytes(spoilt))


def _small(frame: Path) -> None:
    rewrite_frame(frame, rows=4)


def _nan(frame: Path) -> None:
    rewrite_frame(frame, value=float("nan"))


def _text(frame: Path) -> None:
    frame.write_text("no picture")


HARMS: list[tuple[Callable[[Path], None], str]] = [
    (_foreign, "of another job"),
    (_unstamped, "of another job"),
    (_scratched, "damaged"),
    (_small, "damaged"),
    (_nan, "not numbers"),
    (_text, "damaged"),
]


@pytest.mark.one_blender
def test_a_bad_frame_is_told_from_others(farm: Path, out: Path) -> None:
    frame = farm / "frames" / "0002.exr"
    whole = frame.read_bytes()
    for harm, fault in HARMS:
        frame.write_bytes(whole)
        harm(frame)
        with pytest.raises(BakeError, match=rf"1 of 4 frames cannot be used: 2 {fault}.*-f 2 "):
            assembled(farm, out)
        assert not out.exists()


@pytest.mark.one_blender
@pytest.mark.parametrize("name", ["plan.npz", "preview.blend", "farm.json"])
def test_a_damaged_farm_is_named(name: str, farm: Path, out: Path) -> None:
    (farm / name).write_bytes(b"{}")
    with pytest.raises(FormatError, match=re.escape(name)):
        assembled(farm, out)


def test_a_folder_without_a_farm_is_named(out: Path) -> None:
    with pytest.raises(InputError, match="holds no farm"):
        assembled(out)


@pytest.mark.one_blender
def test_nothing_is_overwritten_unasked(rendered: Rendered, out: Path) -> None:
    assembled(rendered.farm, out)
    with pytest.raises(InputError, match="overwrite it"):
        assembled(rendered.farm, out)
    sidecar = out / f"{BOX}.radiance.json"
    facts = json.loads(sidecar.read_text())
    for there, said in (
        ({"object": "Other"}, f"is a bake of object 'Other', not of object '{BOX}'"),
        ({"blend": "other.blend"}, "is a bake of other.blend, not of"),
        ({"samples": 2}, "is a better bake"),
    ):
        sidecar.write_text(json.dumps(facts | there))
        with pytest.raises(InputError, match=said):
            finished(assemble_steps(rendered.farm, out, overwrite=True))
        assert json.loads(sidecar.read_text()) == facts | there
    finished(assemble_steps(rendered.farm, out, overwrite=True, overwrite_any=True))


@pytest.mark.one_blender
def test_an_assembly_that_was_killed_is_simply_run_again(
    rendered: Rendered, tmp_path: Path, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = tmp_path / "whole"
    assembled(rendered.farm, whole)

    def killed(*_: object) -> None:
        raise OSError(5, "Input/output error")

    with monkeypatch.context() as patch:
        patch.setattr("radtex_addon.farm.assemble_farm._save_preview", killed)
        patch.setattr(Checkpoint, "drop_own", lambda _: None)  # no dying process does it
        with pytest.raises(OSError, match="Input/output"):
            assembled(rendered.farm, out)
    assert list(out.glob("*.radtex-unfinished"))
    assembled(rendered.farm, out)
    assert digests(out) == digests(whole)


@pytest.mark.one_blender
def test_an_earlier_farm_stays_until_the_new_one_has_its_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = build_moving_scene(tmp_path)
    spec = BakeSpec(texels=16, bucket=4, samples=1, sheet=16)
    farm = prepared(scene, spec, tmp_path / "out").files
    before = farm.manifest.read_bytes()
    move = Path.rename

    def stopped(path: Path, place: Path) -> Path:
        if place == farm.folder and path.suffix == ".new":
            raise OSError(5, "Input/output error")
        return move(path, place)

    def again() -> None:
        finished(prepare_steps(build_moving_scene(tmp_path), BOX, spec, tmp_path / "out", overwrite=True))

    with monkeypatch.context() as patch:
        patch.setattr(Path, "rename", stopped)
        with pytest.raises(BakeError, match="could not be written: Input/output error"):
            again()
    assert farm.manifest.read_bytes() == before
    assert [path.name for path in (tmp_path / "out").iterdir()] == [farm.folder.name]
    again()
    assert farm.manifest.read_bytes() != before
    assert [path.name for path in (tmp_path / "out").iterdir()] == [farm.folder.name]


@pytest.mark.one_blender
def test_the_batch_prepares_and_names_what_is_missing(tmp_path: Path, batch: Batch) -> None:
    build_moving_scene(tmp_path)
    blend = tmp_path / "a scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    options = ("--object", BOX, "--layout=buckets", "--texels=16", "--bucket=4", "--samples=1", "--sheet=16")
    done = batch("prepare", blend, *options, "--out", tmp_path / "out", "--progress", "json")
    assert done.code == 0, done.err
    event = json.loads(done.out.splitlines()[-1])
    farm = Path(event["files"][0])
    assert farm.name == f"{BOX}.radiance.radtex-farm"
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [farm.name]
    said = refusal(batch("assemble", farm, "--progress", "none"), code=1)
    count = event["frames"][1]
    assert f"{count} of {count} frames cannot be used: 1..{count} missing" in said
    assert "blender -b" in said
    assert [path.name for path in farm.parent.iterdir()] == [farm.name]


def test_lists_of_frames_are_as_blender_reads_them() -> None:
    assert frame_list([9, 3, 7, 8, 8]) == "3,7..9"
    assert frame_list([1, 2]) == "1..2"
