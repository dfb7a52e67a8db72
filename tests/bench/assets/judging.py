# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare baked assets of several parts, and other pictures of them, with path-traced ones, part by part."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from PIL import Image

from radtex_addon.core.surface import ray_offset
from radtex_addon.forms.layered.files.layered_files import read_layered
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas, alpha_at
from radtex_addon.report.finished_bake import Finished, find_bakes_of_all, read_bake
from radtex_addon.report.gbuffer import Array, BakedSurface, CameraRays, eroded
from radtex_addon.report.metrics import Mask, Picture, display, flip_map, glints_kept, psnr
from radtex_addon.scene.preview_file import appended

from .views import PIXELS, View

_LAYERS = 6  # clear parts before each other
_LEFT = 0.01  # of the light from behind: less is nothing
_FEWEST = 30  # pixels of a part in a view, or it is not judged there


@dataclass(frozen=True, eq=False)
class Part:
    """One object of a bake: its surface, the bake and its atlas."""

    name: str
    surface: BakedSurface
    bake: Finished
    atlas: LayeredAtlas


@dataclass(frozen=True, eq=False)
class Figures:
    """Of some pixels: PSNR, FLIP, light over the reference's, and the share of glints that is kept or NaN."""

    psnr: float
    flip: float
    energy: float
    glints: float

    @classmethod
    def of(cls, shown: Picture, reference: Picture, mask: Mask) -> Figures:
        """Of the pixels in a mask."""
        kept = glints_kept(shown, reference, mask)
        return cls(
            psnr(shown, reference, mask),
            float(flip_map(shown, reference)[mask].mean()),
            float(shown[mask].sum() / reference[mask].sum()),
            float("nan") if kept is None else kept,
        )


def baked_parts(folder: Path) -> list[Part]:
    """The objects of all bakes in a folder, which have previews."""
    found = []
    for file in find_bakes_of_all(folder, "judged"):
        bake = read_bake(file)
        atlas, _ = read_layered(file)
        with appended(bake.preview, bake.sidecar.surfaces) as copies:
            for copy in copies:
                if copy is not None:
                    bpy.context.scene.collection.objects.link(copy)
            bpy.context.view_layer.update()  # only then do they stand in their places
            for name, copy in zip(bake.sidecar.surfaces, copies, strict=True):
                if copy is not None:
                    mesh: Any = copy.data
                    surface = BakedSurface(mesh, np.array(copy.matrix_world), bake.sidecar.uv_map)
                    found.append(Part(name, surface, bake, atlas))
    return found


def judge(parts: list[Part], view: View, sheet: Path) -> dict[str, Figures]:
    """Figures of a view: "all" and by part's name of the bake, and by name of its other pictures.

    Writes a sheet: traced, baked, the others; below them twice their difference. Pixels count that are wholly
    covered, but not where a clear part shows what is behind all parts, which no bake knows.
    """
    light, who = _seen(parts, view.rays)
    covered = (who >= 0).reshape(PIXELS, PIXELS, -1)
    inside = covered.all(axis=2)
    mean = np.where(covered[..., None], light.reshape(PIXELS, PIXELS, -1, 3), 0).sum(axis=2)
    mean /= np.maximum(covered.sum(axis=2), 1)[..., None]
    shown = np.where(inside[..., None], mean, view.reference)
    whole = eroded(inside)
    owner = who.reshape(PIXELS, PIXELS, -1)
    masks = {"all": whole}
    masks |= {part.name: whole & (owner == number).all(axis=2) for number, part in enumerate(parts)}
    others = {
        name: np.where(inside[..., None], picture, view.reference) for name, picture in view.others.items()
    }
    _save_sheet([view.reference, shown, *others.values()], sheet)
    found = {
        name: Figures.of(shown, view.reference, mask) for name, mask in masks.items() if mask.sum() >= _FEWEST
    }
    return found | {name: Figures.of(other, view.reference, whole) for name, other in others.items()}


def _save_sheet(pictures: list[Picture], path: Path) -> None:
    """A row of pictures, and below twice the difference from the first."""
    shown = [display(picture) for picture in pictures]
    apart = [np.clip(2 * np.abs(picture - shown[0]), 0, 1) for picture in shown]
    rows = np.concatenate([np.concatenate(shown, axis=1), np.concatenate(apart, axis=1)])
    Image.fromarray((255 * rows).astype(np.uint8)).save(path)


def save_overview(sheets: list[Path], path: Path) -> None:
    """The pictures of some sheets, a row for each, without their differences, as a JPEG."""
    rows = []
    for sheet in sheets:
        with Image.open(sheet) as image:
            rows.append(np.asarray(image.crop((0, 0, image.width, PIXELS))))
    if rows:
        Image.fromarray(np.concatenate(rows)).save(path, quality=88)


def _seen(parts: list[Part], rays: CameraRays) -> tuple[Array, Array]:
    """The light (N, 3) along rays, and the number of the first part that each meets, -1 for none."""
    count = len(rays.away)
    light, left = np.zeros((count, 3)), np.ones(count)
    first = np.full(count, -1)
    start = np.broadcast_to(rays.origin, rays.away.shape).copy()
    some = np.arange(count)
    step = max(ray_offset(part.surface.place) for part in parts)
    for layer in range(_LAYERS):
        near, met, shown, alpha = nearest(parts, replace(rays, origin=start[some], away=rays.away[some]))
        light[some] += left[some, None] * shown
        if layer == 0:
            first[some] = met
        else:  # light from behind all parts is missing
            first[some[(met < 0) & (left[some] > _LEFT)]] = -1
        left[some] *= 1 - alpha
        going = (met >= 0) & (left[some] > _LEFT)
        some, near = some[going], near[going]
        if not len(some):
            break
        start[some] += rays.away[some] * (near + step)[:, None]
    return light, first


def nearest(parts: list[Part], rays: CameraRays) -> tuple[Array, Array, Array, Array]:
    """Distance (N,), part (N,), light (N, 3) and alpha (N,) of what rays meet first; 0 and -1 for nothing."""
    count = len(rays.away)
    near, met = np.full(count, np.inf), np.full(count, -1)
    light, alpha = np.zeros((count, 3)), np.zeros(count)
    for number, part in enumerate(parts):
        buffer = part.surface.gbuffer(rays, near)
        hit = buffer.hit
        if hit.any():
            light[hit] = part.bake.radiance(buffer)[hit]
            alpha[hit] = alpha_at(part.atlas, buffer.uv[hit])
            near[hit] = np.linalg.norm(buffer.position[hit] - rays.origin[hit], axis=1)
            met[hit] = number
    return near, met, light, alpha
