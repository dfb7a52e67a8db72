# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How fast the texel raster is, beside a plain loop over triangles: `python -m tests.bench.raster`.

Goal: 1M texels over 100k triangles within 5 s and 1.5 GB on one core.
"""

from __future__ import annotations

import argparse
import resource
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from time import perf_counter

import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.surface import SurfaceMesh
from radtex_addon.core.texel_map import rasterise

LOOPED = 2000  # triangles of the loop; it is linear in them


def sheet(columns: int, rows: int) -> Floats:
    """UVs (F, 3, 2) of one island over the whole square, its cells cut along their diagonals."""
    x, y = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, rows + 1))
    point = np.stack([x, y], axis=-1)
    a, b, c, d = point[:-1, :-1], point[:-1, 1:], point[1:, 1:], point[1:, :-1]
    return np.stack([np.stack([a, b, c], axis=-2), np.stack([a, c, d], axis=-2)], axis=2).reshape(-1, 3, 2)


def islands(side: int, cells: int) -> Floats:
    """UVs of side x side islands, each turned by another angle, as a packer leaves them."""
    one = sheet(cells, cells) - 0.5
    angle = np.random.default_rng(1).uniform(0, 2 * np.pi, side * side)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]).transpose(2, 0, 1)
    centre = (
        np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 1, 1, 2) + 0.5
    ) / side
    turned = np.einsum("nab,fkb->nfka", turn, one) * (0.69 / side) + centre
    uv: Floats = turned.reshape(-1, 3, 2)
    return uv


def slivers(count: int) -> Floats:
    """UVs of diagonals across the square, a ten-thousandth wide."""
    low = np.random.default_rng(2).uniform(0, 0.2, (count, 2))
    high = 1 - np.random.default_rng(3).uniform(0, 0.2, (count, 2))
    return np.stack([low, high, high + np.array([1e-4, -1e-4])], axis=1)


def curved(uv: Floats) -> SurfaceMesh:
    """A wavy surface over the UVs; the raster does not ask for welded vertices."""
    u, v = uv[..., 0], uv[..., 1]
    position = np.stack([u, v, 0.1 * np.sin(9 * u) * np.cos(7 * v)], axis=-1)
    slope_u, slope_v = 0.9 * np.cos(9 * u) * np.cos(7 * v), -0.7 * np.sin(9 * u) * np.sin(7 * v)
    normal = np.stack([-slope_u, -slope_v, np.ones_like(u)], axis=-1)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    tangent = np.broadcast_to([1.0, 0.0, 0.0], normal.shape)
    float32 = [
        array.astype(np.float32) for array in (position.reshape(-1, 3), normal, tangent, u * 0 + 1, uv)
    ]
    triangles = np.arange(u.size).reshape(-1, 3)
    return SurfaceMesh(float32[0], triangles, float32[1], float32[2], float32[3], float32[4])


def loop(surface: SurfaceMesh, width: int, height: int) -> None:
    """The baseline: for each triangle the texels of its bounding box, centres only."""
    position, normal = np.zeros((2, height, width, 3), dtype=np.float32)
    corner_position = surface.corner_position
    for triangle, uv in enumerate(surface.uv * (width, height)):
        i0, j0 = np.maximum(np.floor(uv.min(axis=0)), 0).astype(int)
        i1, j1 = np.minimum(np.ceil(uv.max(axis=0)), (width, height)).astype(int)
        x, y = np.meshgrid(np.arange(i0, i1) + 0.5, np.arange(j0, j1) + 0.5)
        (ax, ay), (bx, by), (cx, cy) = uv
        area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        second = ((x - ax) * (cy - ay) - (cx - ax) * (y - ay)) / area
        third = ((bx - ax) * (y - ay) - (x - ax) * (by - ay)) / area
        weight = np.stack([1 - second - third, second, third], axis=-1)
        hit = (weight >= 0).all(axis=-1)
        position[j0:j1, i0:i1][hit] = weight[hit] @ corner_position[triangle]
        normal[j0:j1, i0:i1][hit] = weight[hit] @ surface.normal[triangle]


def timed(work: Callable[[], object]) -> float:
    started = perf_counter()
    work()
    return perf_counter() - started


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--texels", type=int, default=1024, help="texels a side")
    side: int = parser.parse_args().texels
    cases = {"one sheet": sheet(224, 224), "64 islands": islands(8, 28), "1,000 slivers": slivers(1000)}
    print(f"{side} x {side} texels, Python {sys.version.split()[0]}, numpy {np.__version__}")
    print(
        f"{'mesh':14}{'triangles':>10}{'covered':>10}{'raster s':>10}{'loop s':>10}{'ratio':>8}{'peak MB':>9}"
    )
    for name, uv in cases.items():
        surface = curved(uv)
        rasters = [timed(partial(rasterise, surface, side, side)) for _ in range(3)]
        covered = rasterise(surface, side, side).covered.mean()
        peak = (
            resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        )  # of the process so far, in MB on Linux
        some = np.linspace(0, len(uv) - 1, min(len(uv), LOOPED)).astype(int)
        picked = {name: getattr(surface, name)[some] for name in ("triangles", "normal", "uv")}
        part = replace(surface, **picked)
        looped = timed(partial(loop, part, side, side)) * len(uv) / len(some)
        raster = float(np.median(rasters))
        figures = f"{raster:>10.2f}{looped:>10.2f}{looped / raster:>8.1f}{peak:>9.0f}"
        print(f"{name:14}{len(uv):>10,}{covered:>10.0%}{figures}")


if __name__ == "__main__":
    main()
