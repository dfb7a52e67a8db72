# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which bake an object is shown by, and which objects and bakes stand against each other."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import bpy

from ..bake.spec import Kind
from ..formats.sidecar import file_name
from ..preview.swap import is_on
from .finished import find_bake, find_bakes


def shown_bake(place: Path, name: str) -> Path:
    """The sidecar of a bake of the object `name`, of any kind: `place` itself, or in that folder.

    Raises InputError where there is none, FormatError for a file that is no sidecar.
    """
    if not place.is_dir():
        return find_bake(place, None, "shown") if not place.exists() else place
    for kind in Kind:
        sidecar = place / file_name(name, kind, "json")
        if sidecar.is_file():
            return sidecar
    return find_bakes(place, name, "shown", tuple(Kind))[0]  # what shows one part shows all that there are


def bakes_of(items: Iterable[bpy.types.Object], place: Path) -> dict[bpy.types.Object, Path | None]:
    """What `compare_steps` takes: a sidecar for each object, None for those whose preview is on.

    Raises as `shown_bake` does.
    """
    return {item: None if is_on(item) else shown_bake(place, item.name) for item in items}
