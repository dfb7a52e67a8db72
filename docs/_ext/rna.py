# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender properties as Markdown."""

from __future__ import annotations

from typing import Any

from .markdown import code, escaped

_TYPES = {"BOOLEAN": "bool", "INT": "int", "FLOAT": "float", "STRING": "str", "COLLECTION": "collection"}
_HUGE = 1e9  # limits beyond are Blender's own


def told(prop: Any) -> str:
    """A property's tooltip as a sentence."""
    return f"{escaped(prop.description).rstrip('.')}." if prop.description else ""


def type_of(prop: Any) -> str:
    """A property's type in Python."""
    if prop.type == "ENUM":
        return "set of str" if prop.is_enum_flag else "str"
    if prop.type == "POINTER":
        return str(prop.fixed_type.identifier)
    return _TYPES[prop.type]


def default_of(prop: Any) -> str:
    """A property's default as Python writes it; empty if it has none."""
    if prop.type in {"POINTER", "COLLECTION"}:
        return ""
    if prop.type == "ENUM" and prop.is_enum_flag:
        return repr(set(prop.default_flag)) if prop.default_flag else "set()"
    return repr(round(prop.default, 6) if prop.type == "FLOAT" else prop.default)


def limits_of(prop: Any) -> str:
    """The range of a number, such as "1 to 256"; empty if it has none."""
    if prop.type not in {"INT", "FLOAT"}:
        return ""
    low, high = (
        f"{limit:.6g}" if prop.type == "FLOAT" else str(limit) for limit in (prop.hard_min, prop.hard_max)
    )
    if prop.hard_max < _HUGE:
        return f"{low} to {high}"
    return f"{low} or more" if prop.hard_min > -_HUGE else ""


def choices(prop: Any) -> str:
    """An enum's choices, a list; empty if the property is none."""
    items = prop.enum_items if prop.type == "ENUM" else ()
    return "\n".join(
        f"* **{escaped(item.name)}** ({code(repr(item.identifier))}): {escaped(item.description)}"
        for item in items
    )
