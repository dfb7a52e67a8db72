# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidecar of a bake in the shared layout: the keys of the plain sidecar, and an object "shared"."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..core.condensed import CondensedAtlas
from ..core.errors import BakeError, FormatError, ShapeError
from ..core.shared import LEAST_LEVEL, Axis, SharedAtlas
from .condensed_sidecar import CondensedFacts, shortest
from .condensed_sizes import CondensedSizes
from .json_reader import Facts, json_text
from .packing import (
    COLOUR,
    IRRADIANCE,
    LOBE_CHANNELS,
    SURROUNDINGS,
    layer_names,
    lobe_layer,
    surroundings_size,
)
from .sidecar import Sidecar

LAYOUT = "shared"
MOST_LEVELS = 32


@dataclass(frozen=True)
class SharedSidecar:
    """Facts about one bake in the shared layout.

    `bake` holds the facts of every layout: `width` x `height` texels of the irradiance and the lobes,
    `bucket` cells along a side of a lobe's buckets without borders, and the images as `layers`. `colour` is
    the colour image's width and height, `surroundings` the cells along a side of the sharpest of `levels`.
    `condensed` is None in the dense form, in which each texel has its own buckets.
    """

    bake: Sidecar
    colour: tuple[int, int]
    surroundings: int
    levels: int
    sharpest: float
    falloff: tuple[tuple[float, float, float], ...]
    lobes: tuple[Axis, ...]
    condensed: CondensedFacts | None = None

    @classmethod
    def of(
        cls, atlas: SharedAtlas | CondensedAtlas, bake: Sidecar, condensed: CondensedFacts | None = None
    ) -> SharedSidecar:
        """The facts about `atlas`, the rest from `bake`, whose `layers` are replaced.

        `condensed` are the additional facts of the condensed form.
        Raises ShapeError if atlas and `bake` differ in size, for two lobes of one axis, for more levels than
        files can have and for sizes that textures cannot have; BakeError if the falloff or `sharpest` is not
        finite.
        """
        lobes = tuple(lobe.axis for lobe in atlas.lobes)
        expected = (bake.height, bake.width)
        if atlas.irradiance.shape[:2] != expected:
            raise ShapeError(f"irradiance: expected shape {(*expected, 3)}, got {atlas.irradiance.shape}")
        if any(lobe.ends.shape[2] != bake.bucket for lobe in atlas.lobes):
            raise ShapeError(
                f"lobes: expected {bake.bucket} cells a side, got {atlas.lobes[0].ends.shape[2]}"
            )
        if len(set(lobes)) < len(lobes):
            raise ShapeError(f"lobes: expected each axis once, got {', '.join(lobes)}")
        if len(atlas.surroundings) > MOST_LEVELS:
            raise ShapeError(
                f"surroundings: expected at most {MOST_LEVELS} levels, got {len(atlas.surroundings)}"
            )
        if not np.isfinite(atlas.falloff).all() or not 0 < atlas.sharpest < np.inf:
            found = f'the falloff or sharpest blur of "{bake.object_name}"'
            raise BakeError(f"{found} is no finite number: nothing was written; bake it again")
        sidecar = cls(
            bake=replace(bake, layers=layer_names(lobes, condensed is not None)),
            colour=(atlas.colour.shape[1], atlas.colour.shape[0]),
            surroundings=len(atlas.surroundings[0]),
            levels=len(atlas.surroundings),
            sharpest=float(atlas.sharpest),
            falloff=tuple((shortest(r), shortest(g), shortest(b)) for r, g, b in atlas.falloff),
            lobes=lobes,
            condensed=condensed,
        )
        if misfit := sidecar._misfit():
            raise ShapeError(f'the textures of "{bake.object_name}" would have {misfit}')
        return sidecar

    @property
    def shapes(self) -> dict[str, tuple[int, int, int]]:
        """Each layer's width, height and channels; textures of a condensed bake without padding to blocks."""
        if self.condensed is not None:
            return self._sizes(self.condensed).shapes(self.condensed.columns)
        bake, side = self.bake, self.bake.bucket + 2
        return {
            COLOUR: (*self.colour, 3),
            IRRADIANCE: (bake.width, bake.height, 3),
            SURROUNDINGS: (*surroundings_size(self.surroundings, self.levels), 3),
        } | {
            lobe_layer(axis, part): (bake.width * side, bake.height * side, channels)
            for axis in self.lobes
            for part, channels in LOBE_CHANNELS.items()
        }

    def to_json(self) -> str:
        """The sidecar's JSON, in ASCII and with a newline at its end."""
        shared = {
            "colour": list(self.colour),
            "surroundings": self.surroundings,
            "levels": self.levels,
            "sharpest": self.sharpest,
            "falloff": [list(point) for point in self.falloff],
            "lobes": [axis.value for axis in self.lobes],
        }
        if self.condensed is not None:
            shared["condensed"] = self.condensed.facts()
        return json_text(self.bake.facts(LAYOUT) | {"shared": shared})

    @classmethod
    def from_json(cls, text: str, source: str = "the sidecar") -> SharedSidecar:
        """Read the text of `to_json`; `source` names it in errors. Unknown keys are ignored.

        Raises FormatError if it is no JSON object, for another version or layout, a missing or mistyped key.
        """
        return cls.from_facts(Facts.parse(text, source))

    @classmethod
    def from_facts(cls, facts: Facts) -> SharedSidecar:
        """Read the JSON of `to_json`. Raises FormatError as `from_json` does."""
        bake = Sidecar.from_facts(facts, LAYOUT)
        shared = facts.inner("shared")
        lobes = tuple(Axis(name) for name in shared.choices("lobes", tuple(Axis)))
        condensed = "condensed" in shared.values
        layers = layer_names(lobes, condensed)
        facts.constant("layers", list(layers))
        sidecar = cls(
            bake=bake,
            colour=shared.size("colour"),
            surroundings=shared.whole_number("surroundings", LEAST_LEVEL),
            levels=shared.whole_number("levels", 1, MOST_LEVELS),
            sharpest=shared.positive("sharpest"),
            falloff=shared.colours("falloff"),
            lobes=lobes,
            condensed=CondensedFacts.from_facts(shared, lobes, layers) if condensed else None,
        )
        if misfit := sidecar._misfit():
            raise FormatError(f'{facts.source}, in "shared", has sizes that no textures have: {misfit}')
        return sidecar

    def _misfit(self) -> str | None:
        """Why textures of these sizes are impossible; None if they are possible."""
        if self.condensed is None:
            return None
        return self._sizes(self.condensed).misfit(self.condensed.columns)

    def _sizes(self, condensed: CondensedFacts) -> CondensedSizes:
        return CondensedSizes(
            width=self.bake.width,
            height=self.bake.height,
            bucket=self.bake.bucket,
            colour=self.colour,
            surroundings=self.surroundings,
            levels=self.levels,
            clusters={axis: tiles.clusters for axis, tiles in condensed.lobes.items()},
            rank=condensed.rank,
        )
