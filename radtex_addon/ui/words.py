# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures and errors in the panel's words."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from bpy.app import translations

_translations: Any = translations  # whose stubs say that nothing comes back

# By this name Blender's tools find what is to be translated.
iface_: Callable[[str], str] = _translations.pgettext_iface

# How the batch calls what the panel has a button for: beside the remedy, or as the remedy.
_ASIDE = re.compile(r" \(--[a-z][a-z-]*\)")
_FLAG = re.compile(r"--([a-z][a-z-]*)")
_NAMES = {"uv": "UV Layer", "memory": "Memory for a Tile", "save-preview": "Preview", "out": "Output Folder"}


def size(count: float) -> str:
    """Bytes in the units of disks: 1500000 is "1.5 MB"."""
    for unit, power in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if count >= power:
            return f"{count / power:.3g} {unit}" if count < 1000 * power else f"{count / power:.0f} {unit}"
    return f"{count:.0f} B"


def number(count: float) -> str:
    """Rounded to what people read: 16777216 is "16.8 million"."""
    if count >= 1e9:
        return iface_("{:.3g} billion").format(count / 1e9)
    if count >= 1e6:
        return iface_("{:.3g} million").format(count / 1e6)
    return f"{count:,.0f}"


def duration(seconds: float) -> str:
    """A time that nobody takes for exact."""
    if seconds < 1:
        return iface_("under a second")
    if seconds < 90:
        return iface_("{:.0f} s").format(seconds)
    if seconds < 90 * 60:
        return iface_("{:.0f} min").format(seconds / 60)
    return iface_("{:.1f} h").format(seconds / 3600)


def remark(message: str) -> str:
    """An error as the panel shows it: without the batch's options, and beginning with a capital."""
    plain = _FLAG.sub(lambda found: _NAMES.get(found[1], found[1].capitalize()), _ASIDE.sub("", message))
    return plain[:1].upper() + plain[1:]
