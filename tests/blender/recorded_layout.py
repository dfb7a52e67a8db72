# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A layout that writes down what is drawn, since Blender has none without a window."""

from __future__ import annotations

from typing import Any

import bpy

_LAYOUT: Any = bpy.types.UILayout.bl_rna  # the stubs do not know its functions
_FUNCTIONS = _LAYOUT.functions
_ICONS = {one.identifier for one in _FUNCTIONS["label"].parameters["icon"].enum_items}


class RecordedLayout:
    """`texts` are the labels, `settings` the names of the properties, in the order in which they are drawn.

    AssertionError for a keyword, an icon or a property that Blender does not know.
    """

    def __init__(self) -> None:
        self.texts: list[str] = []
        self.settings: list[str] = []

    def label(self, **options: Any) -> None:
        _check("label", options)
        self.texts.append(options["text"])

    def prop(self, data: Any, name: str, **options: Any) -> None:
        _check("prop", options)
        assert name in data.bl_rna.properties or name in data.properties.bl_rna.properties, name
        self.settings.append(name)

    def row(self, **options: Any) -> RecordedLayout:
        _check("row", options)
        return self

    def column(self, **options: Any) -> RecordedLayout:
        _check("column", options)
        return self

    def separator(self, **options: Any) -> None:
        _check("separator", options)


def _check(function: str, options: dict[str, Any]) -> None:
    assert options.keys() <= {one.identifier for one in _FUNCTIONS[function].parameters}, options
    assert options.get("icon", "NONE") in _ICONS, options
