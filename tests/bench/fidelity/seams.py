# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How much worse are baked objects within a texel of a seam than elsewhere?

    python -m tests.bench.fidelity.seams --scenes metal_20,ceramic --texels 64 --out DIR

A seam is an island's border across which the surface goes on: no sharp edge, the same material. For each
scene: the root of the mean squared error, of what a display shows, of pixels within a texel of a seam, that
of pixels two texels from any border, and their ratio. Seams often lie where surfaces are hard to bake, in
folds and clefts. So the same pixels are looked at in a bake on xatlas's unwrap, if they are two texels from
its borders, too: the ratio there, and how many times larger ours is. Last, the step across seams: by how
much what a display shows differs between lookups on both sides of a seam, at one place and from one
viewpoint. DIR gets a picture of each scene's worst place at a seam, path traced and ours, at 400 %.
"""

from __future__ import annotations

import argparse
import math
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from PIL import Image

from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats, Ints
from radtex_addon.core.fragments import Fragments
from radtex_addon.core.frame import normalised, orthonormal_frame
from radtex_addon.core.gutter import nearest_covered
from radtex_addon.core.seams import Seams
from radtex_addon.core.surface import SurfaceMesh
from radtex_addon.forms.layered.fit.buckets import ALL_PARTS
from radtex_addon.forms.layered.fit.fitting import fit_layered
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas, sample_layered
from radtex_addon.report.gbuffer import BakedSurface, GBuffer
from radtex_addon.report.metrics import Mask, Picture, display
from radtex_addon.settings.spec import BakeSpec, Layout, Unwrap

from .choice import add_scene_options, chosen_scenes
from .composite import seen_light
from .layered.staged import Staged, capture_staged
from .method import Baked
from .methods.layered import baked_of
from .references import SUBSAMPLES, View, views
from .scenes import Stage

_FINE = 8  # places along a texel's side at which distances to seams are known
_ALONG = 4  # places along an edge where both sides of a seam are compared
_FACING = 0.2  # least cosine of the angle to the viewer there
_AROUND, _ENLARGED = 40, 4  # pixels of a picture's side, and times


@dataclass(frozen=True, eq=False)
class Borders:
    """Distances in texels from all places of the atlas to the nearest seam, and to any border: (h, w)."""

    seam: Floats
    any: Floats

    @classmethod
    def of(cls, surface: SurfaceMesh, width: int, height: int) -> Borders:
        seams = Seams.of(surface)
        flat = surface.uv.reshape(-1, 2).astype(np.float64)
        border = np.flatnonzero((seams.beyond < 0) | seams.seam)
        ends = np.stack([flat[border], flat[following(border)]], axis=1)
        size = width * _FINE, height * _FINE
        return cls(_distance(ends[seams.seam[border]], size), _distance(ends, size))

    def at(self, distances: Floats, uv: Floats) -> Floats:
        """The distances at uv (N, 2): (N,)."""
        height, width = distances.shape
        i, j = (np.clip((uv[:, k] * size).astype(int), 0, size - 1) for k, size in enumerate((width, height)))
        found: Floats = distances[j, i]
        return found


def following(edge: Ints) -> Ints:
    """Numbers of the corners at which edges end, which are called by those at which they begin."""
    return 3 * (edge // 3) + (edge + 1) % 3


def _distance(ends: Floats, size: tuple[int, int]) -> Floats:
    """Texels from each of width x height places to the nearest of the segments (E, 2, 2) in UV."""
    width, height = size
    marked = np.zeros((height, width), dtype=bool)
    if not len(ends):
        return np.full((height, width), np.inf)
    scaled = ends * size
    steps = np.ceil(np.abs(scaled[:, 1] - scaled[:, 0]).max(axis=1) * 2).astype(int) + 1
    edge = np.repeat(np.arange(len(ends)), steps)
    along = (np.arange(len(edge)) - np.repeat(np.cumsum(steps) - steps, steps)) / np.maximum(
        steps[edge] - 1, 1
    )
    points = scaled[edge, 0] + along[:, None] * (scaled[edge, 1] - scaled[edge, 0])
    i, j = (np.clip(points[:, k].astype(int), 0, size[k] - 1) for k in (0, 1))
    marked[j, i] = True
    row, column = nearest_covered(marked)
    found: Floats = np.hypot(row - np.arange(height)[:, None], column - np.arange(width)) / _FINE
    return found


def main() -> None:
    """Bake, look, measure, print."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.fidelity.seams",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_scene_options(parser)
    parser.add_argument("--texels", type=int, default=64, help="along each side of the atlas (64)")
    parser.add_argument("--samples", type=int, default=16, help="as of bake.py --samples (16)")
    parser.add_argument("--out", type=Path, required=True, help="folder for pictures")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    print(
        "| scene | pixels at seams | error there | elsewhere | ratio | without seams | larger | step |",
        flush=True,
    )
    print("|---|---|---|---|---|---|---|---|")
    for name, build in chosen_scenes(options).items():
        looked_from = views(build(), options.quick, options.tuning)
        spec = BakeSpec(layout=Layout.LAYERED, texels=options.texels, samples=options.samples)
        seen, step = _baked_and_seen(build, spec, looked_from)
        others, _ = _baked_and_seen(build, replace(spec, unwrap=Unwrap.XATLAS), looked_from)
        print(f"| {name} | {_row(seen, others)} | {step:.4f} |", flush=True)
        worst = max(seen, key=lambda one: one.worst)
        if worst.worst > 0:
            worst.enlarged().save(options.out / f"seam-{name}.png")


