# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a surface looks like before any light falls on it: colours, normals, alpha; one ray a texel.

Where alpha depends on the angle, nine rays a texel, of which the means are kept, weighted by N.V.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ....bake.plan import CapturePlan
from ....core import large_arrays
from ....core.arrays import Floats
from ....core.hemisphere import square_to_direction
from ....cycles.capture_settings import first_hit_only
from ....cycles.passes import attributes_of, colour_of, light_of
from ....cycles.path_ends import Body, path_ends
from ....cycles.portal import Aim, PortalCapture
from ....cycles.sampling import straight_shifts, tiles_of
from ....scene.checks.camera_checks import Outputs, nodes_asked
from ....settings.spec import Kind
from .own_rays import dark_world
from .surface_alone import Clear

_COLOURS = ("diffuse", "glossy")
_MOST = 65504  # of half floats, as the samples of light
_SLANTS = 3  # rays along a side of the hemisphere
_ANGLES: Outputs = {  # what depends on the angle
    "LAYER_WEIGHT": frozenset({"Fresnel", "Facing"}),
    "FRESNEL": frozenset({"Fac", "Factor"}),
    "NEW_GEOMETRY": frozenset({"Incoming"}),
}


def depends_on_angle(materials: Iterable[bpy.types.Material]) -> bool:
    """Whether any of the materials has nodes whose output depends on the angle."""
    return any(nodes_asked(material, _ANGLES) for material in materials)


def _looks(plan: CapturePlan, slanted: bool) -> tuple[CapturePlan, Aim, Floats]:
    """A plan of the rays, where they aim in its cells, and what each counts for, (rays, 1)."""
    if slanted:
        plan = replace(plan, layout=replace(plan.layout, bucket=_SLANTS))
    aim = Aim(straight_shifts(len(plan.texel)))
    cosine = square_to_direction(aim.squares(plan.layout.bucket)[:1][0])[..., 2:]
    return plan, aim, (cosine / cosine.sum()).astype(np.float32)


def capture_maps(
    scene: bpy.types.Scene,
    plan: CapturePlan,
    seed: int,
    folder: Path,
    slanted: bool = False,
    glows: bool = False,
) -> dict[str, Floats]:
    """The colours "diffuse" and "glossy" along the normal, and the shading "normal" in world space.

    Where the surface `glows`, "emission", too, the light that it emits along the normal. Of a plan of one
    cell a bucket, each (H, W, 3), gutter filled. `slanted`: means over the hemisphere.
    Raises BakeError where Cycles fails.
    """
    looks, aim, weight = _looks(plan, slanted)
    lights = ("normal", "emission") if glows else ("normal",)
    wanted = [attribute for name in (*_COLOURS, *lights) for attribute in attributes_of(name)]
    capture = PortalCapture(scene, looks, Kind.RADIANCE, 1, seed, folder, replace(aim, passes=tuple(wanted)))
    first_hit_only(scene)
    found: dict[str, list[Floats]] = {name: [] for name in (*_COLOURS, *lights)}

    def mean(seen: Floats) -> Floats:
        means: Floats = (seen.reshape(-1, len(weight), 3) * weight).sum(axis=1)
        return means

    for tile in tiles_of(looks):
        passes = capture.render_passes(tile)
        for name in _COLOURS:
            found[name].append(large_arrays.stowed(mean(colour_of(passes, name))))
        found["normal"].append(large_arrays.stowed(mean(light_of(passes, "normal"))))
        if glows:
            emitted = np.clip(np.nan_to_num(light_of(passes, "emission"), nan=0.0), 0, _MOST)
            found["emission"].append(large_arrays.stowed(mean(emitted)))
    whole = {name: large_arrays.concatenated(found.pop(name)) for name in list(found)}
    return {name: plan.placed(whole.pop(name), gutter=True) for name in list(whole)}


def capture_alpha(
    scene: bpy.types.Scene,
    bodies: Sequence[Body],
    clear: Clear,
    plan: CapturePlan,
    seed: int,
    folder: Path,
) -> Floats:
    """How much a surface hides of what is behind it, of a plan of one cell: (K,).

    It is that along the normal, but the mean over the hemisphere for materials that depend on the angle.
    The `bodies` have materials as in `surface_alone`, which gave those that are `clear`. Of coloured
    transparency it is the mean over the channels. Raises BakeError where Cycles fails.
    """
    looks, aim, weight = _looks(plan, depends_on_angle(clear))
    with path_ends(scene, bodies, (), np.zeros(3, np.float32)) as ends:
        for body, copy in zip(bodies, ends.copies, strict=True):
            for index, material in enumerate(body.mesh.materials):
                if material is not None and material in clear:
                    cast(Any, copy.data).materials[index] = clear[material]
        ends.scene.world = dark_world()
        capture = PortalCapture(ends.scene, looks, Kind.RADIANCE, 1, seed, folder, aim)
        first_hit_only(ends.scene)
        seen = [
            capture.render_passes(tile).raw_whole[..., :3].reshape(-1, 3).mean(axis=1)
            for tile in tiles_of(looks)
        ]
    through = np.concatenate(seen).reshape(-1, len(weight)) @ weight[:, 0]
    alpha: Floats = 1 - np.clip(through, 0, 1)
    return alpha.astype(np.float32)
