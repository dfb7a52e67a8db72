# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs `bake.py` and ends it by SIGKILL at one change of a name: `kill_at.py FOLDER LOG NUMBER WHEN WORDS…`.

Files and folders below FOLDER that are renamed or removed, and folders that are made, are counted from 1 on
and told to LOG, a line each. The process dies just `before` or just `after` change NUMBER; with 0 it lives.
What C++ does by itself is not seen.
"""

from __future__ import annotations

import os
import runpy
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

_WATCHED = {"os.rename": 2, "os.remove": 1, "os.rmdir": 1, "os.mkdir": 1}  # and how many names they have
_CALLS = ("rename", "replace", "remove", "unlink", "rmdir", "mkdir")


class Killer:
    """Counts changes of names below `folder`; at the chosen one the process dies."""

    def __init__(self, folder: str, log: str, number: int, when: str) -> None:
        self.folder, self.number, self.when = str(Path(folder).resolve()), number, when
        self.log = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
        self.count, self.due = 0, False

    def hear(self, event: str, arguments: tuple[Any, ...]) -> None:
        """An audit hook: is told before anything is done."""
        if event not in _WATCHED:
            return
        names, places = arguments[: _WATCHED[event]], arguments[-_WATCHED[event] :]
        paths = [self._path(name, place) for name, place in zip(names, places, strict=True)]
        is_new = event == "os.mkdir"
        if not paths[0].startswith(self.folder + os.sep) or Path(paths[0]).exists() is is_new:
            return  # it is elsewhere, or will fail
        self.count += 1
        told = " -> ".join(path.removeprefix(self.folder + os.sep) for path in paths)
        os.write(self.log, f"{self.count} {event} {told}\n".encode())
        if self.count == self.number:
            if self.when == "before":
                os.kill(os.getpid(), signal.SIGKILL)
            self.due = True

    def _path(self, name: Any, descriptor: Any) -> str:
        folder = Path.cwd()
        if isinstance(descriptor, int) and descriptor >= 0:
            folder = Path(f"/proc/self/fd/{descriptor}").readlink()
        return str(folder / os.fsdecode(name))

    def dying_after(self, call: Callable[..., None]) -> Callable[..., None]:
        """The same function of `os`, after which the process dies if it was the chosen change."""

        def watched(*arguments: Any, **options: Any) -> None:
            call(*arguments, **options)
            if self.due:
                os.kill(os.getpid(), signal.SIGKILL)

        return watched


def main() -> None:
    folder, log, number, when, *words = sys.argv[1:]
    killer = Killer(folder, log, int(number), when)
    for name in _CALLS:
        setattr(os, name, killer.dying_after(getattr(os, name)))
    sys.addaudithook(killer.hear)
    sys.argv = [str(Path(__file__).resolve().parents[2] / "bake.py"), *words]
    sys.path[0] = str(Path(sys.argv[0]).parent)
    runpy.run_path(sys.argv[0], run_name="__main__")


if __name__ == "__main__":
    main()