def _baked_and_seen(
    build: Callable[[], Stage], spec: BakeSpec, looked_from: list[View]
) -> tuple[list[_Seen], float]:
    """What is seen of a bake, and the step across its seams."""
    with tempfile.TemporaryDirectory() as folder:
        staged = capture_staged(build(), spec, Path(folder))
        atlas = finished(fit_layered(staged.captured.capture, ALL_PARTS))
        baked = baked_of(atlas, staged)
        seen = [_Seen.of(baked, staged, view) for view in looked_from]
        return seen, _step(atlas, staged.prepared.surface, looked_from)


def _step(atlas: LayeredAtlas, surface: SurfaceMesh, looked_from: list[View]) -> float:
    """The root of the mean squared difference, of what a display shows, between both sides of all seams."""
    seams = Seams.of(surface)
    one = np.flatnonzero(seams.seam)
    one = one[one < seams.beyond[one]]
    other = seams.beyond[one]
    spot = surface.corner_position.reshape(-1, 3).astype(np.float64)
    turned = np.sum((spot[one] - spot[other]) ** 2, axis=1) > np.sum(
        (spot[one] - spot[following(other)]) ** 2, axis=1
    )
    along = np.random.default_rng(1).random((_ALONG, len(one)))
    length = np.tile(np.linalg.norm(spot[following(one)] - spot[one], axis=1), _ALONG)
    squares, weights = 0.0, 0.0
    for view in looked_from:
        sides = (
            _fragments(surface, edge, share, view.rays.origin)
            for edge, share in ((one, along), (other, np.where(turned, 1 - along, along)))
        )
        mine, theirs = ((display(sample_layered(atlas, at).astype(np.float64)), at) for at in sides)
        faces = np.sum(mine[1].viewer * mine[1].normal, axis=1) > _FACING
        difference = ((mine[0] - theirs[0]) ** 2).mean(axis=1)
        squares += float(np.sum((difference * length)[faces]))
        weights += float(np.sum(length[faces]))
    return math.sqrt(squares / weights) if weights else 0.0


