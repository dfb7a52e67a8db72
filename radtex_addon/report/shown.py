# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the bakes to show or to compare for objects, and the frame to compare them at."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

import bpy

from ..core.errors import InputError, RadTexError
from ..formats.sidecar import called_in, file_name
from ..formats.sidecar_file import AnySidecar, SidecarFile
from ..preview.swap import copy_of, is_on
from ..preview.variant import Variant, kept_variant, read_variant
from ..settings.kinds import KINDS, Kind
from ..settings.options import MARKED
from ..store.ownership import is_of_blend
from .finished_bake import find_bake, find_bakes, is_bake_of, named_bakes

_UNSEEN = [kind for kind, traits in KINDS.items() if not traits.judged]


def shown_bake(place: Path, name: str, called: str = "") -> SidecarFile:
    """The sidecar of a bake of the object `name`, of any kind: `place` itself, or in that folder.

    `called` is what its files are called, where that is known, and not as the object. Raises InputError where
    there is none, FormatError for a file that is no sidecar.
    """
    if not place.is_dir():
        return find_bake(place, None, "shown") if not place.exists() else SidecarFile.read(place)
    for kind in Kind:
        sidecar = place / file_name(called or name, kind, "json")
        if sidecar.is_file() and _is_of(file := SidecarFile.read(sidecar), name):
            return file
    return find_bakes(place, name, "shown", tuple(Kind), called)[0]  # all parts share one preview


def _is_of(file: SidecarFile, name: str) -> bool:
    """Whether a bake is of the object `name`, and not only called so; one without a name of its own is."""
    return not called_in(file.facts) or is_bake_of(file, name)


def has_bakes(folder: Path, names: Iterable[str], blend: Path) -> bool:
    """Whether a folder has a bake of each of the objects, of any kind, none of another file than `blend`."""
    try:
        found = [_newest(folder, name) for name in names] if folder.is_dir() else [None]
    except RadTexError:
        return False
    return all(sidecar is not None and is_of_blend(sidecar, blend) for sidecar in found)


def _newest(folder: Path, name: str) -> Path | None:
    """The sidecar of a bake of the object, of several names the newest. Raises as `shown_bake` does."""
    found = named_bakes(folder, name)
    if not found:
        return None
    return shown_bake(folder, name, found[0].called if len(found) > 1 else "").path


def bakes_of(items: Iterable[bpy.types.Object], place: Path) -> dict[bpy.types.Object, SidecarFile | None]:
    """The `bakes` that `compare_steps` takes: a sidecar for each object, None if its preview is on.

    Raises as `shown_bake` does.
    """
    return {item: None if is_on(item) else shown_bake(place, item.name) for item in items}


def frame_of(scene: bpy.types.Scene, bakes: Mapping[bpy.types.Object, AnySidecar | None]) -> int | None:
    """The frame at which to compare `bakes`, as `bakes_of` returns them; None for the scene's current frame.

    Raises InputError if they are of different frames, of some lamps or without other objects (the scene
    renders with all), or of light that no camera sees; FormatError for a file that is no sidecar.
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
    """Raise InputError for light that cannot be compared with a render of the whole scene."""
    if variant.kind in _UNSEEN:
        raise InputError(
            f"{what} holds {variant.kind} light, which no camera sees: compare a bake of radiance"
        )
    if variant.lights:
        lit = ", ".join(f"'{name}'" for name in variant.lights)
        raise InputError(f"{what} has the light of {lit} alone: compare a bake of the whole scene's light")
    for name in variant.marks:
        if MARKED[name].unlike:
            raise InputError(f"{what} {MARKED[name].unlike}")


def _variant(item: bpy.types.Object, sidecar: AnySidecar | None) -> Variant:
    if sidecar is not None:
        return read_variant(sidecar)
    copy = copy_of(item)
    return Variant() if copy is None else kept_variant(copy)


def _frame(number: int | None) -> str:
    return "none of its own" if number is None else f"frame {number}"
