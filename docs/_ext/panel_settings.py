# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel's reference, from Blender's definitions of the settings."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from radtex_addon.settings.option import Fold
from radtex_addon.settings.options import shown_in
from radtex_addon.settings.presets import STOCK, stock_values
from radtex_addon.ui.settings.bake_settings import NAMES, RADTEX_PG_settings
from radtex_addon.ui.settings.chosen_objects import RADTEX_PG_chosen
from radtex_addon.ui.settings.object_settings import RADTEX_PG_object
from radtex_addon.ui.settings.preferences import RADTEX_preferences

from .markdown import code, escaped, table
from .rna import choices, default_of, limits_of, told, type_of

_BLENDERS = {"name", "rna_type"}  # properties that every group has


def settings(_: str) -> str:
    """Every setting of a bake, in the panel's folds."""
    known = RADTEX_PG_settings.bl_rna.properties
    parts = []
    for fold in Fold:
        parts += [f"## {fold}\n", *(_setting(known[option.setting]) for option in shown_in(fold))]
    return "\n".join(parts)


def preferences(_: str) -> str:
    """RadTex's preferences."""
    kept = RADTEX_preferences.__annotations__
    return "\n".join(_setting(RADTEX_preferences.bl_rna.properties[name]) for name in kept)


def shared_settings(_: str) -> str:
    """What is kept beside a bake's settings: the choice of objects, and the switch of an object's own."""
    rows = []
    for owner, cls, names in (
        ("scene.radtex_chosen", RADTEX_PG_chosen, tuple(RADTEX_PG_chosen.__annotations__)),
        ("object.radtex", RADTEX_PG_object, ("use",)),
    ):
        for name in names:
            prop = cls.bl_rna.properties[name]
            rows.append((code(f"{owner}.{name}"), code(type_of(prop)), told(prop)))
    return table(("property", "type", "what it is"), rows)


def presets(_: str) -> str:
    """The presets that RadTex brings, with what each sets."""
    values = {name: stock_values(name) for name, _, _ in STOCK}
    names = sorted({setting for found in values.values() for setting in found}, key=NAMES.index)
    known: Any = RADTEX_PG_settings.bl_rna.properties
    rows = [
        (
            f"**{label}**",
            code(name),
            *(_value(known[setting], values[name].get(setting)) for setting in names),
        )
        for name, label, _ in STOCK
    ]
    lines = [f"* **{label}**: {escaped(tip)}." for _, label, tip in STOCK]
    head = ("preset", "name", *(escaped(known[setting].name) for setting in names))
    return "\n".join([*lines, "", table(head, rows)])


def _value(prop: Any, value: Any) -> str:
    if value is None:
        return "as it is"
    return escaped(prop.enum_items[value].name if prop.type == "ENUM" else str(value))


def _setting(prop: Any) -> str:
    return "\n".join(_lines(prop))


def _lines(prop: Any) -> Iterator[str]:
    """A setting: its label, its name and type, the tooltip and the choices."""
    facts = [f"{code(prop.identifier)}: {type_of(prop)}"]
    facts += [f"default {code(default)}"] if (default := default_of(prop)) else []
    facts += [limits] if (limits := limits_of(prop)) else []
    yield f"### {escaped(prop.name)}\n"
    yield f"{', '.join(facts)}\n"
    yield f"{told(prop)}\n"
    if found := choices(prop):
        yield f"{found}\n"