def _fragments(surface: SurfaceMesh, edge: Ints, along: Floats, viewer: Floats) -> Fragments:
    """Places `along` (n, E), 0 to 1, the edges (E,), looked at from a place (3,)."""
    share = along[..., None]

    def mixed(corners: Floats, width: int) -> Floats:
        flat = corners.reshape(-1, width).astype(np.float64)
        found: Floats = flat[edge] + share * (flat[following(edge)] - flat[edge])
        return found.reshape(-1, width)

    position = mixed(surface.corner_position, 3)
    sign = np.where(mixed(surface.sign, 1)[:, 0] < 0, -1.0, 1.0)
    tangent, bitangent, normal = orthonormal_frame(
        normalised(mixed(surface.normal, 3)), mixed(surface.tangent, 3), sign
    )
    fields = mixed(surface.uv, 2), normal, normalised(viewer - position), position
    uv, normal, towards, position = (field.astype(np.float32) for field in fields)
    material = np.tile(surface.material_numbers[edge // 3], len(along))
    return Fragments(
        uv, normal, towards, position, material, tangent.astype(np.float32), bitangent.astype(np.float32)
    )


@dataclass(frozen=True, eq=False)
class _Seen:
    """A view: path traced, ours, and which pixels lie at a seam and which far from all (pixels, pixels)."""

    reference: Picture
    ours: Picture
    at_seam: Mask
    elsewhere: Mask

    @classmethod
    def of(cls, baked: Baked, staged: Staged, view: View) -> _Seen:
        surface = BakedSurface(baked.mesh, baked.matrix_world, baked.uv_layer)
        borders = Borders.of(staged.prepared.surface, staged.prepared.width, staged.prepared.height)
        buffer = surface.gbuffer(view.rays, view.blocked)
        light = seen_light(baked, surface, view.rays, view.blocked, buffer, view.behind)
        return cls(view.reference, buffer.resolve(light), *_masks(borders, buffer))

    @cached_property
    def error(self) -> Floats:
        """Squared errors of display values (pixels, pixels)."""
        found: Floats = ((display(self.ours) - display(self.reference)) ** 2).mean(axis=-1)
        return found

    @property
    def worst(self) -> float:
        """The largest error at a seam."""
        return float(self.error[self.at_seam].max(initial=0))

    def enlarged(self) -> Image.Image:
        """What lies around the worst place at a seam in both pictures, side by side."""
        place = np.unravel_index(int(np.where(self.at_seam, self.error, -1).argmax()), self.error.shape)
        window = tuple(
            slice(start, start + _AROUND)
            for start in (
                min(max(int(at) - _AROUND // 2, 0), size - _AROUND)
                for at, size in zip(place, self.error.shape, strict=True)
            )
        )
        both = np.concatenate([display(picture)[window] for picture in (self.reference, self.ours)], axis=1)
        picture = Image.fromarray(np.round(255 * both).astype(np.uint8))
        return picture.resize((2 * _AROUND * _ENLARGED, _AROUND * _ENLARGED), Image.Resampling.NEAREST)


def _row(ours: list[_Seen], others: list[_Seen]) -> str:
    count = sum(int(one.at_seam.sum()) for one in ours)
    if not count:
        return "0 | | | | | "
    everywhere = [(one.error, one.at_seam, one.elsewhere) for one in ours]
    there, elsewhere = _errors(everywhere)
    both = [one.at_seam & other.elsewhere for one, other in zip(ours, others, strict=True)]
    mine = _errors([(one.error, mask, one.elsewhere) for one, mask in zip(ours, both, strict=True)])
    plain = _errors([(one.error, mask, one.elsewhere) for one, mask in zip(others, both, strict=True)])
    without = plain[0] / plain[1]
    return (
        f"{count} | {there:.4f} | {elsewhere:.4f} | {there / elsewhere:.2f} | {without:.2f} | "
        f"{mine[0] / mine[1] / without:.2f}"
    )


def _errors(views: list[tuple[Floats, Mask, Mask]]) -> tuple[float, float]:
    """Roots of the mean squared errors within two masks, over all views."""
    near = np.concatenate([error[there] for error, there, _ in views])
    far = np.concatenate([error[elsewhere] for error, _, elsewhere in views])
    return math.sqrt(near.mean()), math.sqrt(far.mean())


def _masks(borders: Borders, buffer: GBuffer) -> tuple[Mask, Mask]:
    """Which pixels lie within a texel of a seam, and which two from any border: (pixels, pixels) both."""
    shape = (buffer.pixels, buffer.pixels, SUBSAMPLES**2)
    seam, border = (
        np.where(buffer.hit, borders.at(of, buffer.uv[:, :2]), np.nan).reshape(shape)
        for of in (borders.seam, borders.any)
    )
    return buffer.eroded & (seam.max(axis=2) <= 1), buffer.eroded & (border.min(axis=2) > 2)


if __name__ == "__main__":
    main()
