# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Update callback that settings share: a change makes the panel's cached forecast stale."""

from __future__ import annotations

from typing import Any, TypeVar, get_type_hints

import bpy

from ..panel.panel_state import mark_stale


def notice(settings: Any, _: bpy.types.Context) -> None:
    """Mark the panel's state stale: Blender calls no handler when a script changes a property.

    Not for an operator's arguments, which drawing a button sets.
    """
    if isinstance(settings, bpy.types.PropertyGroup):
        mark_stale()


_OperatorType = TypeVar("_OperatorType", bound=type[bpy.types.Operator])


def without_updates(operator: _OperatorType) -> _OperatorType:
    """Class decorator: the operator's arguments are the settings that it inherits, without their callbacks.

    Drawing a button sets its arguments. Where one of them has an update callback, Blender then redraws all
    windows, with the button in them, again and again.
    """
    operator.__annotations__ = {
        name: deferred.function(**{key: value for key, value in deferred.keywords.items() if key != "update"})
        for name, deferred in get_type_hints(operator).items()
    }
    return operator


NOTICED: dict[str, Any] = {"update": notice, "options": {"SKIP_SAVE"}}  # arguments of a property
