# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What lies around a bake is odd: temporary folders, streams, other processes."""

from __future__ import annotations

import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import bpy
import pytest

from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import FormatError
from radtex_addon.core.sampler import Filter
from radtex_addon.job import bake_object
from radtex_addon.preview.node_group import check_image
from radtex_addon.settings.spec import BakeSpec
from radtex_addon.textures.export_spec import ExportSpec, Target
from radtex_addon.ui import registration
from radtex_addon.worker import queue as queue_module
from radtex_addon.worker.handover import work_folder
from radtex_addon.worker.order import Program
from radtex_addon.worker.orders import order_export
from tests.blender.batch_process import BAKE, QUICK, Batch, process, refusal
from tests.blender.room import save_room
from tests.blender.test_batch_compare import ABOVE, FLAT
from tests.blender.test_batch_compare import QUICK as FEW_PIXELS
from tests.blender.test_ui_registration import state
from tests.blender.ui_stage import context, ops, registered, settings

pytestmark = pytest.mark.one_blender
BRACES = "{blend_name} {x} }{ {{y}}"
_CLOSED = """
import os, sys
os.close(0)
os.close(2)
os.execv(sys.executable, [sys.executable, {!r}, *sys.argv[1:]])
"""
posix = pytest.mark.skipif(sys.platform == "win32", reason="a POSIX system's names")


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return save_room(tmp_path_factory.mktemp("room") / "room.blend")


@pytest.fixture
def braced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Temporary files go to a folder whose name Blender would read as a template."""
    folder = tmp_path / BRACES
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


@pytest.mark.parametrize(
    ("line", "files"),
    [
        ((*QUICK, "--thumbnail"), 4),
        ((*QUICK, "--kind", "incident", "--capture", "panoramic"), 3),
        (("--uv", "UVMap", "--texels", "8", "--samples", "1", "--progress", "none"), None),
    ],
    ids=["buckets", "panoramic", "layered"],
)
def test_braces_in_names_of_folders_are_no_templates(
    line: tuple[str, ...], files: int | None, room: Path, braced: Path, batch: Batch
) -> None:
    out = braced.parent / "out {scene_name}"
    picture = (out / "{a}.png",) if line[-1] == "--thumbnail" else ()
    ended = batch(room, "--object", "Ball", "--save-preview", "--out", out, *line, *picture)
    assert (ended.code, ended.err) == (0, "")
    assert len(list(out.iterdir())) == files or files is None
    assert list(braced.iterdir()) == []
    assert {path.name for path in braced.parent.iterdir()} == {braced.name, out.name}
    if picture:
        view = (ABOVE, FLAT, *FEW_PIXELS)
        ended = batch("compare", room, "--object", "Ball", "--bake", out, "--out", out, *view)
        assert ended.code == 0, ended.err


@pytest.mark.parametrize(
    ("name", "words"),
    [("a\\b", "takes a backslash"), ("deep/" * 200, "Blender handles 1023"), ("\udcff", "is not Unicode")],
)
@posix
def test_temporary_folders_that_blender_would_misname_are_refused(
    name: str, words: str, room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, batch: Batch
) -> None:
    folder = tmp_path / name
    folder.mkdir(parents=True)
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    line = refusal(batch(room, "--object", "Ball", *QUICK, "--out", tmp_path / "out"))
    assert words in line
    assert "by TMPDIR" in line
    assert not (tmp_path / "out").exists()
    assert list(folder.iterdir()) == []


@posix
def test_a_second_slash_at_the_beginning_is_none(
    room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, batch: Batch
) -> None:
    """As of `--out $HERE/baked` where HERE is /; Blender would look beside the open file."""
    monkeypatch.setattr(tempfile, "tempdir", f"/{tmp_path}")
    places = ("--out", f"/{tmp_path / 'out'}", "--thumbnail", f"//{tmp_path / 'a.png'}")
    ended = batch(f"/{room}", "--object", "Ball", *QUICK, "--save-preview", *places)
    assert (ended.code, ended.err) == (0, "")
    assert str(tmp_path / "out" / "Ball.preview.blend") in ended.out
    ended = batch("export", f"///{tmp_path / 'out'}", "--to", "raw", "--progress", "none")
    assert (ended.code, ended.err) == (0, "")
    assert {path.name for path in tmp_path.iterdir()} == {"out", "a.png"}


# standard error


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that is always full")
@pytest.mark.parametrize("progress", ["bar", "json"])
def test_a_standard_error_that_takes_nothing_loses_no_bake(
    progress: str, room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, batch: Batch
) -> None:
    out = tmp_path / "out"
    line = ("--object", "Ball", *QUICK[:-1], progress, "--out", out)
    for code in (0, 2):  # then the files are there, and nobody hears of it
        with Path("/dev/full").open("w") as full:
            monkeypatch.setattr(sys, "stderr", full)
            assert batch(room, *line).code == code
    assert len(list(out.iterdir())) == 2


@posix
def test_streams_that_are_closed_are_not_given_to_files(room: Path, tmp_path: Path) -> None:
    """The next file that is opened would be standard error, to which Blender and libraries talk."""
    out = tmp_path / "out"
    line = (room, "--object", "Ball", *QUICK, "--out", out)
    ended = process(*line, start=("-c", _CLOSED.format(BAKE)))
    assert (ended.code, ended.err) == (0, "")
    assert len(ended.out.splitlines()) == 3
    assert len(list(out.iterdir())) == 2


# files that go away


def test_an_atlas_that_cannot_be_read_any_more_is_no_wrong_request(tmp_path: Path) -> None:
    """Or the bake would drop all that is finished, with advice that cannot be followed."""
    atlas = tmp_path / "Ball.radiance.exr"
    atlas.touch()
    image = bpy.data.images.new("Ball", 1, 1)
    image.source, image.filepath = "FILE", str(atlas)
    with pytest.raises(FormatError, match=r"radiance.exr: Blender reads no image in it; bake it again$"):
        check_image(image, AtlasLayout(4, 4, 2))


# Blender's window


@pytest.mark.parametrize("mode", ["EDIT", "SCULPT"])
def test_a_bake_with_a_preview_keeps_the_active_object_and_its_mode(
    mode: Any, room: Path, tmp_path: Path
) -> None:
    """A script's next operator works on it."""
    bpy.ops.wm.open_mainfile(filepath=str(room))
    context.view_layer.objects.active = ball = bpy.data.objects["Ball"]
    bpy.ops.object.mode_set(mode=mode)
    before = context.mode
    spec = BakeSpec(texels=4, bucket=2, samples=1, uv_layer="UVMap")
    bake_object(context.scene, "Ball", spec, tmp_path, preview=Filter.NEAREST)
    assert (context.object, context.mode) == (ball, before)


