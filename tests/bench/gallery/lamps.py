# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A vase under three lamps, each baked alone, in mixes that no bake knew: python -m tests.bench.gallery lamps

Light adds up: ours is the sum of the atlases, each times a colour; the path-traced pictures have lamps so
tinted and dimmed.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.report.finished_bake import read_bake
from radtex_addon.report.gbuffer import Array, GBuffer
from radtex_addon.scene.lights.lamps import WORLD, each_light
from radtex_addon.settings.spec import BakeSpec, Layout

from .looking import (
    FILM_PIXELS,
    FRAMES,
    SUBJECT,
    Baked,
    Camera,
    Place,
    baked,
    empty_scene,
    filmed,
    lamp,
    principled,
    rendered,
)
from .row import Row, Use

SPEC = BakeSpec(layout=Layout.LAYERED)
BUCKETS = BakeSpec(denoise=True, texels=128, bucket=8, samples=8)
SKY = (0.05, 0.06, 0.08)
LAMPS: Mapping[str, tuple[Place, float, float]] = {  # white ones: where, watts, size
    "Key": ((-3.2, -2.6, 3.0), 240, 1.2),
    "Fill": ((3.6, -2.2, 0.6), 100, 2.5),
    "Rim": ((1.2, 3.4, 2.2), 320, 1.0),
}
_FLUTES, _TWIST = 9, 1.1
_AROUND, _ALONG = 216, 72  # faces

Colour = tuple[float, float, float]


@dataclass(frozen=True)
class Mix:
    """What each light is multiplied by, and a view that shows it."""

    lights: Mapping[str, Colour]
    camera: Camera


MIXES = {
    "evening": Mix(
        {"Key": (1.3, 0.55, 0.18), "Fill": (0.12, 0.2, 0.5), "Rim": (0.9, 0.25, 0.3), WORLD: (1, 1, 1)},
        Camera((-0.9, -3.9, 1.3)),
    ),
    "moonlight": Mix(
        {"Key": (0.0, 0.0, 0.0), "Fill": (0.15, 0.3, 0.9), "Rim": (0.5, 0.8, 1.4), WORLD: (0.6, 0.7, 1.2)},
        Camera((1.8, -3.7, 0.6)),
    ),
    "stage": Mix(
        {"Key": (0.1, 0.9, 0.7), "Fill": (1.6, 0.1, 0.8), "Rim": (1.2, 1.0, 0.2), WORLD: (0, 0, 0)},
        Camera((0.3, -3.4, 2.2)),
    ),
}


def scene(lights: Mapping[str, Colour] | None = None) -> None:
    """The vase and its lamps, white and as bright as they were baked, or times some `lights`."""
    tint = lights or {}
    empty_scene(_times(SKY, tint.get(WORLD, (1, 1, 1))))
    for name, (place, watts, size) in LAMPS.items():
        lamp(place, watts, size)
        data: Any = bpy.data.objects["Lamp"].data
        bpy.data.objects["Lamp"].name = name
        colour = tint.get(name, (1, 1, 1))
        brightest = max(*colour, 1e-6)
        data.energy, data.color = watts * brightest, [part / brightest for part in colour]
    glaze = principled("Glaze", (0.75, 0.73, 0.7), Roughness=0.42)
    mesh = bpy.data.meshes.new(SUBJECT)
    places, faces = _vase()
    mesh.from_pydata(places.tolist(), [], faces)
    mesh.polygons.foreach_set("use_smooth", [True] * len(faces))
    mesh.materials.append(glaze)
    context: Any = bpy.context
    context.scene.collection.objects.link(bpy.data.objects.new(SUBJECT, mesh))


def _times(one: Colour, other: Colour) -> Colour:
    red, green, blue = (a * b for a, b in zip(one, other, strict=True))
    return red, green, blue


