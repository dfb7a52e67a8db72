# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Format numbers, and word messages with the panel's names of settings."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bpy.app import translations

from ...core.messages import Message, Remedy, Setting, joined
from ...settings.options import CALLED

if TYPE_CHECKING:
    from ...core.errors import RadTexError
    from ...settings.time_left import Left

_translations: Any = translations  # the stubs type its functions as returning None

# Blender's translation tools look for calls of this name.
iface_: Callable[[str], str] = _translations.pgettext_iface

# The panel's names of settings. Those that are missing here have none: the panel does not offer them.
LABELS: dict[str, str] = {
    called: option.label or option.title for called, option in CALLED.items() if option.title
} | {
    Setting.ARRANGEMENT: "Arrangement",
    Setting.DEVICE: "Device, in RadTex's preferences",
    Setting.FORMAT: "Format",
    Setting.LEVELS: "Mip Levels",
    Setting.LIMIT: "Limit",
    Setting.MESH: "Mesh",
    Setting.MEMORY: "Memory (MB), in RadTex's preferences",
    Setting.OBJECT: "Object",
    Setting.OVERWRITE_ANY: "Overwrite Any",
    Setting.PIXELS: "Pixels",
}
STAGES = {  # labels of the stages of bakes, exports, comparisons and farms
    "evaluate": "Reading the mesh",
    "unwrap": "Unwrapping",
    "raster": "Laying out the texture",
    "probe": "Finding hidden parts",
    "capture": "Rendering the light",
    "surroundings": "Rendering what is around it",
    "fill": "Filling gaps",
    "denoise": "Denoising",
    "fit": "Making the textures",
    "write": "Writing files",
    "preview": "Making the preview",
    "textures": "Converting textures",
    "flat": "Making the flat picture",
    "mesh": "Writing the mesh",
    "pack": "Packing it up",
    "export": "Exporting",
    "reference": "Rendering the original",
    "compare": "Comparing",
    "hold": "Preparing the farm",
    "check": "Checking the farm's files",
}


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


def time_left_of(left: Left | None) -> str:
    """The time left of a job in words, such as "1 to 2 min left"."""
    from ...settings.time_left import told_left

    return told_left(left, iface_)


def time_left_briefly(left: Left | None) -> str:
    """The same in fewer words, such as "1 to 2 min"; nothing if it is not known."""
    return expected_range(left) if left is not None and left.is_known else ""


def expected_range(left: Left) -> str:
    """How long something is expected to take, such as "1 to 2 min" or "about 40 s"."""
    from ...settings.time_left import told_range

    return told_range(left, iface_)


def stage(name: str | None) -> str:
    """Label of a worker's stage; None means that it is still starting."""
    return iface_(STAGES[name] if name is not None else "Starting")


def remark(said: RadTexError | Message | str, folder: Path | None = None) -> str:
    """A message as the panel shows it: with the panel's names of settings, first letter a capital.

    Paths in `folder` are shortened to file names, because the sidebar is narrow.
    """
    message = Message(said) if isinstance(said, str) else said if isinstance(said, Message) else said.message
    text = joined(message.problem, map(_remedy, message.remedies))
    if folder is not None:
        text = text.replace(f"{folder}{os.sep}", "")
    return capitalized(text)


def capitalized(text: str) -> str:
    """The text with its first letter a capital."""
    return text[:1].upper() + text[1:]


def _remedy(remedy: Remedy) -> str:
    """What to do, with its settings in brackets, unless the panel has none or the text names them."""
    without = [LABELS.get(setting, str(setting)) for setting in remedy.without]
    if remedy.leaves_out:
        how = _left_out(remedy.without[0]) or ("as it was" if len(without) == 1 else "as they were")
        return f"leave {' and '.join(without)} {how} {remedy.text}".rstrip()
    used = [LABELS[setting] for setting in remedy.settings if setting in LABELS]
    said = remedy.text.lower()
    words = [] if all(label.lower() in said for label in used) and not without else used
    if without:
        words.append(f"without {' and '.join(without)}")
    return f"{remedy.text} ({', '.join(words)})" if words else remedy.text


def _left_out(setting: str) -> str:
    """How the panel shows that a setting is left out, such as "off"; empty for what has no such state."""
    option = CALLED.get(setting)
    if option is None or option.items or option.setting_default:
        return ""
    return {str: "empty", bool: "off"}.get(type(option.setting_default), "")
