# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Find out whether what a bake shows has changed since, and what of it."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import bpy

from ..core.errors import FormatError
from ..formats.fingerprint import VERSION, fingerprint_in
from ..formats.json_reader import Facts
from ..formats.sidecar_file import read_facts
from ..scene.digests import SceneDigests
from ..scene.scratch import find_view_layer
from ..settings.spec import BakeSpec
from ..store.bake_folder import BakeFolder, FolderState
from .bake_fingerprint import read_now

MOVED = "moved"
SURROUNDINGS = "surroundings"
_WORDS = {"transform": MOVED}  # parts of a fingerprint that have another name here


class BakeState(StrEnum):
    """How a bake on disk compares with the scene; all but UNCHANGED ask for a bake."""

    MISSING = "not baked yet"
    UNFINISHED = "unfinished"
    UNCHANGED = "unchanged"
    CHANGED = "changed"
    UNKNOWN = "unknown"


@dataclass(frozen=True)
class Changes:
    """The `state` of a bake, and if it is changed what `parts` of it are.

    Parts are some of `mesh`, `moved`, `materials`, `settings` and `surroundings`, in this order. If the state
    is unknown, `reason` says why, in a clause.
    """

    state: BakeState
    parts: tuple[str, ...] = ()
    reason: str = ""

    @property
    def asks_for_bake(self) -> bool:
        """Whether it has to be baked, for the first time or again."""
        return self.state is not BakeState.UNCHANGED

    def __str__(self) -> str:
        """The state in words, such as "moved, mesh and materials changed"."""
        if self.state is BakeState.UNKNOWN:
            return f"may have changed: {self.reason}"
        if self.state is not BakeState.CHANGED:
            return str(self.state)
        *most, last = [part for part in self.parts if part != MOVED] or [""]
        named = f"{', '.join(most)} and {last}" if most else last
        moved = [MOVED] if MOVED in self.parts else []
        return ", ".join([*moved, f"{named} changed"] if last else moved)


class SceneReader:
    """Digests a scene when they are first needed, once for each frame; make a new one when it has changed."""

    def __init__(self, scene: bpy.types.Scene, view_layer: str | None = None) -> None:
        self._scene, self._view_layer = scene, view_layer
        self._known: dict[int | None, SceneDigests] = {}

    def at(self, frame: int | None) -> SceneDigests:
        """Digests at a frame, or at the scene's own. Raises InputError as `read_now` does."""
        if frame not in self._known:
            self._known[frame] = read_now(self._scene, frame, self._view_layer)
        return self._known[frame]


def changes(
    scene: bpy.types.Scene,
    name: str,
    spec: BakeSpec,
    folder: Path,
    view_layer: str | None = None,
    *,
    surroundings: bool = True,
    reader: SceneReader | None = None,
) -> Changes:
    """What has changed of the scene since the bake called `name` into `folder`, which `spec` asks for again.

    `name`, `spec` and `view_layer` are as in `bake_steps`; the layout has been chosen. Without
    `surroundings`, neighbours, lamps and the world do not count, except for what a hull shows. Checks of
    several bakes share a `reader`, so that the scene is evaluated once; it is not evaluated where no bake is
    found. Nothing is changed. Raises InputError for an object or a lamp that no
    longer renders.
    """
    place = BakeFolder(name, spec, folder)
    files, there = place.files, place.state
    if there is not FolderState.FINISHED:
        return Changes(BakeState.UNFINISHED if there is FolderState.UNFINISHED else BakeState.MISSING)
    try:
        facts = read_facts(files.sidecar)
        stored = fingerprint_in(facts)
    except FormatError:
        return Changes(BakeState.UNKNOWN, reason=f"{files.sidecar.name} cannot be read")
    if stored is None or stored.version != VERSION:
        return Changes(BakeState.UNKNOWN, reason="it was baked by a RadTex that did not note what it is of")
    now = (reader or SceneReader(scene, view_layer)).at(spec.frame)
    found = stored.differences(now.of_bake(name, spec, find_view_layer(scene, view_layer)))
    if "settings" not in found and not files.atlas.is_file():
        return Changes(BakeState.MISSING)
    counts = surroundings or spec.kind.traits.content
    parts = tuple(_WORDS.get(part, part) for part in found if counts or part != SURROUNDINGS)
    return _compared(parts, facts)


def _compared(parts: tuple[str, ...], facts: Facts) -> Changes:
    """The changes of a bake with these `facts`, whose `parts` differ."""
    if not parts:
        return Changes(BakeState.UNCHANGED)
    if (other := _other_blender(facts)) and "settings" not in parts:
        return Changes(BakeState.UNKNOWN, reason=f"it was baked by Blender {other}")
    return Changes(BakeState.CHANGED, parts)


def _other_blender(facts: Facts) -> str:
    """The Blender that made a bake, if that may digest the same scene otherwise; else empty."""
    baked = facts.text("blender")
    return "" if baked.split(".")[:2] == bpy.app.version_string.split(".")[:2] else baked
