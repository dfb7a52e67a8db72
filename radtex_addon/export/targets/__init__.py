# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What each target's folder holds besides the mesh, the textures and the manifest, which all have.

A target's module has the name of its row in `settings.targets.TARGETS`, and defines WRITER:
docs/extending.md.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from ...settings.targets import Target
from ..pack import Pack, ScenePack


@dataclass(frozen=True)
class Writer:
    """How a target's files are added to a pack's folder: `write`, and `write_scene` to a whole scene's.

    `write_scene` is None for a target that takes one bake a folder. `check` is called before all work, even
    before a bake; it raises InputError if this copy of RadTex lacks something.
    """

    write: Callable[[Pack, Path], None]
    write_scene: Callable[[ScenePack, Path], None] | None = None
    check: Callable[[], None] = lambda: None


def writer_of(target: Target) -> Writer:
    """The target's writer."""
    writer: Writer = import_module(f"{__name__}.{target}").WRITER
    return writer
