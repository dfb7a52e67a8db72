# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ten thousand lookups of random atlases of kind `transfer`, and what the reference answers."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.frame import orthonormal_frame, to_frame
from radtex_addon.formats.transfer_files import with_views
from tests.lookups import COUNT, LAYOUT, Lookups, random_lookups
from tests.reference.relighting import relight, sample_transfer

VIEWS = 3
IRRADIANCE = (2.0, 1.0, 0.5)
WORST = 2e-3  # that a shader's answer may be off, relatively


class Way(IntEnum):
    """What is asked: the lookup, of one view or of all around, or the light of a sun or of a lamp."""

    LOOKUP = 0
    SUN = 1
    POINT = 2
    AROUND = 3


@dataclass(frozen=True)
class Question:
    """Lookups of `atlas`, half floats of `views` x `views` views, with lights at `light` (K, 3) float32."""

    way: Way
    atlas: Floats
    lookups: Lookups
    light: Floats

    @property
    def views(self) -> int:
        return VIEWS if self.way is Way.AROUND else 1

    @property
    def answers(self) -> Floats:
        """The reference's, (K, 4) float64; suns and lamps have no alpha, here 1."""
        stored, uv = self.atlas.astype(float), self.lookups.uv.astype(float)
        direction = to_frame(self.light.astype(float), *_frame(self.lookups))
        if self.way in (Way.LOOKUP, Way.AROUND):
            return sample_transfer(stored, LAYOUT, uv, direction, self.lookups.incidence, self.views)
        squared = (self.light.astype(float) ** 2).sum(axis=1, keepdims=True)
        irradiance = np.array(IRRADIANCE) / (squared if self.way is Way.POINT else 1)
        shown = relight(stored, LAYOUT, uv, [(direction, irradiance)])
        return np.concatenate([shown, np.ones((len(shown), 1))], axis=1)


def questions() -> list[Question]:
    """One of each way."""
    lookups, light = random_lookups(), random_lights()
    return [Question(way, random_transfer(VIEWS if way is Way.AROUND else 1), lookups, light) for way in Way]


def random_transfer(views: int = 1, seed: int = 1) -> Floats:
    """An atlas of LAYOUT, all cells of all views different, float16."""
    random, layout = np.random.default_rng(seed), with_views(LAYOUT, views)
    image = np.exp(random.uniform(np.log(0.05), np.log(20), (layout.pixel_height, layout.pixel_width, 4)))
    image[..., 3] = random.uniform(0.05, 1, image.shape[:2])
    return image.astype(np.float16)


def random_lights(seed: int = 8) -> Floats:
    """To lights all around, (K, 3) float32, of lengths from 0.5 to 3."""
    random = np.random.default_rng(seed)
    away = random.normal(size=(COUNT, 3))
    away *= random.uniform(0.5, 3, (COUNT, 1)) / np.linalg.norm(away, axis=1, keepdims=True)
    return away.astype(np.float32)


def _frame(lookups: Lookups) -> tuple[Floats, Floats, Floats]:
    return orthonormal_frame(lookups.normal.astype(float), lookups.tangent.astype(float), lookups.sign)
