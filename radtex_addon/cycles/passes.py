# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Cycles's light passes: the view layer's settings that enable them, and their names in a render.

The colours of renders are converted to Rec.709 here and nowhere else: Blender writes multi-layer pictures in
the .blend's working space.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..core.arrays import Floats
from ..core.colour_spaces import converted
from ..core.errors import BakeError

# Names in Blender 5, and in 4.5
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
_VECTORS = frozenset({"normal"})  # not colours: not converted
_MOST = 1e30  # of light: what is more counts as infinite, as sums of it are
_ASTRAY = 0.01  # share of a picture that may not be finite: faulty shaders make a few such pixels


@dataclass(frozen=True, eq=False)
class Passes:
    """A render's passes as Blender wrote them: `raw` has arrays (..., C) under Blender's names for them.

    The combined pass comes first. `to_rec709` (3, 3) converts colours to Rec.709; None if they already are.
    """

    raw: dict[str, Floats]
    to_rec709: Floats | None = None

    @property
    def raw_whole(self) -> Floats:
        """The combined pass in the .blend's working space: for data that is encoded as colours."""
        return next(iter(self.raw.values()))

    @property
    def whole(self) -> Floats:
        """The combined pass in Rec.709: (..., 4) with its alpha, or (..., 3)."""
        raw = self.raw_whole
        if self.to_rec709 is None:
            return raw
        return np.concatenate([self.in_rec709(raw[..., :3]), raw[..., 3:]], axis=-1)

    def in_rec709(self, colours: Floats) -> Floats:
        """Convert colours (..., 3) of these passes, or products of them, to Rec.709."""
        return converted(colours, self.to_rec709)

    def mapped(self, change: Callable[[Floats], Floats]) -> Passes:
        """A copy with `change` applied to each pass."""
        return replace(self, raw={name: change(pixels) for name, pixels in self.raw.items()})


def finite_light(light: Floats) -> Floats:
    """The light (..., C) of a picture, with 0 where it is not finite, since Cycles drops that in paths.

    Raises BakeError if that is more than a hundredth of the picture.
    """
    finite = (np.abs(light) < _MOST).all(axis=-1, keepdims=True)  # of NaN, not
    if finite.all():
        return light
    if 1 - finite.mean() > _ASTRAY:
        raise BakeError(
            f"{1 - finite.mean():.0%} of the light that Cycles found is not a finite number: look for "
            "infinite values and NaN in images, and in what nodes of the world, lamps and materials compute"
        )
    return np.where(finite, light, light.dtype.type(0))


def attributes_of(name: str) -> tuple[str, ...]:
    """The view layer's attributes to switch on for a lobe's light, or for emission, environment or normal."""
    if name in _SINGLE:
        return (_SINGLE[name][0],)
    if name == "volume":  # has no colour pass
        return "cycles.use_pass_volume_direct", "cycles.use_pass_volume_indirect"
    return tuple(f"use_pass_{name}_{part}" for part in _PARTS)


def light_of(passes: Passes, name: str) -> Floats:
    """The light of a lobe, of emission or of the environment, in Rec.709, or the normal: (..., 3)."""
    light = raw_light_of(passes, name)
    return light if name in _VECTORS else passes.in_rec709(light)


def raw_light_of(passes: Passes, name: str) -> Floats:
    """Like `light_of`, but in the .blend's working space.

    Cycles divides a lobe's passes by its colour, channel by channel in that space.
    """
    if name in _SINGLE:
        return _found(passes, _SINGLE[name][1])
    light = _part_of(passes, name, "direct") + _part_of(passes, name, "indirect")
    return light if name == "volume" else light * _part_of(passes, name, "color")


def colour_of(passes: Passes, lobe: str) -> Floats:
    """A lobe's colour pass in Rec.709: (..., 3)."""
    return passes.in_rec709(_part_of(passes, lobe, "color"))


def _part_of(passes: Passes, lobe: str, part: str) -> Floats:
    """One of a lobe's passes, (..., 3); `part` is direct, indirect or color."""
    pairs = zip(_LOBES[lobe], _PARTS[part], strict=True)
    return _found(passes, tuple(first + last for first, last in pairs))


def _found(passes: Passes, names: tuple[str, ...]) -> Floats:
    return next(passes.raw[name][..., :3] for name in names if name in passes.raw)
