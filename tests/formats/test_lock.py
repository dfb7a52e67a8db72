# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Locks end with their process; hidden folders and those for temporary files go away with it or the next."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from radtex_addon.core.errors import BakeError, InputError
from radtex_addon.formats.disk.lock import HeldError, NoLockError, holder, take_lock
from radtex_addon.formats.disk.temporary import PREFIX, hidden_folder, temporary_folder
from radtex_addon.store.checkpoint import Checkpoint, check_free
from radtex_addon.store.checkpoint_files import LOCK

_ROOT = Path(__file__).parents[2]
_HOLD = (
    "import pathlib, sys, time; from radtex_addon.formats.disk.lock import take_lock\n"
    "lock = take_lock(pathlib.Path(sys.argv[1])); print('held', flush=True); time.sleep(60)"
)
_WORK = (
    "import sys, tempfile, time; from radtex_addon.formats.disk.temporary import temporary_folder\n"
    "tempfile.tempdir = sys.argv[1]\n"
    "with temporary_folder() as folder:\n"
    "    (folder / 'large.exr').write_text('half'); print(folder, flush=True); time.sleep(60)"
)


@contextmanager
def running(script: str, path: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """A process, and the first line that it says; killed at exit."""
    command = [sys.executable, "-c", script, str(path)]
    with subprocess.Popen(command, cwd=_ROOT, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        try:
            yield process, process.stdout.readline().strip()
        finally:
            process.kill()


@pytest.fixture
def temporary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def test_a_lock_is_one_processs_and_ends_with_it(tmp_path: Path) -> None:
    path = tmp_path / "lock"
    with running(_HOLD, path) as (process, _):
        assert (holder(path) or "").startswith(f"process {process.pid} on ")
        with pytest.raises(HeldError, match=f"^process {process.pid} on "):
            take_lock(path)
    assert process.returncode == (1 if sys.platform == "win32" else -signal.SIGKILL)
    assert path.exists()
    assert holder(path) is None
    lock = take_lock(path)
    assert lock.is_sure
    assert (holder(path) or "").startswith(f"process {os.getpid()} on ")
    lock.release()
    assert list(tmp_path.iterdir()) == []
    assert holder(path) is None


def test_a_lock_that_nobody_refers_to_is_free(tmp_path: Path) -> None:
    take_lock(tmp_path / "lock")
    assert list(tmp_path.iterdir()) == []
    take_lock(tmp_path / "lock").release()


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such files")
@pytest.mark.parametrize("kind", ["link", "dangling link", "hard link", "file", "pipe", "folder", "device"])
def test_nothing_but_a_lock_is_written_or_removed(kind: str, tmp_path: Path) -> None:
    theirs, path = tmp_path / "theirs", tmp_path / "lock"
    theirs.write_text("a novel")
    if kind == "link":
        path.symlink_to(theirs)
    elif kind == "dangling link":
        path.symlink_to(tmp_path / "new")
    elif kind == "hard link":
        path.hardlink_to(theirs)
    elif kind == "file":
        path.write_text("another novel")
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "folder":
        path.mkdir()
    else:
        path.symlink_to("/dev/null")
    before = path.lstat()
    with pytest.raises(
        NoLockError, match=r"lock is (a link|no file|somebody's file), where RadTex keeps a lock"
    ):
        take_lock(path)
    if kind != "file":  # whose lock nobody has
        with pytest.raises(NoLockError):
            holder(path)
    assert theirs.read_text() == "a novel"
    assert os.path.samestat(path.lstat(), before)
    assert path.lstat().st_size == before.st_size
    assert {one.name for one in tmp_path.iterdir()} == {"theirs", "lock"}


@pytest.mark.parametrize("left", [b"", b"proc", bytes(23), b"process 7 on tow\0\0\0"])
def test_what_a_kill_or_a_power_cut_left_of_a_lock_is_taken(left: bytes, tmp_path: Path) -> None:
    path = tmp_path / "lock"
    path.write_bytes(left)
    lock = take_lock(path)
    assert path.read_text().startswith(f"process {os.getpid()} on ")
    lock.release()


@pytest.mark.skipif(sys.platform == "win32", reason="links need rights there")
def test_a_bake_with_a_link_in_the_place_of_its_lock_is_refused(tmp_path: Path) -> None:
    theirs, folder = tmp_path / "theirs", tmp_path / "bake.radtex-unfinished"
    theirs.write_text("a novel")
    folder.mkdir()
    (folder / LOCK).symlink_to(theirs)
    with pytest.raises(InputError, match=rf"{LOCK} is a link, where RadTex keeps a lock: remove it"):
        check_free(folder)
    kept = Checkpoint(folder, resume=False)
    with pytest.raises(InputError, match="is a link"):
        kept.keep("tile", {})
    assert theirs.read_text() == "a novel"


def test_what_a_killed_process_left_goes_with_the_next_folder(temporary: Path) -> None:
    (temporary / f"{PREFIX}mine").write_text("no folder")
    with running(_WORK, temporary) as (_, left):
        assert Path(left, "large.exr").exists()
        with temporary_folder() as own:
            assert Path(left, "large.exr").exists(), "that process lives"
        assert not own.exists()
    assert Path(left).exists()
    Path(f"{left}2").mkdir()  # killed before its folder was locked
    with temporary_folder() as own, temporary_folder() as other:
        names = {path.name for path in temporary.iterdir()}
        assert names == {own.name, other.name, f"{PREFIX}mine"}
    assert [path.name for path in temporary.iterdir()] == [f"{PREFIX}mine"]


def test_a_link_to_a_folder_is_not_followed(temporary: Path) -> None:
    (temporary / "user").mkdir()
    (temporary / f"{PREFIX}link").symlink_to(temporary / "user")
    with temporary_folder():
        pass
    assert list((temporary / "user").iterdir()) == []


def test_a_place_that_takes_nothing_is_named(temporary: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(temporary / "gone"))
    with (
        pytest.raises(BakeError, match=r"gone takes no temporary files: No such .*TMPDIR"),
        temporary_folder(),
    ):
        pass


def in_a_process(folder: Path, then: str) -> subprocess.Popen[str]:
    """One that has a hidden folder in `folder`, says so, and does something."""
    script = (
        "import os, pathlib, sys; from radtex_addon.formats.disk.temporary import hidden_folder\n"
        "with hidden_folder(pathlib.Path(sys.argv[1])) as made:\n"
        "    (made / 'half').write_text('half'); made.with_suffix('.new').mkdir()\n"
        f"    print('there', flush=True); {then}"
    )
    command = [sys.executable, "-c", script, str(folder)]
    return subprocess.Popen(command, cwd=_ROOT, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def test_a_folder_goes_away_with_all_that_is_in_it(tmp_path: Path) -> None:
    with hidden_folder(tmp_path / "new") as made:
        assert made.parent == tmp_path / "new"
        assert made.name.startswith(".radtex-")
        (made / "below").mkdir()
        made.with_suffix(".new").mkdir()
    assert list((tmp_path / "new").iterdir()) == []

    def fail() -> None:
        with hidden_folder(tmp_path / "new"):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fail()
    assert list((tmp_path / "new").iterdir()) == []


def test_the_next_one_removes_what_a_kill_left_and_nothing_else(tmp_path: Path) -> None:
    killed = in_a_process(tmp_path, "os._exit(9)")
    killed.communicate()
    left, other = sorted(tmp_path.iterdir())
    assert (left.suffix, other.suffix) == (".folder", ".new")
    mine = tmp_path / ".radtex-mine.folder"
    mine.symlink_to(tmp_path / "elsewhere", target_is_directory=True)
    (tmp_path / "elsewhere").mkdir()
    living = in_a_process(tmp_path, "sys.stdin.read()")
    assert living.stdout is not None
    assert living.stdout.readline() == "there\n"
    assert not left.exists()
    assert not other.exists()
    (theirs,) = {path for path in tmp_path.iterdir() if path.name.endswith(".folder")} - {mine}
    with hidden_folder(tmp_path) as own:
        assert (theirs / "half").is_file(), "whoever works in it is alive"
        assert own != theirs
    living.communicate()
    assert {path.name for path in tmp_path.iterdir()} == {mine.name, "elsewhere"}
