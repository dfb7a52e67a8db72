# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare baked assets of several parts, and other pictures of them, with path-traced ones, part by part."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from PIL import Image

from radtex_addon.core.arrays import Ints
from radtex_addon.report.finished_bake import find_bakes_of_all, read_bake
from radtex_addon.report.gbuffer import Array, BakedSurface, eroded
from radtex_addon.report.judging import FEWEST, resolved
from radtex_addon.report.metrics import Mask, Picture, display, flip_map, glints_kept, psnr
from radtex_addon.report.through import Shown, light_along
from radtex_addon.scene.preview_file import appended

from .views import View


@dataclass(frozen=True, eq=False)
class Part(Shown):
    """One object of a bake."""

    name: str


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
        names = getattr(bake.sidecar, "surfaces", ()) or (bake.sidecar.object_name,)
        with appended(bake.preview, tuple(names)) as copies:
            for copy in copies:
                if copy is not None:
                    bpy.context.scene.collection.objects.link(copy)
            bpy.context.view_layer.update()  # only then do they stand in their places
            for name, copy in zip(names, copies, strict=True):
                if copy is not None:
                    mesh: Any = copy.data
                    surface = BakedSurface(mesh, np.array(copy.matrix_world), bake.sidecar.uv_map)
                    found.append(Part(surface, bake, name))
    return found


def judge(parts: list[Part], view: View, sheet: Path, blocked: Array | None = None) -> dict[str, Figures]:
    """Figures of a view: "all" and by part's name of the bake, and by name of its other pictures.

    Writes a sheet: traced, baked, the others; below them twice their difference. Pixels count that are wholly
    covered, but not where a clear part shows what is behind all parts, which no bake knows, nor where what is
    not baked is met first: at the distances `blocked` (N,) along the view's rays.
    """
    shown, owner = looked_up(parts, view, blocked)
    inside = (owner >= 0).all(axis=2)
    whole = eroded(inside)
    masks = {"all": whole}
    masks |= {part.name: whole & (owner == number).all(axis=2) for number, part in enumerate(parts)}
    others = {
        name: np.where(inside[..., None], picture, view.reference) for name, picture in view.others.items()
    }
    _save_sheet([view.reference, shown, *others.values()], sheet)
    found = {
        name: Figures.of(shown, view.reference, mask) for name, mask in masks.items() if mask.sum() >= FEWEST
    }
    return found | {name: Figures.of(other, view.reference, whole) for name, other in others.items()}


def looked_up(parts: list[Part], view: View, blocked: Array | None = None) -> tuple[Picture, Ints]:
    """What the bakes show of a view, with the reference around; and the part (P, P, S) that each lookup met.

    It is negative for none. `blocked` as for `judge`.
    """
    seen = light_along(parts, view.rays, blocked)
    mean, owner = resolved(seen.light, seen.first, view.camera.pixels)
    inside = (owner >= 0).all(axis=2)
    return np.where(inside[..., None], mean, view.reference), owner


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
            rows.append(np.asarray(image.crop((0, 0, image.width, image.height // 2))))
    if rows:
        Image.fromarray(np.concatenate(rows)).save(path, quality=88)
