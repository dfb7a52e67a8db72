# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A layout that writes down what is drawn, since Blender has none without a window."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import bpy

_LAYOUT: Any = bpy.types.UILayout.bl_rna  # the stubs do not know its functions
_RADTEX: Any = bpy.ops.radtex  # type: ignore[attr-defined]  # ours, not Blender's
_FUNCTIONS = _LAYOUT.functions
_ICONS = {one.identifier for one in _FUNCTIONS["label"].parameters["icon"].enum_items}


class RecordedLayout:
    """`texts` are the labels, `settings` the names of the properties, in the order in which they are drawn.

    `buttons` are the names of operators and of their menus, and the arguments that these are given.

    AssertionError for a keyword, an icon or a property that Blender does not know.
    """

    def __init__(self) -> None:
        self.texts: list[str] = []
        self.settings: list[str] = []
        self.menus: list[str] = []
        self.buttons: list[tuple[str, SimpleNamespace]] = []

    def label(self, **options: Any) -> None:
        _check("label", options)
        self.texts.append(options["text"])

    def progress(self, **options: Any) -> None:
        _check("progress", options)
        self.texts.append(options["text"])

    def prop(self, data: Any, name: str, **options: Any) -> None:
        _check("prop", options)
        known = data.bl_rna.properties
        assert name in known or name in data.properties.bl_rna.properties, name
        self.settings.append(name)

    def prop_search(self, data: Any, name: str, _: Any, __: str, **options: Any) -> None:
        _check("prop_search", options)
        assert name in data.bl_rna.properties, name
        self.settings.append(name)

    def prop_enum(self, data: Any, name: str, value: str, **options: Any) -> None:
        _check("prop_enum", options)
        assert value in data.bl_rna.properties[name].enum_items, value
        self.texts.append(options.get("text", ""))

    def row(self, **options: Any) -> RecordedLayout:
        _check("row", options)
        return self

    def column(self, **options: Any) -> RecordedLayout:
        _check("column", options)
        return self

    def split(self, **options: Any) -> RecordedLayout:
        _check("split", options)
        return self

    def menu_pie(self) -> RecordedLayout:
        return self

    def menu(self, name: str, **options: Any) -> None:
        _check("menu", options)
        assert hasattr(bpy.types, name), name
        self.texts.append(options.get("text", ""))
        self.menus.append(name)

    def box(self) -> RecordedLayout:
        return self

    def operator(self, name: str, **options: Any) -> SimpleNamespace:
        _check("operator", options)
        return self._button(name, options)

    def operator_menu_enum(self, name: str, menu: str, **options: Any) -> SimpleNamespace:
        _check("operator_menu_enum", options)
        operator = getattr(_RADTEX, name.partition(".")[2])
        assert menu in operator.get_rna_type().properties, menu
        return self._button(name, options)

    def _button(self, name: str, options: dict[str, Any]) -> SimpleNamespace:
        arguments = SimpleNamespace()
        self.texts.append(options.get("text", ""))
        self.buttons.append((name, arguments))
        return arguments

    def template_list(self, cls: str, _id: str, data: Any, name: str, *_active: Any, **options: Any) -> None:
        _check("template_list", options)
        assert hasattr(bpy.types, cls), cls
        assert name in data.bl_rna.properties, name

    def separator(self, **options: Any) -> None:
        _check("separator", options)


def _check(function: str, options: dict[str, Any]) -> None:
    assert options.keys() <= {one.identifier for one in _FUNCTIONS[function].parameters}, options
    assert options.get("icon", "NONE") in _ICONS, options
