# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is measured: settings, seeds and methods, and in which order."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from .cells import Key

SEEDS = (1, 2, 3, 4, 5)  # of bakes


@dataclass(frozen=True)
class Setting:
    """Texels along a side of the atlas, and samples as of `bake.py --samples`."""

    texels: int
    samples: int


MAIN = Setting(64, 16)
BY_PATHS = (Setting(64, 1), Setting(64, 4), MAIN)
BY_BYTES = (Setting(32, 16), MAIN, Setting(128, 16))
NOTHING = Setting(0, 0)  # of what is not baked


class Group(StrEnum):
    """Methods that are measured together, because they are made of one capture."""

    LAYERED = "layered"
    CAPTURE = "capture"
    BUCKETS = "buckets"
    DENOISED = "denoised buckets"
    UNBAKED = "unbaked"


METHODS = {
    Group.LAYERED: ("layered",),
    Group.CAPTURE: ("probe", "sg", "sh3", "sh", "lightmap"),
    Group.BUCKETS: ("buckets", "buckets nearest"),
    Group.DENOISED: ("buckets denoised",),
    Group.UNBAKED: ("eevee", "reference again"),
}
BAKED = (
    *METHODS[Group.LAYERED],
    *METHODS[Group.CAPTURE],
    *METHODS[Group.DENOISED],
    *METHODS[Group.BUCKETS],
)
TITLES = {
    "layered": "RadTex, layered (default)",
    "probe": "reflection probe + lightmap",
    "sg": "SG lightmap, 9 lobes",
    "sh3": "SH lightmap, L3",
    "sh": "SH lightmap, L2",
    "lightmap": "flat lightmap",
    "buckets denoised": "8 x 8 buckets, denoised, quadrilinear",
    "buckets": "8 x 8 buckets (paper), quadrilinear",
    "buckets nearest": "8 x 8 buckets (paper), nearest",
    "eevee": "Eevee, nothing baked",
    "reference again": "reference, other noise",
}


def keys_of(scene: str, setting: Setting, seed: int, group: Group) -> list[Key]:
    """What a group's measuring gives."""
    return [Key(setting.texels, setting.samples, scene, method, seed) for method in METHODS[group]]
