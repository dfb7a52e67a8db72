# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files appear whole or not at all, and nothing of the user's is destroyed unasked."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from radtex_addon.core.errors import BakeError, FormatError, InputError
from radtex_addon.formats.disk.atomic import (
    check_absent,
    check_writable,
    replacing,
    replacing_together,
    write_text,
)
from tests.blender.disk import small_disk, unavailable


def test_a_file_appears_only_when_it_is_whole(tmp_path: Path) -> None:
    target = tmp_path / "new" / "folder" / "a.exr"
    with replacing(target) as beside:
        assert beside.parent == target.parent
        assert beside.suffix == ".exr"
        beside.write_text("whole")
        assert not target.exists()
    assert target.read_text() == "whole"
    assert list(target.parent.iterdir()) == [target]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, SystemExit])
def test_after_any_interruption_the_folder_is_what_it_was(tmp_path: Path, error: type[BaseException]) -> None:
    target = tmp_path / "a.json"
    target.write_text("old")

    def interrupted() -> None:
        with replacing(target) as beside:
            beside.write_text("half")
            raise error

    with pytest.raises(error):
        interrupted()
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.skipif(sys.platform == "win32", reason="Windows settles no names")
@pytest.mark.parametrize("writing", [replacing, replacing_together])
def test_the_disk_has_a_file_before_its_name_changes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, writing: Any
) -> None:
    target, seen = tmp_path / "a.json", []
    settle = os.fsync

    def noted(descriptor: int) -> None:
        is_folder = stat.S_ISDIR(os.fstat(descriptor).st_mode)
        seen.append((is_folder, os.fstat(descriptor).st_size if not is_folder else 0, target.exists()))
        settle(descriptor)

    monkeypatch.setattr(os, "fsync", noted)
    with writing(target) as beside:
        beside.write_text("whole")
    assert seen == [(False, 5, False), (True, 0, True)]


@pytest.mark.skipif(bool(unavailable()), reason=unavailable())
def test_a_power_cut_leaves_a_whole_file(tmp_path: Path) -> None:
    with small_disk(tmp_path) as disk:
        for name in ("new", "old", "passing"):
            if name != "new":
                write_text(disk.folder / name, "old")
            with replacing(disk.folder / name, lasting=name != "passing") as beside:
                beside.write_bytes(bytes(300_000))
        disk.cut_power()
        disk.restart()
        sizes = {path.name: path.stat().st_size for path in disk.folder.iterdir() if path.is_file()}
    assert sizes.pop("passing") in (3, 300_000)  # as the system was quick to write
    assert sizes == {"new": 300_000, "old": 300_000}


def test_an_error_names_the_file_that_it_is_of(tmp_path: Path) -> None:
    """Also where several are written at once, and by a library that tells of it in its own words."""

    def full() -> None:
        with replacing(tmp_path / "a.exr") as one, replacing(tmp_path / "b.exr") as other:
            other.touch()
            raise OSError(f'Failed to write pixel data to image file "{one}". No space left on device.')

    with pytest.raises(BakeError, match=r"/a\.exr could not be written: No space left on device; free its"):
        full()
    assert list(tmp_path.iterdir()) == []


def contents(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in folder.iterdir()}


def test_files_move_together_when_all_went_well(tmp_path: Path) -> None:
    sidecar = tmp_path / "new" / "a.json"
    with replacing_together(sidecar) as beside:
        assert beside.parent.parent == sidecar.parent
        for name in ("a.json", "a.exr", "z.exr"):
            beside.with_name(name).write_text("new")
        assert [path.is_dir() for path in sidecar.parent.iterdir()] == [True]
    assert contents(sidecar.parent) == {"a.json": "new", "a.exr": "new", "z.exr": "new"}


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, GeneratorExit])
def test_or_none_of_them_does(tmp_path: Path, error: type[BaseException]) -> None:
    sidecar = tmp_path / "a.json"
    sidecar.write_text("old")

    def interrupted() -> None:
        with replacing_together(sidecar) as beside:
            beside.write_text("new")
            beside.with_name("a.exr").write_text("new")
            raise error

    with pytest.raises(error):
        interrupted()
    assert contents(tmp_path) == {"a.json": "old"}


def test_the_named_file_moves_last(tmp_path: Path) -> None:
    """Where another cannot take its place, none speaks of it; the error names that place."""
    sidecar = tmp_path / "a.json"
    (tmp_path / "z.exr").mkdir()

    def blocked() -> None:
        with replacing_together(sidecar) as beside:
            for name in ("a.json", "z.exr"):
                beside.with_name(name).write_text("new")

    with pytest.raises(BakeError, match=r"z\.exr could not be written: .*; free its disk"):
        blocked()
    assert [path.name for path in tmp_path.iterdir()] == ["z.exr"]


def test_errors_name_files_by_their_places(tmp_path: Path) -> None:
    def damaged() -> None:
        with replacing_together(tmp_path / "a.json") as beside:
            raise FormatError(f"{beside.with_name('a.exr')} is damaged: bake it again")

    with pytest.raises(FormatError) as raised:
        damaged()
    assert str(raised.value) == f"{tmp_path / 'a.exr'} is damaged: bake it again"
    (tmp_path / "file").touch()
    with (
        pytest.raises(BakeError, match=r"a\.json could not be written: .*; free its disk"),
        replacing_together(tmp_path / "file" / "a.json"),
    ):
        pass


def test_a_killed_process_leaves_nothing_under_the_final_name(tmp_path: Path) -> None:
    target = tmp_path / "a.exr"
    script = (
        "import os, pathlib, sys; from radtex_addon.formats.disk.atomic import replacing\n"
        "with replacing(pathlib.Path(sys.argv[1])) as beside: beside.write_text('half'); os._exit(9)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script, str(target)], cwd=Path(__file__).parents[2], check=False
    )
    assert done.returncode == 9
    assert not target.exists()
    assert [path.name[:8] for path in tmp_path.iterdir()] == [".radtex-"]


def test_two_writers_do_not_meet(tmp_path: Path) -> None:
    target = tmp_path / "a.txt"
    with replacing(target) as one, replacing(target) as other:
        assert one != other
        one.write_text("one")
        other.write_text("other")
    assert target.read_text() == "one"


def test_the_systems_refusal_is_a_bake_error_that_names_the_file(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(BakeError, match=r"a\.json could not be written"):
        write_text(tmp_path / "file" / "a.json", "x")
    with pytest.raises(BakeError, match=r"a\.json could not be written"), replacing(tmp_path / "a.json"):
        pass  # nothing was written, so there is nothing to rename


def test_a_folder_that_can_be_made_is_writable_and_is_not_made(tmp_path: Path) -> None:
    check_writable(tmp_path)
    check_writable(tmp_path / "not" / "yet")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written_is_the_users_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for folder in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(InputError, match="file is a file; choose another folder"):
            check_writable(folder)
    with pytest.raises(InputError, match="choose another folder"):
        check_writable(tmp_path / ("x" * 5000))


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write anywhere")
def test_a_read_only_folder_is_the_users_error(tmp_path: Path) -> None:
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match="Permission denied; choose another folder"):
        check_writable(tmp_path / "below")


def test_a_file_already_there_is_kept_unless_asked(tmp_path: Path) -> None:
    old = tmp_path / "a.exr"
    check_absent([old], overwrite=False)
    old.write_text("old")
    with pytest.raises(InputError, match=r"a\.exr is already there: overwrite it"):
        check_absent([tmp_path / "b.exr", old], overwrite=False)
    check_absent([old], overwrite=True)
    with pytest.raises(InputError, match="is a folder"):
        check_absent([tmp_path], overwrite=True)
