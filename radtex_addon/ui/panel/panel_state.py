# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cache of what the panel shows about the next bake: errors, warnings, cost. Computed outside of drawing.

Handlers only mark the cache stale; a timer recomputes it once nothing has changed for a moment.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import bpy
from bpy.app.handlers import persistent

from .redraw import redraw

if TYPE_CHECKING:
    from ...core.messages import Message
    from ...job.left_out import LeftOut
    from ...report.finished_bake import NamedBake
    from ...settings.cost import Cost
    from ...settings.estimate import Basis
    from ...settings.spec import BakeSpec
    from ...settings.time_left import Left
    from .not_baked import NotBaked

_QUIET = 0.3  # seconds without a change before recomputing, so that dragging stays fluid


class Next(StrEnum):
    """What the panel's large button does."""

    BAKE = "bake"
    REPLACE = "replace"  # finished or unfinished bakes
    RESUME = "resume"  # unfinished bakes, or make those that are missing; replacing all is offered beside it
    WAIT = "wait"  # all chosen objects are in the list of jobs
    NOTHING = "nothing"  # errors, or no object


class ShownAsset(NamedTuple):
    """An asset that is baked as one: its name, how many objects it has, and the texels along a side."""

    name: str
    objects: int
    texels: int


class ShownCopy(NamedTuple):
    """A chosen copy that shows a bake: its name, and that of its original.

    `has_original` tells whether the original is in the scene, `bake` whether a bake is there to update the
    copy from: "newer", "same", or "" if there is none.
    """

    name: str
    original: str
    has_original: bool
    bake: str


class Made(NamedTuple):
    """An atlas that the bake makes: its name in files, texels a side, most bytes of all images, and folder.

    The bytes are those of all frames, lamps and parts that are baked of it.
    """

    name: str
    texels: int
    disk: int
    folder: Path


@dataclass(frozen=True)
class Forecast:
    """What to expect of a bake of the chosen objects, and the most that any of them costs.

    `errors` are those that replacing or resuming bakes do not settle. `spec` and `cost` are None if the
    settings are invalid. `seconds` is the time of all objects, `range` what it is at least and at most, and
    `basis` what this estimate rests on; all None if it is not known, as of split atlases. `folder` is None if
    there is no output folder, and `needs_folder` tells whether one must be chosen. `bakes` are all that were
    asked for, `finished` and `unfinished` those of them that are there, `done` the finished ones that have
    these settings. `busy` are the objects that are being baked; the other fields are of the others. `shown`
    are the objects whose bake is shown in their place, `own` those that have settings of their own, `flat`
    those that cannot be baked since their scale is 0 along an axis. `layout` describes the automatically
    chosen layout and the reason; empty if the user chose the layout. `assets` are objects that touch and
    share an atlas; all objects have so many `atlases`, without counting parts and variants. `made` are these
    atlases, but for so many that were `unseen` for lack of time. `sizes` are lines on the size of each atlas,
    if that follows from a texel density. `not_baked` names selected objects that are no meshes, `left_out`
    meshes that cannot be baked where others can. `copies` are the chosen objects where all of them are
    copies that show a bake; then there is nothing to bake. `named` are the bakes of the active object, the
    newest first, if any has a name of its own; `named_of` are that object and the atlas, or again the object,
    that they are of.
    """

    objects: tuple[str, ...]
    errors: tuple[Message, ...] = ()
    warnings: tuple[Message, ...] = ()
    spec: BakeSpec | None = None
    cost: Cost | None = None
    seconds: float | None = None
    range: Left | None = None
    basis: Basis | None = None
    folder: Path | None = None
    next: Next = Next.NOTHING
    needs_folder: bool = False
    bakes: int = 0
    finished: int = 0
    unfinished: int = 0
    done: int = 0
    former: int = 0  # bakes that are unfinished where an earlier finished one is still there
    busy: tuple[str, ...] = ()
    shown: tuple[str, ...] = ()
    own: tuple[str, ...] = ()
    flat: tuple[str, ...] = ()
    not_baked: tuple[NotBaked, ...] = ()
    left_out: tuple[LeftOut, ...] = ()
    layout: str = ""
    sizes: tuple[str, ...] = ()
    assets: tuple[ShownAsset, ...] = ()
    atlases: int = 1
    copies: tuple[ShownCopy, ...] = ()
    made: tuple[Made, ...] = ()
    unseen: int = 0
    named: tuple[NamedBake, ...] = ()
    named_of: tuple[str, str] = ("", "")

    @property
    def chosen(self) -> tuple[str, ...]:
        """All that were chosen: the objects, and those that are left out."""
        return (*self.objects, *(one.name for one in self.left_out))


Compute: TypeAlias = Callable[[bpy.types.Scene, bpy.types.ViewLayer], Forecast]


@dataclass
class _Cache:
    compute: Compute | None  # set while the add-on is registered
    found: dict[tuple[int, str], Forecast]
    changed: float = 0.0
    looking: bool = False  # ignore the depsgraph updates that our own evaluation causes


_cache = _Cache(None, {})


def cached_forecast(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Forecast | None:
    """The cached forecast; None if the timer has not computed it yet."""
    return _cache.found.get(_key(scene, view_layer))


def refresh(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Forecast:
    """Compute the forecast and cache it; the add-on must be registered."""
    assert _cache.compute is not None
    _cache.looking = True
    try:
        found = _cache.found[_key(scene, view_layer)] = _cache.compute(scene, view_layer)
    finally:
        _cache.looking = False
    return found


@persistent  # type: ignore[untyped-decorator]  # untyped in the stubs
def mark_stale(_: object = None, depsgraph: object = None) -> None:
    """Handler: recompute the cache soon. Accepts the arguments of any handler.

    Updates of the depsgraph in which nothing has changed are ignored: redrawing the panel causes such.
    """
    nothing = isinstance(depsgraph, bpy.types.Depsgraph) and not depsgraph.updates
    if _cache.looking or nothing:
        return
    _cache.changed = monotonic()
    if not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=_QUIET, persistent=True)


def register(compute: Compute) -> None:
    """Add the handlers that mark the cache stale, and fill it by `compute` from now on."""
    _cache.compute = compute
    for handlers in _lists():
        handlers.append(mark_stale)
    mark_stale()


def unregister() -> None:
    """Remove the handlers and clear the cache."""
    for handlers in _lists():
        if mark_stale in handlers:  # other add-ons may have cleared the list
            handlers.remove(mark_stale)
    if bpy.app.timers.is_registered(_tick):
        bpy.app.timers.unregister(_tick)
    _cache.found.clear()
    _cache.compute = None


def _tick() -> float | None:
    rest = _cache.changed + _QUIET - monotonic()
    if rest > 0:
        return rest
    _cache.found.clear()
    manager = bpy.context.window_manager
    for window in manager.windows if manager is not None else ():
        refresh(window.scene, window.view_layer)
    redraw()
    return None


def _lists() -> tuple[list[object], ...]:
    events = bpy.app.handlers
    return (  # type: ignore[return-value]  # the stubs give each list another type
        events.depsgraph_update_post,
        events.undo_post,
        events.redo_post,
        events.load_post,
        events.save_post,
    )


def _key(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> tuple[int, str]:
    return scene.session_uid, view_layer.name
