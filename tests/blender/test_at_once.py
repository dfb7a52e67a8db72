# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Two processes that bake the same at once: what one has made, the other does not replace unasked."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.blender.batch_process import BAKE, Batch
from tests.blender.killed import digests
from tests.blender.room import fill_room, save_room

pytestmark = [
    pytest.mark.one_blender,
    pytest.mark.skipif(sys.platform == "win32", reason="Windows stops no process for a while"),
]

QUICK = ("--object=Ball", "--layout=buckets", "--texels=16", "--bucket=4", "--samples=1", "--progress=json")
UNFINISHED = "Ball.radiance.radtex-unfinished"


@pytest.fixture(scope="module")
def room(tmp_path_factory: pytest.TempPathFactory) -> Path:
    fill_room()
    return save_room(tmp_path_factory.mktemp("room") / "room.blend")


def stopped(room: Path, out: Path, *more: str) -> subprocess.Popen[str]:
    """A bake that stands still: it has looked for what is in its way, and has kept nothing yet."""
    for _ in range(5):
        command = [sys.executable, BAKE, str(room), *QUICK, f"--out={out}", *more]
        begun = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert begun.stdout is not None
        assert '"progress"' in begun.stdout.readline()
        os.kill(begun.pid, signal.SIGSTOP)
        if not (out / UNFINISHED).exists():
            return begun
        begun.kill()  # too late: it was quick
        begun.communicate()
        for path in sorted((out / UNFINISHED).iterdir()):
            path.unlink()
        (out / UNFINISHED).rmdir()
    raise AssertionError("it never stands still in time")


def kept(out: Path) -> list[str]:
    """What is finished: all in the folder but the lock."""
    return sorted(path.name for path in (out / UNFINISHED).iterdir() if path.name != "lock")


def ended(begun: subprocess.Popen[str]) -> tuple[int, str]:
    os.kill(begun.pid, signal.SIGCONT)
    _, said = begun.communicate(timeout=120)
    return begun.returncode, said


def test_who_comes_second_replaces_nothing(room: Path, out: Path, batch: Batch) -> None:
    second = stopped(room, out)
    first = batch(room, *QUICK, f"--out={out}")
    assert (first.code, first.err) == (0, "")
    before = digests(out)
    code, said = ended(second)
    assert code == 2, said
    assert "Ball.radiance.exr is already there: overwrite it (--overwrite)" in said
    assert said.count("\n") == 1
    assert digests(out) == before
    assert not (out / UNFINISHED).exists()


def test_what_a_killed_one_has_finished_meanwhile_is_kept(room: Path, out: Path, batch: Batch) -> None:
    second = stopped(room, out)
    first = stopped(room, out)
    os.kill(first.pid, signal.SIGCONT)
    while not (out / UNFINISHED / "key.json").exists():
        assert first.poll() is None
    first.kill()
    first.communicate()
    pieces = kept(out)
    code, said = ended(second)
    assert code == 2, said
    assert f"{out / UNFINISHED} holds an unfinished bake: go on with it (--resume)" in said
    assert kept(out) == pieces
    resumed = batch(room, *QUICK, f"--out={out}", "--resume")
    assert (resumed.code, resumed.err) == (0, "")


def test_more_samples_that_another_added_meanwhile_are_not_lost(room: Path, out: Path, batch: Batch) -> None:
    assert batch(room, *QUICK, f"--out={out}").code == 0
    second = stopped(room, out, "--accumulate", "--seed=2")
    first = batch(room, *QUICK, f"--out={out}", "--accumulate", "--seed=1")
    assert (first.code, first.err) == (0, "")
    before = digests(out)
    code, said = ended(second)
    assert code == 2, said
    assert "Ball.radiance.exr has changed since this bake began: start it again" in said
    assert digests(out) == before


def test_who_may_overwrite_does(room: Path, out: Path, batch: Batch) -> None:
    second = stopped(room, out, "--overwrite", "--samples=2")
    assert batch(room, *QUICK, f"--out={out}").code == 0
    assert ended(second)[0] == 0
    assert '"samples": 2' in (out / "Ball.radiance.json").read_text()