def test_a_folder_that_the_system_refuses_is_one_line(room: Path, tmp_path: Path) -> None:
    """Whatever is asked of a bake there, and not a traceback."""
    bpy.ops.wm.open_mainfile(filepath=str(room))
    with registered():
        settings().directory = str(tmp_path / ("x" * 300))
        for operator in (ops.radtex.preview_toggle, ops.radtex.compare, ops.radtex.export):
            with pytest.raises(
                RuntimeError, match=r"^Error: .*x cannot be read: .*; choose another folder\n$"
            ):
                operator(object="Ball")


def test_disabling_works_where_others_have_emptied_the_lists_of_handlers() -> None:
    before = state()
    registration.register()
    for name in ("depsgraph_update_post", "undo_post", "load_post", "save_post"):
        getattr(bpy.app.handlers, name).clear()
    registration.unregister()
    assert {**state(), "handlers": None} == {**before, "handlers": None}


def test_a_clock_that_jumps_takes_no_waiting_job_its_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As a computer's that has slept: folders of yesterday are taken for left ones."""
    folders = [work_folder(tmp_path) for _ in range(2)]
    queue = queue_module.Queue(Program(sys.executable, is_blender=False))
    spec = ExportSpec(Target.RAW)
    for folder in folders:
        queue.add(order_export(folder, [("x", tmp_path / "none.json", tmp_path / "out")], spec))
    try:
        long_ago = time.time() - 3 * 86400
        os.utime(folders[1], (long_ago, long_ago))
        monkeypatch.setattr(queue_module, "time", lambda: time.time() + 3 * 86400, raising=False)
        queue.advance()
        work_folder(tmp_path)  # another job's, which looks for those that were left
        assert folders[1].is_dir()
    finally:
        queue.close()
