# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Format numbers and translate error messages into the panel's labels."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

from bpy.app import translations

from .choices import COMPRESSIONS, LAYOUTS, SPLITS, UNWRAPS

_translations: Any = translations  # the stubs type its functions as returning None

# Blender's translation tools look for calls of this name.
iface_: Callable[[str], str] = _translations.pgettext_iface

# Panel labels of the command line's options. Options that are missing here have no setting in the panel.
LABELS = {
    "ao-distance": "Distance",
    "arrangement": "Arrangement",
    "bucket": "Cells",
    "budget": "MB on the GPU",
    "cage": "Cage",
    "compression": "Compression",
    "device": "Device, in RadTex's preferences",
    "extrusion": "Extrusion",
    "float": "32-bit Floats",
    "format": "Format",
    "frames": "Frames",
    "from": "From",
    "layer": "Layers",
    "layout": "Layout",
    "levels": "Mip Levels",
    "lights": "Variants",
    "limit": "Limit",
    "memory": "Memory (MB), in RadTex's preferences",
    "object": "Object",
    "out": "Folder",
    "overwrite": "Overwrite",
    "pixels": "Pixels",
    "resume": "Resume",
    "part": "Only",
    "save-preview": "Preview",
    "split": "Split",
    "together": "One Atlas",
    "unwrap": "Unwrap",
    "uv": "UV Layer",
}
STAGES = {  # labels of the stages of bakes, exports and comparisons
    "evaluate": "Reading the mesh",
    "unwrap": "Unwrapping",
    "raster": "Placing texels",
    "probe": "Finding hidden parts",
    "capture": "Tracing paths",
    "fill": "Filling gaps",
    "fit": "Sharing light",
    "condense": "Making it small",
    "write": "Writing files",
    "preview": "Making the preview",
    "textures": "Making textures",
    "flat": "Making the flat picture",
    "mesh": "Writing the mesh",
    "pack": "Packing it up",
    "reference": "Tracing paths",
    "compare": "Comparing",
}
_CHOICES = {"split": SPLITS, "layout": LAYOUTS, "unwrap": UNWRAPS, "compression": COMPRESSIONS}
_LEFT_OUT = {"uv": "empty", "from": "empty", "resume": "off"}  # text for other options: "as it was"

_OPTION = r"(?<![\w/.-])--([a-z][a-z-]*)"
_ASIDE = re.compile(r" \(([^()]*--[a-z][^()]*)\)")
_LEAVE = re.compile(r"leave ((?:--[a-z-]+(?: and )?)+) out")
_VALUE = re.compile(_OPTION + r" ([a-z]+)\b")
_NAME = re.compile(_OPTION)
_FORMAT = re.compile(r"\b(ktx2|dds)-(rgba16f|rgb9e5|bc6h)\b")
_FIELD = re.compile(r"\bbucket (?=\d)")  # specifications say bucket where the panel says Cells


def size(count: float) -> str:
    """Bytes in the units of disks: 1500000 is "1.5 MB"."""
    for unit, power in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if count >= power:
            return f"{count / power:.3g} {unit}" if count < 1000 * power else f"{count / power:.0f} {unit}"
    return f"{count:.0f} B"


def number(count: float) -> str:
    """A count, rounded to be readable: 16777216 is "16.8 million"."""
    if count >= 1e9:
        return iface_("{:.3g} billion").format(count / 1e9)
    if count >= 1e6:
        return iface_("{:.3g} million").format(count / 1e6)
    return f"{count:,.0f}"


def duration(seconds: float) -> str:
    """An approximate duration, with its unit."""
    if seconds < 1:
        return iface_("under a second")
    if seconds < 90:
        return iface_("{:.0f} s").format(seconds)
    if seconds < 90 * 60:
        return iface_("{:.0f} min").format(seconds / 60)
    return iface_("{:.1f} h").format(seconds / 3600)


def stage(name: str | None) -> str:
    """Label of a worker's stage; None means that it is still starting."""
    return iface_(STAGES[name] if name is not None else "Starting")


def remark(message: object, folder: Path | None = None) -> str:
    """A message as the panel shows it: options replaced by the panel's labels, first letter a capital.

    Paths in `folder` are shortened to file names, because the sidebar is narrow.
    """
    text = str(message)
    if folder is not None:
        text = text.replace(f"{folder}{os.sep}", "")
    text = _ASIDE.sub(_aside, text)
    text = _LEAVE.sub(_leave, text)
    text = _NAME.sub(_label, _VALUE.sub(_choice, text))
    text = _FORMAT.sub(lambda found: found[0].upper().replace("-", " "), text)
    text = _FIELD.sub("cells ", text)
    return text[:1].upper() + text[1:]


def _aside(found: re.Match[str]) -> str:
    """Relabel a bracketed remark on options; drop it if the text before names them or the panel has none."""
    names = _NAME.findall(found[1])
    before = found.string[: found.start()].lower()
    if not all(name in LABELS for name in names) or all(LABELS[name].lower() in before for name in names):
        return ""
    return f" ({_NAME.sub(_label, found[1])})"


def _leave(found: re.Match[str]) -> str:
    names = _NAME.findall(found[1])
    labels = " and ".join(LABELS.get(name, name) for name in names)
    return f"leave {labels} {_LEFT_OUT.get(names[0], 'as it was' if len(names) == 1 else 'as they were')}"


def _choice(found: re.Match[str]) -> str:
    named = {identifier: name for identifier, name, _ in _CHOICES.get(found[1], ())}
    if found[2] not in named:
        return found[0]
    return f"{LABELS[found[1]]}: {named[found[2]]}"


def _label(found: re.Match[str]) -> str:
    return LABELS.get(found[1], found[1].capitalize())
