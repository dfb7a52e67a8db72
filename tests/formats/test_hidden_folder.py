# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hidden folders go away: their own at its end, those of killed processes with the next."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from radtex_addon.formats.disk.hidden_folder import hidden_folder

_ROOT = Path(__file__).parents[2]


def in_a_process(folder: Path, then: str) -> subprocess.Popen[str]:
    """One that has a hidden folder in `folder`, says so, and does something."""
    script = (
        "import os, pathlib, sys; from radtex_addon.formats.disk.hidden_folder import hidden_folder\n"
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
