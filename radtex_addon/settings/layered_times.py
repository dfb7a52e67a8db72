# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How long the renders of a layered bake typically take, for estimates and for even progress.

Seconds of the processor, measured of the demo's head, of a glossy floor among lamps, of a glass torus, and of
an asset of several parts with textures, at 64 and 96 texels.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .rays import OWN_SIDE, LayeredRays, own_side

# Seconds of a texel.
_MAPS = 1e-4
_GLOSS = 1.7e-4  # roughness, of an object on which it varies
_EXITS = 1.3e-3  # of an object that lets light through
_MISLED = 8.6e-4  # OWN_SIDE² mirror rays that the pictures of the surroundings would show wrongly
# Seconds of a path of a texel.
_LIGHT, _ENDS, _OWN = 4.5e-6, 4.2e-6, 1.4e-6
_MORE = 0.5  # of the paths of light, on objects of which a part is lit noisily
_AROUND = 9.0  # seconds of the pictures of the surroundings


@dataclass(frozen=True)
class LayeredTimes:
    """Typical seconds of the renders in the stages "capture" and "surroundings", in their order.

    A `surroundings` of 1 are pictures as wide as in a bake.
    """

    texels: int
    rays: LayeredRays
    surroundings: float = 1.0

    @property
    def capture(self) -> Mapping[str, float]:
        """Maps of the material, ends of paths, light, and what the object shows of itself."""
        each = {
            "maps": _MAPS + _GLOSS,
            "ends": _ENDS * self.rays.ends**2,
            "light": _LIGHT * self.rays.light**2,
            "more light": _MORE * _LIGHT * self.rays.light**2,
            "own": _OWN * own_side(self.texels) ** 2,
        }
        return {name: self.texels * seconds for name, seconds in each.items()}

    @property
    def around(self) -> Mapping[str, float]:
        """Pictures of the surroundings, and which mirror rays they would show wrongly."""
        pictures = _AROUND * (0.045 + 0.955 * self.surroundings**2)
        rays = (own_side(self.texels) / OWN_SIDE) ** 2
        return {"pictures": pictures, "misled": 0.3 + self.texels * _MISLED * rays}

    @property
    def around_clear(self) -> Mapping[str, float]:
        """The same of an object that lets light through, with the rays that leave it."""
        pictures, misled = self.around.items()
        return dict([pictures, ("exits", self.texels * _EXITS), misled])
