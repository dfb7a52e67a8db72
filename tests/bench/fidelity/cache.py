# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where rendered pictures are kept: below the user's cache folder, by a hash of all that decides them."""

from __future__ import annotations

import ast
import hashlib
import inspect
import os
import sys
from functools import cache
from importlib.util import resolve_name
from pathlib import Path

import bpy

from . import lottery, scenes
from .scenes import SCENES

_PACKAGES = scenes.__name__, lottery.__name__
_SOURCES = {  # as imported, whatever becomes of the files meanwhile
    name: inspect.getsource(module)
    for name, module in sys.modules.items()
    if name.startswith(tuple(f"{package}." for package in _PACKAGES))
}


def picture_path(scene: str, camera: str, rendering: object) -> Path:
    """The file of a scene's picture; `rendering` is how it is rendered, whose repr tells it from others."""
    root = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    facts = f"{scene_key(scene)}\n{bpy.app.version_string}\n{rendering!r}"
    folder = hashlib.sha256(facts.encode()).hexdigest()[:16]
    return root / "radtex" / "fidelity" / folder / f"{scene}-{camera.replace(' ', '-')}.npy"


def scene_key(scene: str) -> str:
    """A hash of the source of a scene's module and of the modules it imports, of the scenes' own."""
    return source_key(SCENES[scene].__module__ if scene in SCENES else lottery.lottery.__module__, _SOURCES)


def source_key(module: str, sources: dict[str, str]) -> str:
    """A hash of the source of a module and of all among `sources` that it imports relatively, or they do."""
    reached: set[str] = set()
    waiting = [module]
    while waiting:
        name = waiting.pop()
        if name in sources and name not in reached:
            reached.add(name)
            waiting += _imported(name, sources[name])
    joined = "\n".join(f"{name}\n{sources[name]}" for name in sorted(reached))
    return hashlib.sha256(joined.encode()).hexdigest()


@cache
def _imported(name: str, source: str) -> list[str]:
    """Modules that a module's source may import by relative imports."""
    package = name.rpartition(".")[0]
    found: list[str] = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = resolve_name("." * node.level + (node.module or ""), package)
            found += [base, *(f"{base}.{alias.name}" for alias in node.names)]
    return found
