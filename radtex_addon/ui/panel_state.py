# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panel shows of a bake before it starts, worked out between drawings and kept until a change.

Handlers only mark it stale; a timer works it out anew once nothing has changed for a moment.
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

_QUIET = 0.3  # seconds without a change, so that dragging stays fluid
_PATIENCE = 0.05  # seconds for looking at the objects


@dataclass(frozen=True)
class Outlook:
    """A bake of the chosen objects: what would fail, what to know, and what each of them costs at most.

    `spec` and `cost` are None where the settings cannot be; `seconds`, of all objects, where nobody has
    estimated them, or they have no atlases of their own; `folder` where there is none. `remedies` are names
    of settings that, switched, would settle errors; `baked` is true where nothing is wrong but that there are
    bakes already, `forgets` where an unfinished one would be thrown away that one could go on with. `shown`
    are those of the objects whose bakes are shown in their places. `layout` says what an automatic one came
    to, and why; empty where one was chosen.
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
    looking: bool = False  # then Blender tells of what it brings up to date for that


_cache = _Cache({})


def chosen_objects(view_layer: bpy.types.ViewLayer) -> tuple[str, ...]:
    """What the button bakes, by name: the selected meshes, or else the active one; not their previews."""
    from ..preview.swap import original_of

    found = (original_of(item) or item for item in selected_meshes(view_layer))
    return tuple(sorted({item.name for item in found}))


def outlook_of(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Outlook | None:
    """What was last worked out; None before the first time, and then soon there."""
    return _cache.found.get(_key(scene, view_layer))


def refresh(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Outlook:
    """Work it out anew, and keep it."""
    _cache.looking = True
    try:
        found = _cache.found[_key(scene, view_layer)] = _work_out(scene, view_layer)
    finally:
        _cache.looking = False
    return found


@persistent  # type: ignore[untyped-decorator]  # the stubs say nothing of it
def mark_stale(*_: object) -> None:
    """Something changed: what is kept will be worked out anew, soon. Any handler's arguments will do."""
    if _cache.looking:
        return
    _cache.changed = monotonic()
    if not bpy.app.timers.is_registered(_tick):
        bpy.app.timers.register(_tick, first_interval=_QUIET, persistent=True)


def register() -> None:
    """Listen to all that may change it."""
    for handlers in _lists():
        handlers.append(mark_stale)
    mark_stale()


def unregister() -> None:
    """Listen no more, and forget."""
    for handlers in _lists():
        if mark_stale in handlers:  # others may have emptied the list
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
    return (  # type: ignore[return-value]  # lists of functions, to the stubs of one event each
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
