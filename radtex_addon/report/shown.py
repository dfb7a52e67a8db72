# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which bake an object is shown by, which objects and bakes stand against each other, and at which frame."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

import bpy

from ..bake.kinds import KINDS, Kind
from ..core.errors import InputError
from ..formats.sidecar import file_name
from ..preview.swap import copy_of, is_on
from ..preview.variant import Variant, kept_variant, read_variant
from .finished import find_bake, find_bakes

_UNSEEN = [kind for kind, traits in KINDS.items() if not traits.judged]


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


def frame_of(scene: bpy.types.Scene, bakes: Mapping[bpy.types.Object, Path | None]) -> int | None:
    """The frame at which `bakes`, as `bakes_of` gives them, are seen; None for the one the scene is at.

    Raises InputError where they are of several frames, of some lamps alone, for the scene shows all its
    light, or of light that no camera sees; FormatError for a file that is no sidecar.
    """
    found: dict[int | None, str] = {}
    for item, sidecar in bakes.items():
        variant = _variant(item, sidecar)
        _check_seen(variant, str(sidecar or f"the preview of '{item.name}'"))
        at_current = variant.frame == scene.frame_current and scene.frame_subframe == 0
        found.setdefault(None if at_current else variant.frame, item.name)
    if len(found) > 1:
        (frame, name), (other_frame, other) = [*found.items()][:2]
        raise InputError(
            f"'{name}' is baked at {_frame(frame)} and '{other}' at {_frame(other_frame)}: "
            "compare them one by one"
        )
    return next(iter(found), None)


def _check_seen(variant: Variant, what: str) -> None:
    """Raises InputError for light that a render of the whole scene is no measure of."""
    if variant.kind in _UNSEEN:
        raise InputError(
            f"{what} holds {variant.kind} light, which no camera sees: compare a bake of radiance"
        )
    if variant.lights:
        lit = ", ".join(f"'{name}'" for name in variant.lights)
        raise InputError(f"{what} has the light of {lit} alone: compare a bake of the whole scene's light")


def _variant(item: bpy.types.Object, sidecar: Path | None) -> Variant:
    if sidecar is not None:
        return read_variant(sidecar)
    copy = copy_of(item)
    return Variant() if copy is None else kept_variant(copy)


def _frame(number: int | None) -> str:
    return "none of its own" if number is None else f"frame {number}"