def _vase() -> tuple[Floats, list[tuple[int, ...]]]:
    """Vertices (V, 3) and faces of a fluted, twisted vase, closed all over: outside, lip and inside."""
    along = np.linspace(0, 1, _ALONG + 1)[1:-1]
    outside = along < 0.62
    height = np.where(outside, along / 0.62, 1 - (along - 0.62) / 0.38 * 0.9)
    belly = 0.42 + 0.42 * np.sin(np.pi * (0.12 + 0.78 * height)) ** 1.5 + 0.25 * height**6
    radius = np.where(outside, belly, belly - 0.09) * np.clip(along / 0.04, 0.0, 1) ** 0.5
    radius *= np.clip((1 - along) / 0.05, 0.0, 1) ** 0.5
    angle = np.linspace(0, 2 * np.pi, _AROUND, endpoint=False)
    flutes = 1 + 0.075 * np.sin(np.pi * height)[:, None] * np.cos(
        _FLUTES * (angle + _TWIST * height[:, None])
    )
    wide = radius[:, None] * flutes
    rings = np.stack(
        [wide * np.cos(angle), wide * np.sin(angle), np.repeat(2 * height[:, None] - 1, _AROUND, axis=1)], -1
    )
    ends = [[0, 0, -1], [0, 0, 2 * height[-1] - 1]]
    places = np.concatenate([rings.reshape(-1, 3), ends])
    faces: list[tuple[int, ...]] = []
    last = len(along) - 1
    for step in range(_AROUND):
        after = (step + 1) % _AROUND
        faces.append((len(places) - 2, after, step))
        faces.append((last * _AROUND + step, last * _AROUND + after, len(places) - 1))
        faces += [
            (
                ring * _AROUND + step,
                ring * _AROUND + after,
                (ring + 1) * _AROUND + after,
                (ring + 1) * _AROUND + step,
            )
            for ring in range(last)
        ]
    return places, faces


def rows(spec: BakeSpec = SPEC, stills: bool = True) -> Iterator[Row]:
    """The gallery's rows: three mixes of the same atlases, from three new views; and a film through them."""
    with tempfile.TemporaryDirectory() as folder:
        sets = [_bakes(spec, Path(folder, "first"))]
        if stills:
            sets.append(_bakes(BUCKETS, Path(folder, "other")))
        for name, mix in MIXES.items() if stills else ():
            scene(mix.lights)
            truth = rendered(mix.camera)[..., :3]
            for which, bakes in enumerate(sets):
                seen = bakes[WORLD].seen(mix.camera)
                note = f"{len(bakes)} atlases, the last: {bakes[WORLD].words}"
                title = f"Lamps, {name}" + ", buckets" * which
                use = (Use.PICTURE, Use.TABLE)[which]
                yield Row(title, truth, seen.resolve(_mixed(bakes, mix, seen)), seen.eroded, note, use=use)
        bakes = sets[0]
        for mix in _changing(list(MIXES.values())):
            seen = bakes[WORLD].seen(mix.camera, FILM_PIXELS)
            scene(mix.lights)
            ours = seen.resolve(_mixed(bakes, mix, seen))
            yield Row("Lamps, film", filmed(mix.camera)[..., :3], ours, seen.eroded, use=Use.FILM)


def _bakes(spec: BakeSpec, folder: Path) -> dict[str, Baked]:
    """A bake of each light alone."""
    scene()
    context: Any = bpy.context
    lights = each_light(context.view_layer)
    return {one: baked(replace(spec, lights=(one,)), folder) for (one,) in lights}


def _mixed(bakes: Mapping[str, Baked], mix: Mix, seen: GBuffer) -> Array:
    """The sum of the atlases along a G-buffer's rays, (N, 3), each times its colour."""
    each = [read_bake(bake.sidecar).radiance(seen) * mix.lights[light] for light, bake in bakes.items()]
    total: Array = np.sum(each, axis=0)
    return total


def _changing(mixes: Sequence[Mix]) -> Iterator[Mix]:
    """From each mix to the next and back to the first, seen from where the first is seen."""
    steps = FRAMES // len(mixes)
    for before, after in pairwise([*mixes, mixes[0]]):
        for share in np.arange(steps) / steps:
            lights: dict[str, Colour] = {}
            for light in before.lights:
                ends = np.array(before.lights[light]), np.array(after.lights[light])
                red, green, blue = ((1 - share) * ends[0] + share * ends[1]).tolist()
                lights[light] = red, green, blue
            yield Mix(lights, mixes[0].camera)
