# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Messages as data: what is wrong, and what to do about it with which settings.

The command line and the panel call the same setting by different names (`--uv`, "UV Map"). So a message
refers to settings by their default names, and `cli.wording` and `ui.panel.labels` insert their own.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

from .quoting import printable


class Setting(StrEnum):
    """Settings that code names. The value is the default name in messages; see `settings.options`."""

    ACCUMULATE = "accumulating"
    AO_DISTANCE = "distance of ambient occlusion"
    ARRANGEMENT = "arrangement"
    BACKS = "backs"
    BAKE_NAME = "bake's name"
    BUCKET = "cells"
    CAGE = "cage"
    CAPTURE = "capture method"
    CHANGED = "baking only what has changed"
    COMPRESSION = "compression"
    DENSITY = "texel density"
    DEVICE = "device"
    EXTRUSION = "extrusion"
    FLOAT = "32-bit floats"
    FORMAT = "format"
    FRAMES = "frames"
    FROM = "source object"
    LAYER = "layer"
    LAYOUT = "layout"
    LEVELS = "levels"
    LIGHTS = "lamps"
    LIMIT = "limit"
    MEMORY = "memory"
    MESH = "mesh"
    OBJECT = "object"
    OUT = "folder"
    OVERWRITE = "overwriting"
    OVERWRITE_ANY = "overwriting better bakes and those of other files"
    PART = "part"
    PIXELS = "pixels"
    REFRESH = "refreshing"
    RESUME = "resuming"
    SAVE_PREVIEW = "preview"
    SCRIPTS = "scripts of the file"
    SEED = "seed"
    SHEET = "size of pictures"
    SPLIT = "split"
    TEXELS = "texels"
    TEXEL_WEIGHTS = "texel weights"
    TOGETHER = "name of the atlas"
    UNWRAP = "unwrap"
    UV = "UV layer"
    VERBOSE = "Blender's own messages"


@dataclass(frozen=True)
class Remedy:
    """One thing to do: `text` in plain words, with `settings` turned on, set to `value`, or chosen.

    Settings in `without` are to be left at their defaults. A remedy that only leaves settings out has no
    `settings`; its `text`, if any, is the purpose.
    """

    text: str = ""
    settings: tuple[str, ...] = ()
    value: str = ""
    without: tuple[str, ...] = ()

    @property
    def leaves_out(self) -> bool:
        """Whether it only leaves settings out."""
        return bool(self.without) and not self.settings

    def __str__(self) -> str:
        if not self.leaves_out:
            return self.text
        return f"leave {' and '.join(f'the {setting}' for setting in self.without)} out {self.text}".rstrip()


def do(text: str, *settings: str, value: str = "", without: tuple[str, ...] = ()) -> Remedy:
    """A remedy: do `text`, by means of these settings."""
    return Remedy(printable(text), settings, value, without)


def leave_out(*settings: str, to: str = "") -> Remedy:
    """A remedy: leave these settings out; `to` is the purpose, such as "to have one made"."""
    return Remedy(printable(to), without=settings)


@dataclass(frozen=True)
class Message:
    """A problem, or something worth knowing, in one line, and the remedies: any one of them is enough."""

    problem: str
    remedies: tuple[Remedy, ...] = ()

    def __str__(self) -> str:
        return joined(self.problem, map(str, self.remedies))

    def facts(self) -> dict[str, Any]:
        """The message as JSON's types."""
        return asdict(self)

    @classmethod
    def of_facts(cls, facts: Mapping[str, Any]) -> Message:
        """Inverse of `facts`."""
        return cls(str(facts["problem"]), tuple(map(_remedy, facts["remedies"])))


def joined(problem: str, remedies: Iterable[str]) -> str:
    """One sentence from a problem and the texts of its remedies."""
    found = ", or ".join(remedies)
    return f"{problem}: {found}" if found else problem


def _remedy(facts: Mapping[str, Any]) -> Remedy:
    return Remedy(facts["text"], tuple(facts["settings"]), facts["value"], tuple(facts["without"]))
