# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare baked assets of several parts with path-traced pictures from the scene's cameras, part by part."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from PIL import Image

from radtex_addon.formats.containers.exr import read_render
from radtex_addon.report.finished_bake import find_bakes_of_all, read_bake
from radtex_addon.report.gbuffer import BakedSurface, CameraRays, eroded
from radtex_addon.report.judging import FEWEST, resolved
from radtex_addon.report.metrics import Mask, Picture, display, flip_map, glints_kept, psnr
from radtex_addon.report.through import Shown, light_along
from radtex_addon.scene.preview_file import appended

from ..fidelity.methods.eevee import set_up

PIXELS = 256  # of a picture's side
SAMPLES = 256  # of a reference's pixel, denoised
_EEVEE_SAMPLES = 64
_SUBSAMPLES = 3  # along a pixel's side


@dataclass(frozen=True, eq=False)
class View:
    """A path-traced picture by one of the scene's cameras, the rays of its pixels, and Eevee's picture."""

    name: str
    reference: Picture
    rays: CameraRays
    eevee: Picture | None = None


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


def traced_views(folder: Path, eevee: bool) -> list[View]:
    """Path trace the open scene from each of its cameras whose name begins with "view", in order of names.

    With `eevee` that renders them, too, with ray tracing; the scene is then set to it.
    """
    scene: Any = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = PIXELS
    scene.render.resolution_percentage = 100
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.seed = SAMPLES, True, 7
    cameras = [item for item in scene.objects if item.type == "CAMERA" and item.name.startswith("view")]
    cameras.sort(key=lambda item: str(item.name))
    traced = [_rendered(camera, folder) for camera in cameras]
    if eevee:
        set_up(scene, PIXELS, _EEVEE_SAMPLES)
    compared = [_rendered(camera, folder) if eevee else None for camera in cameras]
    found = []
    for camera, picture, other in zip(cameras, traced, compared, strict=True):
        matrix = np.array(camera.matrix_world)
        half = camera.data.sensor_width / 2 / camera.data.lens
        rays = CameraRays.of_camera(matrix[:3, 3], matrix[:3, :3], half, PIXELS, _SUBSAMPLES)
        found.append(View(camera.name, picture, rays, other))
    return found


def _rendered(camera: Any, folder: Path) -> Picture:
    scene: Any = bpy.context.scene
    file = folder / "view.exr"
    scene.camera = camera
    scene.render.filepath = str(file)
    bpy.ops.render.render(write_still=True)
    (found,) = read_render(file).values()
    picture: Picture = found[::-1, :, :3].astype(np.float64)
    return picture


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
            for copy in copies:
                if copy is not None:
                    mesh: Any = copy.data
                    surface = BakedSurface(mesh, np.array(copy.matrix_world), bake.sidecar.uv_map)
                    found.append(Part(surface, bake, copy.name))
    return found


def judge(parts: list[Part], view: View, sheet: Path) -> dict[str, Figures]:
    """Figures of a view, "all" and by part's name; writes a sheet: traced, baked, and twice their difference.

    Pixels count that are wholly covered, but not where a clear part shows what is behind all parts, which no
    bake knows.
    """
    seen = light_along(parts, view.rays)
    mean, owner = resolved(seen.light, seen.first, PIXELS)
    inside = (owner >= 0).all(axis=2)
    shown = np.where(inside[..., None], mean, view.reference)
    whole = eroded(inside)
    masks = {"all": whole}
    masks |= {part.name: whole & (owner == number).all(axis=2) for number, part in enumerate(parts)}
    apart = np.abs(display(shown) - display(view.reference))
    row = np.concatenate([display(view.reference), display(shown), np.clip(2 * apart, 0, 1)], axis=1)
    Image.fromarray((255 * row).astype(np.uint8)).save(sheet)
    found = {
        name: Figures.of(shown, view.reference, mask) for name, mask in masks.items() if mask.sum() >= FEWEST
    }
    if view.eevee is not None:
        picture = np.where(inside[..., None], view.eevee, view.reference)
        found["Eevee"] = Figures.of(picture, view.reference, whole)
    return found
