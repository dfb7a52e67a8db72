# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake's settings: stored with the scene for the panel, and keyword arguments of the bake operator.

They are made from the table of options. What needs Blender in a row is a hook, named there and defined here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, cast

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from ...scene.mesh.named_regions import places_on
from ...scene.surfaces import may_have_faces
from ...settings.choices import parse_kind, parse_layout
from ...settings.kinds import Kind, Layout, form_in
from ...settings.option import Option
from ...settings.options import SHOWN
from ..panel.panel_state import mark_stale
from .update_callbacks import NOTICED

NAMES = tuple(SHOWN)  # of the properties

_OWN_CELLS = "radtex_cells"  # custom property: the user's bucket size for each `_sort_of_cells`
_KINDS: dict[type, Any] = {
    bool: BoolProperty,
    int: IntProperty,
    float: FloatProperty,
    str: StringProperty,
}


def suited_bucket(kind: str, layout: str) -> int:
    """Default bucket size for this kind and layout, in cells along a side."""
    traits = parse_kind(kind).traits
    if traits.form is not None:
        return traits.form.cells
    if layout in ("auto", ""):  # empty: an earlier version saved a layout that is no longer there
        return (Layout.LAYERED if traits.looks_at_surface else Layout.BUCKETS).cells
    return form_in(parse_layout(layout)).cells


def _suit_bucket(settings: BakeSettings, _: bpy.types.Context) -> None:
    """Update callback of kind and layout: restore the bucket size last used with them, or the default.

    Only for the panel: an operator's keyword arguments are not adjusted.
    """
    if isinstance(settings, bpy.types.PropertyGroup):
        own = cast(Any, settings).get(_OWN_CELLS, {}).get(_sort_of_cells(settings))
        settings.bucket = own or suited_bucket(settings.kind, settings.atlas_layout)
        mark_stale()


def _keep_bucket(settings: BakeSettings, _: bpy.types.Context) -> None:
    """Update callback: remember the bucket size for the current `_sort_of_cells`."""
    if isinstance(settings, bpy.types.PropertyGroup):
        known = dict(cast(Any, settings).get(_OWN_CELLS, {}))
        cast(Any, settings)[_OWN_CELLS] = known | {_sort_of_cells(settings): settings.bucket}
        mark_stale()


def _sort_of_cells(settings: BakeSettings) -> str:
    """Key of the remembered bucket size; for `ao`, which has no buckets, that is its grid of rays."""
    kind = Kind(settings.kind).traits
    if not kind.cells or suited_bucket(settings.kind, "buckets") != Layout.BUCKETS.cells:
        return str(settings.kind)
    if kind.form is None and settings.atlas_layout in tuple(Layout):
        return form_in(Layout(settings.atlas_layout)).name
    return str(settings.atlas_layout) if kind.looks_at_surface else Layout.BUCKETS.value


def places(settings: BakeSettings, around: bpy.types.Context, typed: str) -> Iterator[tuple[str, str]]:
    """Search function: named regions that match `typed`, each with its type.

    They are those of the object whose settings these are, or else of the active one.
    """
    owner = settings.id_data
    item = owner if isinstance(owner, bpy.types.Object) else around.object
    if item is not None and may_have_faces(item):
        for name, kind in places_on(item).items():
            if typed.lower() in name.lower():
                yield name, kind.capitalize()


_HOOKS: dict[str, Callable[..., Any]] = {
    "suit_bucket": _suit_bucket,
    "keep_bucket": _keep_bucket,
    "places": places,
}


def _property(option: Option) -> Any:
    """Blender's property of an option."""
    told = dict(option.blender)
    if option.limits is not None:
        told["min"], told["max"] = option.limits
    told |= {"name": option.title, "description": option.tooltip, "default": option.setting_default}
    told = NOTICED | told | {argument: _HOOKS[hook] for argument, hook in option.hooks.items()}
    if not option.items:
        return _KINDS[type(option.setting_default)](**told)
    if isinstance(option.setting_default, set):
        told["options"] = told["options"] | {"ENUM_FLAG"}
    return EnumProperty(items=option.items, **told)


class BakeSettings:
    """Mixin with all bake properties, for the scene's settings and the operator; not registered itself."""

    if TYPE_CHECKING:  # Blender creates the properties from the annotations below

        def __getattr__(self, name: str) -> Any: ...

        def __setattr__(self, name: str, value: Any) -> None: ...
    else:
        __annotations__ = {name: _property(option) for name, option in SHOWN.items()}


class RADTEX_PG_settings(BakeSettings, bpy.types.PropertyGroup):
    """What RadTex's panel shows, kept with the scene"""
