# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes that many tests read: each made once for a run of the tests, and copied to whoever asks again.

A test of what a bake does bakes. One of what comes after it, an export, a preview, a report, a lookup, takes
a finished bake from here.
"""

from __future__ import annotations

import hashlib
import inspect
import os
import shutil
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Concatenate, ParamSpec

import bpy

from tests.blender import surroundings

ROOT = Path(__file__).resolve().parent.parent
STORE = "RADTEX_TEST_BAKES"  # the folder that tests/run.py makes for a run, and conftest.py elsewhere

P = ParamSpec("P")


def finished_bake(
    folder: Path, make: Callable[Concatenate[Path, P], object], *args: P.args, **kwargs: P.kwargs
) -> Path:
    """`folder` with what `make(folder, …)` writes into it; not yet there, or empty.

    `make` is a module's function, and makes the scene by itself, as it would in a new Blender. It is called
    once for the same arguments, which are told apart by their repr, for the same text of its module, the same
    code of RadTex, the same sizes of surroundings, and the same Blender.
    """
    asked = f"{make.__module__}.{make.__qualname__}{args!r}{sorted(kwargs.items())!r}{surroundings.sizes()}"
    module = sys.modules[make.__module__]
    digest = hashlib.sha256("\0".join((asked, inspect.getsource(module), _code())).encode()).hexdigest()
    store = Path(os.environ[STORE])
    stored = store / digest
    if not stored.is_dir():
        with tempfile.TemporaryDirectory(dir=store) as beside:
            made = Path(beside, "made")
            made.mkdir()
            make(made, *args, **kwargs)
            try:
                made.rename(stored)
            except OSError:  # another process was faster, and the folder is not empty
                if not stored.is_dir():
                    raise
    shutil.copytree(stored, folder, dirs_exist_ok=True)
    return folder


@cache
def _code() -> str:
    """What bakes: our code, the shaders, the means of tests, and Blender."""
    digest = hashlib.sha256(f"{bpy.app.version_string} {bpy.app.build_hash!r}".encode())
    files = {path for name in ("radtex_addon", "shaders") for path in (ROOT / name).rglob("*")}
    files |= {path for path in (ROOT / "tests").rglob("*.py") if not path.name.startswith("test_")}
    for path in sorted(files):
        if path.is_file() and "__pycache__" not in path.parts and "node_modules" not in path.parts:
            digest.update(f"{path.relative_to(ROOT)}\0".encode() + path.read_bytes())
    return digest.hexdigest()
