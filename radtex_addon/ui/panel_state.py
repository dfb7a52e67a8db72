# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cache of what the panel shows about the next bake: errors, warnings, cost. Computed outside of drawing.

Handlers only mark the cache stale; a timer recomputes it once nothing has changed for a moment.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

import bpy
from bpy.app.handlers import persistent

from .bake_lookup import selected_meshes
from .redraw import redraw

if TYPE_CHECKING:
    from ..bake.cost import Cost
    from ..bake.spec import BakeSpec
    from .settings import BakeSettings

_QUIET = 0.3  # seconds without a change before recomputing, so that dragging stays fluid
_PATIENCE = 0.05  # seconds that examining the objects may take


@dataclass(frozen=True)
class Outlook:
    """What to expect of a bake of the chosen objects: errors, warnings, and the most that any of them costs.

    `spec` and `cost` are None if the settings are invalid. `seconds` is the time of all objects; None if it
    was not estimated, or if objects share or split their atlases. `folder` is None if there is no output
    folder. `remedies` are names of settings that would remove errors if toggled. `baked`: the only errors are
    that bakes already exist. `forgets`: an unfinished bake that could be resumed would be discarded. `shown`
    are the objects whose bake is shown in their place. `layout` describes the automatically chosen layout and
    the reason; empty if the user chose the layout.
    """

    objects: tuple[str, ...]
    errors: tuple[str, ...]
    warnings: tuple[str, ...]
    spec: BakeSpec | None = None
    cost: Cost | None = None
    seconds: float | None = None
    folder: Path | None = None
    remedies: tuple[str, ...] = ()
    baked: bool = False
    forgets: bool = False
    shown: tuple[str, ...] = ()
    layout: str = ""


@dataclass
class _Cache:
    found: dict[tuple[int, str], Outlook]
    changed: float = 0.0
    looking: bool = False  # ignore the depsgraph updates that our own evaluation causes


_cache = _Cache({})


def chosen_objects(view_layer: bpy.types.ViewLayer) -> tuple[str, ...]:
    """Names of the objects to bake: the selected meshes, or else the active one; originals, not previews."""
    from ..preview.swap import original_of

    found = (original_of(item) or item for item in selected_meshes(view_layer))
    return tuple(sorted({item.name for item in found}))


def outlook_of(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Outlook | None:
    """The cached outlook; None if the timer has not computed it yet."""
    return _cache.found.get(_key(scene, view_layer))


def refresh(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Outlook:
    """Compute the outlook and cache it."""
    _cache.looking = True
    try:
        found = _cache.found[_key(scene, view_layer)] = _work_out(scene, view_layer)
    finally:
        _cache.looking = False
    return found


@persistent  # type: ignore[untyped-decorator]  # untyped in the stubs
def mark_stale(*_: object) -> None:
    """Handler: recompute the cache soon. Accepts the arguments of any handler."""
    if _cache.looking:
        return
    _cache.changed = monotonic()
    if not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=_QUIET, persistent=True)


def register() -> None:
    """Add the handlers that mark the cache stale."""
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


def _work_out(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Outlook:
    from ..bake.cost import cost_of
    from ..core.errors import InputError
    from ..preview.swap import is_on
    from . import estimates
    from .layouts import chosen_layouts, told_layouts
    from .request import BakeRequest, has_folder, spec_of, values_of
    from .surfaces import have_own_atlases

    names = chosen_objects(view_layer)
    settings: BakeSettings = scene.radtex  # type: ignore[attr-defined]  # ours, not Blender's
    values = values_of(settings)
    try:
        asked = spec_of(values)
        chosen = chosen_layouts(scene, names, values, asked, _PATIENCE)
    except InputError as error:
        return Outlook(names, (str(error),), ())
    costs = {choice.spec: cost_of(choice.spec) for _, choice in chosen}
    spec = max(costs, key=lambda one: costs[one].gpu)
    cost, seconds, layout = costs[spec], None, told_layouts(values, chosen)
    if have_own_atlases(values, asked, len(names)) and len(chosen) >= len(names):
        seconds = estimates.seconds_known(scene, [(name, choice.spec) for name, choice in chosen if name])
    try:
        request = BakeRequest.of(values)
    except InputError as error:
        wanting = () if has_folder(values) else ("directory",)
        return Outlook(names, (str(error),), (), spec, cost, seconds, remedies=wanting, layout=layout)
    seen = request.foreseen(scene, names, _PATIENCE)
    if seconds is not None and not seen.errors:
        seconds *= len(request.specs(scene))
    remedies = request.remedies(scene, names, _PATIENCE) if seen.errors else {}
    forgets = not seen.errors and request.forgets(scene, names, _PATIENCE)
    return Outlook(
        names,
        seen.errors,
        seen.warnings,
        spec,
        cost,
        seconds,
        request.folder,
        remedies=tuple(remedies),
        baked=remedies == {"overwrite": 0},
        forgets=forgets,
        shown=tuple(name for name in names if is_on(scene.objects[name])),
        layout=layout,
    )
