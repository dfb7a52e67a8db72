# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators' reference, from Blender's definitions."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import bpy

from radtex_addon.ui import registration
from radtex_addon.ui.settings.bake_settings import NAMES

from .markdown import code, escaped
from .rna import default_of, limits_of, told, type_of

_ops: Any = bpy.ops  # the stubs know Blender's own operators only
_OF_BAKES = {"bake", "estimate"}  # operators that take every setting of a bake


def operators(_: str) -> str:
    """Every operator with its Python signature, tooltip and arguments."""
    classes: list[Any] = [cls for cls in registration.CLASSES if issubclass(cls, bpy.types.Operator)]
    names = sorted(cls.bl_idname.partition(".")[2] for cls in classes)
    return "\n".join(line for name in names for line in _operator(name))


def _operator(name: str) -> Iterator[str]:
    rna = getattr(_ops.radtex, name).get_rna_type()
    shown = [
        prop
        for prop in rna.properties
        if prop.is_runtime and not prop.is_hidden and prop.identifier != "bl_idname"
    ]
    settings = [prop for prop in shown if prop.identifier in NAMES]
    own = [prop for prop in shown if prop.identifier not in NAMES]
    if name not in _OF_BAKES:
        own, settings = shown, []
    words = ", ".join([f"{prop.identifier}={default_of(prop) or 'None'}" for prop in own])
    words += ", **settings" if settings else ""
    yield f":::{{py:function}} bpy.ops.radtex.{name}({'*, ' * bool(own)}{words.removeprefix(', ')})\n"
    yield f"{escaped(rna.description or rna.name).rstrip('.')}.\n"
    yield from map(_argument, own)
    if settings:
        yield "* `settings`: any [setting of a bake](panel.md), by its name; the others are as in the panel."
    yield ":::\n"


def _argument(prop: Any) -> str:
    facts = type_of(prop) + (f", {limits}" if (limits := limits_of(prop)) else "")
    items = prop.enum_items if prop.type == "ENUM" else ()
    named = "; ".join(f"{code(repr(item.identifier))} {escaped(item.name)}" for item in items)
    return f"* {code(prop.identifier)} ({facts}): {told(prop)}" + (f" {named}." if named else "")
