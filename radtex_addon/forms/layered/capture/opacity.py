# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A surface's alpha, and captures of it divided by that: what it would show if it were opaque."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import bpy
import numpy as np

from ....bake.light_samples import EndSamples, LightSamples
from ....bake.piece_store import NO_STORE, Arrays, PieceStore
from ....bake.plan import CapturePlan
from ....core import large_arrays
from ....core.arrays import Floats, Ints
from ....core.errors import InputError
from ....core.sampler import bilinear
from ....cycles.path_ends import Body
from ....scene.scratch import scene_copied
from ..fit.texel_maps import texel_middles
from ..samples import LayeredSamples
from .material_maps import capture_alpha
from .surface_alone import Clear

_ROWS = 1 << 12  # texels whose samples are in hand at once
_OPAQUE = 0.998  # alpha, from which on all of it counts as 1
_CUT = 0.05  # alpha, below which a texel's own samples tell too little


@dataclass(frozen=True, eq=False)
class Opacity:
    """Alpha along the normal: `fine` (H', W', 1), a map, gutter filled, None where it is 1 everywhere.

    `coarse` (K,) is that of texels, by their flat indices `texel` (K,); `rays` are what both cost.
    """

    fine: Floats | None
    coarse: Floats
    texel: Ints
    rays: int

    @property
    def cut_out(self) -> Ints:
        """Flat indices of texels that show next to nothing, of which nothing needs to be captured."""
        return self.texel[self.coarse < _CUT]

    def bare(self, capture: LayeredSamples) -> LayeredSamples:
        """A capture without the texels that are cut out, divided by alpha but for its fine maps."""
        if self.fine is None:
            return capture
        plan = capture.light.plan
        alpha = self.coarse[np.searchsorted(self.texel, plan.texel)][:, None]
        image = plan.placed(alpha, gutter=True)
        coarse = {
            name: kept / image if name in ("diffuse", "glossy", "emission") else kept
            for name, kept in capture.coarse.items()
        }
        exits = capture.exits
        if exits is not None:
            exits = replace(exits, weight=exits.weight / bilinear(image, texel_middles(exits.plan)))
        return replace(
            capture,
            light=_bare_light(capture.light, alpha),
            alone=None if capture.alone is None else _bare_ends(capture.alone, alpha),
            coarse=coarse,
            exits=exits,
            alpha=self.fine,
        )


def _bare_light(light: LightSamples, alpha: Floats) -> LightSamples:
    lobes = (light.diffuse, light.mirrored, light.through)
    diffuse, mirrored, through = (_limited(lobe, alpha) for lobe in lobes)
    emitted = None if light.emitted is None else _limited(light.emitted, alpha)
    return replace(
        light,
        colour=light.colour / alpha,
        diffuse=diffuse,
        mirrored=mirrored,
        through=through,
        emitted=emitted,
    )


def _bare_ends(ends: EndSamples, alpha: Floats) -> EndSamples:
    mirrored, through = (_limited(weight, alpha) for weight in (ends.mirrored_weight, ends.through_weight))
    return replace(ends, mirrored_weight=mirrored, through_weight=through)


def _limited(values: Floats, alpha: Floats) -> Floats:
    """Values (K, S, 3) over alpha (K, 1), as half floats."""

    def limited(some: slice) -> Floats:
        found: Floats = np.minimum(values[some] / alpha[some, None], 65504).astype(np.float16)
        return found

    return large_arrays.from_blocks(len(values), limited, _ROWS)


def find_opacity(
    scratch: bpy.types.Scene,
    bodies: Sequence[Body],
    clear: Clear,
    coarse: CapturePlan,
    fine: CapturePlan,
    seed: int,
    folder: Path,
    store: PieceStore = NO_STORE,
) -> Opacity:
    """The alpha at two plans of one cell each, as `capture_alpha` finds it.

    Raises InputError where all of it is cut out: there is nothing to capture.
    """

    def capture() -> Arrays:
        image = find_alpha_map(scratch, bodies, clear, fine, seed, folder)
        if image is None:
            return {}
        with scene_copied(scratch) as copy:
            return {"fine": image, "coarse": capture_alpha(copy, bodies, clear, coarse, seed, folder)}

    kept = store.get_or_make("alpha", capture) if clear else {}
    if not kept:
        return Opacity(None, np.ones(len(coarse.texel), dtype=np.float32), coarse.texel, 0)
    image, found = kept["fine"], kept["coarse"]
    if found.max() < _CUT:
        names = ", ".join(f"'{body.original.name}'" for body in bodies)
        raise InputError(
            f"object {names} is clear to the camera everywhere, by the alpha or Transparent shaders "
            "of its materials: let them show something, or bake another object"
        )
    return Opacity(image, found, coarse.texel, len(coarse.texel) + len(fine.texel))


def find_alpha_map(
    scratch: bpy.types.Scene,
    bodies: Sequence[Body],
    clear: Clear,
    plan: CapturePlan,
    seed: int,
    folder: Path,
) -> Floats | None:
    """The alpha as a map (H, W, 1), gutter filled; None where it is 1 everywhere. See `capture_alpha`."""
    if not clear:
        return None
    with scene_copied(scratch) as copy:
        alpha = capture_alpha(copy, bodies, clear, plan, seed, folder)
    if alpha.min() > _OPAQUE:
        return None
    image: Floats = plan.placed(alpha[:, None], gutter=True)
    return image
