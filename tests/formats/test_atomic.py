# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files appear whole or not at all, and nothing of the user's is destroyed unasked."""

from __future__ import annotations

import os
import stat
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


def contents(folder: Path) -> dict[str, str]:
    return {path.name: path.read_text() for path in folder.iterdir()}


def test_files_appear_only_when_they_are_whole(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "folder"
    with replacing(folder / "a.exr") as beside:
        assert beside.parent == folder
        assert beside.suffix == ".exr"
        beside.write_text("whole")
        assert not (folder / "a.exr").exists()
    assert contents(folder) == {"a.exr": "whole"}
    with replacing_together(folder / "a.json") as beside:
        assert beside.parent.parent == folder
        for name in ("a.json", "a.exr", "z.exr"):
            beside.with_name(name).write_text("new")
        assert sorted(path.is_dir() for path in folder.iterdir()) == [False, True]
    assert contents(folder) == {"a.json": "new", "a.exr": "new", "z.exr": "new"}


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt, SystemExit, GeneratorExit])
@pytest.mark.parametrize("writing", [replacing, replacing_together])
def test_after_any_interruption_the_folder_is_what_it_was(
    tmp_path: Path, error: type[BaseException], writing: Any
) -> None:
    target = tmp_path / "a.json"
    target.write_text("old")

    def interrupted() -> None:
        with writing(target) as beside:
            beside.write_text("half")
            if writing is replacing_together:
                beside.with_name("a.exr").write_text("new")
            raise error

    with pytest.raises(error):
        interrupted()
    assert contents(tmp_path) == {"a.json": "old"}


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
    refused = r"a\.json could not be written: .*; free its disk"
    with pytest.raises(BakeError, match=refused), replacing_together(tmp_path / "file" / "a.json"):
        pass
    with pytest.raises(BakeError, match=refused):
        write_text(tmp_path / "file" / "a.json", "x")
    with pytest.raises(BakeError, match=refused), replacing(tmp_path / "a.json"):
        pass  # nothing was written, so there is nothing to rename


def test_two_writers_do_not_meet(tmp_path: Path) -> None:
    target = tmp_path / "a.txt"
    with replacing(target) as one, replacing(target) as other:
        assert one != other
        one.write_text("one")
        other.write_text("other")
    assert target.read_text() == "one"


def test_a_folder_that_can_be_made_is_writable_and_another_is_the_users_error(tmp_path: Path) -> None:
    check_writable(tmp_path)
    check_writable(tmp_path / "not" / "yet")
    assert list(tmp_path.iterdir()) == []  # none is made
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
