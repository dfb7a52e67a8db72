# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pythons of their own for a farm: a node that has the bpy module alone, and OpenJD's runner.

Each is made once, in the user's cache, by uv; `python -m tests.real.nodes` makes them without a test.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

if sys.platform != "win32":
    import fcntl

CACHE = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "radtex"
OPENJD = ("openjd-cli==0.8.0",)
BPY = (f"bpy=={version('bpy')}",)  # and what that asks for, numpy among it; nothing of ours
UV = os.environ.get("UV") or shutil.which("uv") or "uv"
_PATIENCE = 600  # seconds: bpy is 350 MB


class NodeUnavailableError(Exception):
    """One line that says why this machine cannot have it."""


def ready_python(requirements: tuple[str, ...]) -> Path:
    """The folder of programs of an environment with these packages alone; made if it is not there.

    Raises NodeUnavailableError where it cannot be made.
    """
    if sys.platform == "win32":
        raise NodeUnavailableError("a farm's node is made on Linux and macOS alone")
    mark = hashlib.sha256(repr((requirements, sys.version_info[:2])).encode()).hexdigest()[:12]
    place = CACHE / f"python-{mark}"
    CACHE.mkdir(parents=True, exist_ok=True)
    with place.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (place / "done").exists():
            shutil.rmtree(place, ignore_errors=True)
            _uv("venv", "--quiet", "--python", sys.executable, str(place))
            _uv("pip", "install", "--quiet", "--python", str(place / "bin/python"), *requirements)
            (place / "done").touch()
    return place / "bin"


def _uv(*arguments: str) -> None:
    try:
        subprocess.run(
            [UV, *arguments], check=True, capture_output=True, text=True, timeout=_PATIENCE, cwd=CACHE
        )
    except (OSError, subprocess.SubprocessError) as error:
        said = getattr(error, "stderr", None) or error
        raise NodeUnavailableError(f"a farm's node cannot be made: {' '.join(str(said).split())}") from error


if __name__ == "__main__":
    for wanted in (OPENJD, BPY):
        print(ready_python(wanted))
