# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Ambient occlusion under a sky of one colour, bent normals under two: python -m tests.bench.gallery ao

The path-traced pictures have no light but the sky's, and no second bounce, for `ao` knows of none.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.frame import normalised
from radtex_addon.core.sampler import Filter, sample
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.report.gbuffer import GBuffer
from radtex_addon.report.metrics import Picture
from radtex_addon.scene.nodes import open_world
from radtex_addon.settings.spec import BakeSpec, Kind
from tests.blender import stage

from .looking import FILM_PIXELS, SUBJECT, Baked, Camera, added, baked, empty_scene, filmed, rendered
from .row import Row, Use

SPEC = BakeSpec(kind=Kind.AO, texels=128, bucket=8, samples=8)
WHITE = 0.8
CAMERAS = {
    "low": Camera((0.5, -6.4, 2.6), (0.0, 0.3, 0.5), 45.0),
    "high": Camera((2.2, -4.6, 5.4), (0.0, 0.2, 0.4), 45.0),
}


@dataclass(frozen=True)
class Sky:
    """A sky whose radiance in the unit direction d is `mean` + d.x `across`, of red, green and blue."""

    mean: tuple[float, float, float]
    across: tuple[float, float, float]

    def radiance(self, x: Floats) -> Floats:
        """Of directions by their x, (K,), along which it changes: (K, 3)."""
        light: Floats = np.array(self.mean) + x[:, None] * np.array(self.across)
        return light


SKIES = {
    "a sky of one colour": Sky((1.0, 1.0, 1.0), (0.0, 0.0, 0.0)),
    "a sky of two colours": Sky((0.75, 0.65, 0.75), (-0.7, -0.05, 0.65)),
}


def scene() -> None:
    """White things in a corner of two walls, all one mesh, the subject."""
    made = empty_scene()
    made.cycles.max_bounces = 0
    white = stage.material("White", "ShaderNodeBsdfDiffuse", Color=(WHITE, WHITE, WHITE, 1))
    parts = [
        added("grid", SUBJECT, white, size=4, x_subdivisions=1, y_subdivisions=1),
        added("cube", "Left", white, size=1, location=(-1.9, 0, 0.8), scale=(0.2, 4, 1.6)),
        added("cube", "Back", white, size=1, location=(0, 1.9, 0.8), scale=(4, 0.2, 1.6)),
        added("cube", "Step", white, size=1, location=(0.9, 1.3, 0.2), scale=(1.6, 1.0, 0.4)),
        added("torus", "Ring", white, location=(1.0, -0.6, 0.18), major_radius=0.55, minor_radius=0.18),
        added("uv_sphere", "Ball", white, radius=0.4, location=(1.1, 1.2, 0.79)),
        added("cylinder", "Column", white, radius=0.25, depth=1.4, location=(-1.1, 1.1, 0.7)),
        added("monkey", "Head", white, size=1.5, location=(-0.5, -0.3, 0.58), rotation=(-0.6, 0, -0.2)),
    ]
    head = parts[-1].modifiers.new("Subdivision", "SUBSURF")
    head.levels = head.render_levels = 2
    bpy.ops.object.modifier_apply(modifier=head.name)
    for part in parts:
        part.select_set(True)
    cast(Any, bpy.context.view_layer).objects.active = parts[0]
    bpy.ops.object.join()


def under(sky: Sky) -> None:
    """Put the open scene under a sky."""
    cast(Any, bpy.context.scene).world, build = open_world("Sky")
    x, _, _ = build.separate(build.node("ShaderNodeTexCoord").outputs["Generated"])
    radiance = build.vector("MULTIPLY_ADD", build.combine(x, x, x), sky.across, sky.mean)
    background = build.node("ShaderNodeBackground", radiance, 1.0)
    build.node("ShaderNodeOutputWorld", background.outputs[0])


def lit(bake: Baked, seen: GBuffer, sky: Sky, bent: bool = True) -> Floats:
    """The light (hits, 3) that the subject sends back; without `bent`, by the plain normal.

    What is open is taken for a cone around the bent normal. It has the half angle a, sin² a = visibility, for
    cones by the cosine; and their mean direction, so weighed, is 2/3 (1 - cos³ a) / sin² a long.
    """
    pixels, facts = read_buckets(bake.sidecar)
    layout, hit = AtlasLayout(facts.width, facts.height, 1), seen.hit
    upright = np.broadcast_to([0.0, 0.0, 1.0], (int(hit.sum()), 3))
    found = sample(pixels.astype(np.float64), layout, seen.uv[hit], upright, Filter.QUADRILINEAR)
    local, visible = (normalised(found[:, :3]) if bent else upright), np.clip(found[:, 3], 1e-6, 1)
    axes = seen.tangent[hit], seen.bitangent[hit], seen.normal[hit]
    x = sum(local[:, k] * axis[:, 0] for k, axis in enumerate(axes))
    length = 2 / 3 * (1 - (1 - visible) ** 1.5) / visible
    return WHITE * visible[:, None] * sky.radiance(length * x)


def rows(spec: BakeSpec = SPEC, stills: bool = True) -> Iterator[Row]:
    """The gallery's rows: two skies, each from two views, of one bake that knows of neither; and a film."""
    scene()
    with tempfile.TemporaryDirectory() as folder:
        bake = baked(spec, Path(folder))
        for title, sky in SKIES.items() if stills else ():
            under(sky)
            for name, camera in CAMERAS.items():
                seen, truth = bake.seen(camera), rendered(camera, samples=128)
                ours, plain = (_shown(bake, seen, sky, bent) for bent in (True, False))
                view = f"Ambient occlusion, {title}, {name}"
                unbent = Row(view, truth[..., :3], plain, seen.eroded).psnr
                note = f"{unbent:.1f} dB by the plain normal; {bake.words}" if any(sky.across) else bake.words
                yield Row(view, truth[..., :3], ours, seen.eroded, note)
        sky = SKIES["a sky of two colours"]
        under(sky)
        for camera in CAMERAS["low"].swung(30):
            seen = bake.seen(camera, FILM_PIXELS)
            ours = _shown(bake, seen, sky)
            yield Row("Ambient occlusion, film", filmed(camera)[..., :3], ours, seen.eroded, use=Use.FILM)


def _shown(bake: Baked, seen: GBuffer, sky: Sky, bent: bool = True) -> Picture:
    return seen.resolve(seen.spread(lit(bake, seen, sky, bent)))
