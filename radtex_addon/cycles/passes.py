# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles's light passes: how a view layer is asked for them, and what a render calls them."""

from __future__ import annotations

from typing import TypeAlias

from ..core.arrays import Floats

Passes: TypeAlias = dict[str, Floats]  # by the name that Blender gives them

# Blender 5's names, and 4.5's
_LOBES = {
    "diffuse": ("Diffuse", "Diff"),
    "glossy": ("Glossy", "Gloss"),
    "transmission": ("Transmission", "Trans"),
    "volume": ("Volume", "Volume"),
}
_PARTS = {"direct": (" Direct", "Dir"), "indirect": (" Indirect", "Ind"), "color": (" Color", "Col")}
_SINGLE = {
    "emission": ("use_pass_emit", ("Emission", "Emit")),
    "environment": ("use_pass_environment", ("Environment", "Env")),
    "normal": ("use_pass_normal", ("Normal",)),
}


def attributes_of(name: str) -> tuple[str, ...]:
    """What to switch on in a view layer for a lobe's light, or for one of emission, environment, normal."""
    if name in _SINGLE:
        return (_SINGLE[name][0],)
    if name == "volume":  # which has no colour to be divided by
        return "cycles.use_pass_volume_direct", "cycles.use_pass_volume_indirect"
    return tuple(f"use_pass_{name}_{part}" for part in _PARTS)


def light_of(passes: Passes, name: str) -> Floats:
    """The light of a lobe, of emission or of the environment, or the normal: (..., 3) of a render's passes.

    Cycles divides its lobes' passes by their colour.
    """
    if name in _SINGLE:
        return _found(passes, _SINGLE[name][1])
    light = part_of(passes, name, "direct") + part_of(passes, name, "indirect")
    return light if name == "volume" else light * part_of(passes, name, "color")


def part_of(passes: Passes, lobe: str, part: str) -> Floats:
    """One of a lobe's passes, `part` being direct, indirect or color: (..., 3)."""
    pairs = zip(_LOBES[lobe], _PARTS[part], strict=True)
    return _found(passes, tuple(first + last for first, last in pairs))


def _found(passes: Passes, names: tuple[str, ...]) -> Floats:
    return next(passes[name][..., :3] for name in names if name in passes)
