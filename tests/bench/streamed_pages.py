# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a view needs of an atlas, were it streamed by pages and levels as a virtual texture:

    python -m tests.bench.streamed_pages FOLDER [--page 8] [--pixels 256]

FOLDER has a finished bake of the layout buckets with its preview. Each level is cut into pages of so many
texels; a view's lookups, quadrilinear between the two levels that its pixels fall on, name the pages they
read. The picture is then made of those pages alone, and once of the pages a level coarser. Bytes are those of
RGB9E5: of memory as they are, of the download packed by zstd, page by page.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import cast

import bpy
import numpy as np
import zstandard

from radtex_addon.core.arrangements import fitting_levels
from radtex_addon.core.arrays import Bools, Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.formats.codecs.rgb9e5 import encode_rgb9e5
from radtex_addon.formats.containers.exr import read_atlas
from radtex_addon.report.finished_bake import find_bake, read_bake
from radtex_addon.report.gbuffer import BakedSurface, CameraRays, GBuffer
from radtex_addon.report.metrics import psnr
from radtex_addon.scene.preview_file import baked_copy
from tests.reference.levels import level_chain, sample_level

VIEWS = {"whole": (1.0, 0.0), "near": (0.3, 0.25), "far": (6.0, 0.0)}  # distance, how far beside the middle
AWAY = np.array([0.55, -0.7, 0.45])  # towards the camera
REACH = 2.3  # of the camera, in shares of half the bake's diagonal
HALF = 0.42  # tangent of half the angle of view


