# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects of a selection, a list or a collection cannot be baked, and why: the others are baked.

A fault of the settings is no fault of an object: it stays an error, whichever objects it concerns.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import inf
from time import monotonic
from typing import NamedTuple

import bpy

from ..core.errors import InputError
from ..core.messages import Message
from ..preview.kept_copies import refuse_copy
from ..preview.linked import check_replaceable
from ..scene.checks.refusals import refuse_see_through
from ..scene.mesh.evaluated import why_not_evaluated
from ..scene.mesh.mesh_checks import check_shown
from ..scene.mesh.source_hits import find_source
from ..scene.objects import find_object
from ..scene.proxy_content import find_content
from ..scene.scratch import find_view_layer, scratch_scene
from ..settings.spec import BakeSpec

_NAMED = 8  # most names in a line


@dataclass(frozen=True)
class LeftOut:
    """An object that cannot be baked, and why."""

    name: str
    why: Message


class Found(NamedTuple):
    """Names of the objects that can be baked, in the order given, and the others."""

    kept: tuple[str, ...]
    left_out: tuple[LeftOut, ...]


def find_bakeable(
    scene: bpy.types.Scene,
    names: Sequence[str],
    spec: BakeSpec | None,
    *,
    preview: bool,
    now: bool = True,
    patience: float = inf,
    evaluate: bool = False,
) -> Found:
    """Sort out the objects that cannot be baked, whatever the settings. Changes nothing.

    `spec` is how they are to be baked, None if that is not known; `preview` whether their previews are saved.
    Unless they are baked as they are `now`, but at other frames, what animation may change is not looked at.
    To `evaluate` the scene once tells all, at a render's expense; else objects whose faults only a render
    shows are kept, and after `patience` seconds those that were not looked at.
    """
    layer = find_view_layer(scene, None)
    if bpy.app.background:
        layer.update()  # without a window nothing else brings it up to date
    found: dict[str, Message] = {}
    since = monotonic()
    asked = tuple(dict.fromkeys(names))
    for number, name in enumerate(asked):
        if number and monotonic() - since > patience:
            break
        try:
            _check_settings(scene, name, spec, preview)
            if now:
                _check_now(scene, layer, name, spec, shown=not evaluate)
        except InputError as error:
            found[name] = error.message
    if evaluate and now and len(found) < len(asked):
        with scratch_scene(scene) as scratch:
            items = [scene.objects[name] for name in asked if name not in found]
            found |= {item.name: why for item, why in why_not_evaluated(scratch, items).items()}
    kept = tuple(name for name in asked if name not in found)
    return Found(kept, tuple(LeftOut(name, found[name]) for name in asked if name in found))


def _check_settings(scene: bpy.types.Scene, name: str, spec: BakeSpec | None, preview: bool) -> None:
    """Raise InputError if the object is a copy that shows a bake, of the wrong sort, or baked from."""
    if name in scene.objects:
        refuse_copy(scene.objects[name])
    item = find_object(scene, name)
    if preview:
        check_replaceable([item])
    if spec is not None and spec.source == name:
        find_source(scene, item, name)


def _check_now(
    scene: bpy.types.Scene, layer: bpy.types.ViewLayer, name: str, spec: BakeSpec | None, *, shown: bool
) -> None:
    """Raise InputError if the object cannot be baked at the current frame, as far as that is quickly known.

    With `shown`, also by what the viewport shows of it.
    """
    item = scene.objects[name]
    if shown:
        check_shown(scene, layer, item)
    if spec is None:
        return
    if spec.source is None and spec.kind.traits.needs_camera_rays:
        refuse_see_through(layer, item)
    if spec.kind.traits.content and spec.content is None:
        find_content(layer, item, None)


def left_out_lines(left_out: Iterable[LeftOut]) -> tuple[Message, ...]:
    """A line for each sort of reason, which names the objects."""
    return tuple(Message(f"left out: {why.problem}", why.remedies) for why in reasons(left_out))


def reasons(left_out: Iterable[LeftOut]) -> tuple[Message, ...]:
    """The reasons; those that are the same but for the object's name are one, which names all."""
    sorts: dict[str, list[LeftOut]] = {}
    for one in left_out:
        sorts.setdefault(str(one.why).replace(f"'{one.name}'", "'…'"), []).append(one)
    return tuple(_joined(first.why, [one.name for one in others]) for first, *others in sorts.values())


def _joined(why: Message, others: Sequence[str]) -> Message:
    if not others:
        return why
    more = f" and {len(others) - _NAMED} more" if len(others) > _NAMED else ""
    names = ", ".join(f"'{name}'" for name in others[:_NAMED])
    return Message(f"{why.problem}; likewise {names}{more}", why.remedies)