@dataclass(frozen=True)
class Atlas:
    """An atlas's `chain` of levels, each cut into pages of `page` texels."""

    layout: AtlasLayout
    chain: list[Floats]
    page: int

    def cut(self, level: int) -> Floats:
        """A level's pages, (rows, columns, page * n, page * n, 3); what lies beyond its edge is 0."""
        side = self.page * self.layout.bucket
        image = self.chain[level][..., :3]
        rows, columns = (-(-size // side) for size in image.shape[:2])
        filled = np.zeros((rows * side, columns * side, 3), np.float32)
        filled[: image.shape[0], : image.shape[1]] = image
        return cast(Floats, filled.reshape(rows, side, columns, side, 3).swapaxes(1, 2))

    def packed(self, level: int) -> Floats:
        """How many bytes each page of a level has as a file, (rows, columns)."""
        pages, packer = self.cut(level), zstandard.ZstdCompressor(level=9)
        sizes = [[len(packer.compress(encode_rgb9e5(page).tobytes())) for page in row] for row in pages]
        return np.array(sizes, dtype=np.float64)

    def only(self, needed: Sequence[Bools]) -> list[Floats]:
        """The chain with other pages than the needed ones black."""
        side = self.page * self.layout.bucket
        kept = []
        for image, pages in zip(self.chain, needed, strict=True):
            mask = np.kron(pages, np.ones((side, side)))[: image.shape[0], : image.shape[1]]
            kept.append(image * mask[..., None].astype(image.dtype))
        return kept

    def needed(self, uv: Floats, level: Floats) -> list[Bools]:
        """Which pages of each level lookups read, (rows, columns) bool."""
        found = []
        for number, image in enumerate(self.chain):
            rows, columns = (size // self.layout.bucket for size in image.shape[:2])
            pages = np.zeros((-(-rows // self.page), -(-columns // self.page)), dtype=bool)
            here = np.abs(level - number) < 1
            texels = np.array([self.layout.width, self.layout.height])
            last = -(-texels // (1 << number)) - 1
            corner = np.floor(uv[here] * texels / (1 << number) - 0.5).astype(int)
            for step in ((0, 0), (0, 1), (1, 0), (1, 1)):
                column, row = (np.clip(corner + step, 0, last) // self.page).T
                pages[row, column] = True
            found.append(pages)
        return found


def opened(folder: Path, page: int) -> tuple[Atlas, BakedSurface]:
    """The atlas and the surface of a finished bake."""
    finished = read_bake(find_bake(folder, None).path)
    pixels, facts = read_atlas(finished.images[0])
    layout = AtlasLayout(facts.width, facts.height, facts.bucket)
    chain = level_chain(pixels.astype(np.float32), layout, fitting_levels(layout))
    bake = finished.sidecar
    with baked_copy(finished.preview, bake.surfaces, bake.uv_map) as (_, copy):
        mesh = cast(bpy.types.Mesh, copy.data)
        return Atlas(layout, chain, page), BakedSurface(mesh, np.array(copy.matrix_world), bake.uv_map)


def seen(surface: BakedSurface, view: str, pixels: int) -> GBuffer:
    """What a view sees; its camera stands about the bake's middle."""
    distance, beside = VIEWS[view]
    points = np.asarray(surface.place, dtype=np.float64)
    low, high = points.min(axis=0), points.max(axis=0)
    size, away = float(np.linalg.norm(high - low)) / 2, AWAY / np.linalg.norm(AWAY)
    right = np.cross([0.0, 0.0, 1.0], away)
    right /= np.linalg.norm(right)
    turn = np.column_stack([right, np.cross(away, right), away])
    place = (low + high) / 2 + beside * size * right + REACH * distance * size * away
    rays = CameraRays.of_camera(place, turn, HALF, pixels, 1)
    return surface.gbuffer(rays, np.full(len(rays.away), np.inf))


def levels_of(buffer: GBuffer, atlas: Atlas) -> Floats:
    """Each pixel's level, by how far its neighbours lie apart on the same material, in texels: (N,)."""
    side = buffer.pixels
    uv = buffer.uv.reshape(side, side, 2) * [atlas.layout.width, atlas.layout.height]
    triangle = np.where(buffer.hit, buffer.triangle, -1).reshape(side, side)
    longest = np.zeros((side, side))
    for axis in (0, 1):
        step = np.linalg.norm(np.diff(uv, axis=axis), axis=-1)
        step[np.diff(triangle, axis=axis) != 0] = 0  # across edges nothing is known
        widened = [(0, 1), (0, 0)] if axis == 0 else [(0, 0), (0, 1)]
        longest = np.maximum(longest, np.pad(step, widened))
    unknown = (longest == 0) & buffer.hit.reshape(side, side)
    longest[unknown] = np.median(longest[longest > 0]) if (longest > 0).any() else 1.0
    return np.clip(np.log2(np.maximum(longest, 1)), 0, len(atlas.chain) - 1).ravel()


def main() -> None:
    """Print a table: for each view what it needs, beside the whole atlas."""
    parser = argparse.ArgumentParser()
    parser.add_argument("folder", type=Path)
    parser.add_argument("--page", type=int, default=8)
    parser.add_argument("--pixels", type=int, default=256)
    asked = parser.parse_args()
    atlas, surface = opened(asked.folder, asked.page)
    packed = [atlas.packed(level) for level in range(len(atlas.chain))]
    held = 4 * (asked.page * atlas.layout.bucket) ** 2
    print("| view | pages | memory, KiB | download, KiB | dB a level coarser | its memory, KiB |")
    print("|---|---|---|---|---|---|")
    everything = sum(sizes.size for sizes in packed)
    whole = sum(float(sizes.sum()) for sizes in packed)
    print(f"| the whole atlas | {everything} | {everything * held / 1024:.0f} | {whole / 1024:.0f} | | |")
    for view in VIEWS:
        buffer = seen(surface, view, asked.pixels)
        hit, level = buffer.hit, levels_of(buffer, atlas)
        uv, incidence = buffer.uv[hit], buffer.incidence[hit]
        coarser = np.minimum(level[hit] + 1, len(atlas.chain) - 1)
        pictures = {}
        count, loaded, names = {}, {}, {"needed": level[hit], "coarser": coarser}
        for name, chosen in names.items():
            needed = atlas.needed(uv, chosen)
            part = sample_level(atlas.only(needed), atlas.layout, uv, incidence, chosen)[:, :3]
            pictures[name] = buffer.resolve(buffer.spread(part))
            count[name] = sum(int(pages.sum()) for pages in needed)
            loaded[name] = sum(float(s[p].sum()) for s, p in zip(packed, needed, strict=True))
        truth = sample_level(atlas.chain, atlas.layout, uv, incidence, level[hit])[:, :3]
        picture = buffer.resolve(buffer.spread(truth))
        assert np.array_equal(picture, pictures["needed"]), f"{view}: its pages lack something"
        loss = psnr(pictures["coarser"], picture, buffer.inside)
        print(
            f"| {view} | {count['needed']} | {count['needed'] * held / 1024:.0f} | "
            f"{loaded['needed'] / 1024:.0f} | {loss:.1f} | {count['coarser'] * held / 1024:.0f} |"
        )


if __name__ == "__main__":
    main()
