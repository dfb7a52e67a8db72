# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Once around a glazed teapot: path traced, baked by RadTex, by a flat lightmap, by a reflection probe.

Each method bakes the teapot alone, with its defaults; all else is path traced in all four panes.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

import bpy
import numpy as np
from mathutils.bvhtree import BVHTree
from scipy.ndimage import distance_transform_edt

from radtex_addon.report.gbuffer import Array, BakedSurface, GBuffer
from radtex_addon.report.metrics import Picture, psnr

from ..fidelity import methods
from ..fidelity.method import Baked
from ..fidelity.references import blockers, distances
from ..fidelity.scenes import Stage
from ..gallery.looking import Camera, rendered
from .encode import captioned, graded, save_film
from .still_life import orbit_scene

FRAMES = 36
PIXELS = 320  # along a pane's side
SAMPLES = 24  # of a pixel, before it is denoised
PER_SECOND = 12
MOST_BYTES = 1_500_000
PANES = {"layered": "RadTex", "lightmap": "Flat lightmap", "probe": "Reflection probe"}
_TEXELS, _BAKE_SAMPLES = 128, 16  # what a bake has that names none
_TARGET = (0.0, 0.0, 0.78)
_DISTANCE, _ELEVATION, _LENS = 6.4, 24.0, 62.0


@dataclass(frozen=True, eq=False)
class Turned:
    """A method's bake, and its surface."""

    baked: Baked
    surface: BakedSurface


def make(folder: Path, frames: int = FRAMES) -> None:
    """Bake, go round, save orbit.webp and orbit.json in a folder."""
    subject = orbit_scene()
    stage = Stage("orbit", subject, (), ())
    with tempfile.TemporaryDirectory() as temporary:
        turned = {name: _turned(name, stage, Path(temporary)) for name in PANES}
    tree = blockers(stage)
    pictures: list[list[Picture]] = []
    decibels: dict[str, list[float]] = {name: [] for name in PANES}
    for azimuth in np.arange(frames) * 360 / frames:
        truth, panes = _frame(tree, turned, _camera(float(azimuth)), decibels)
        pictures.append([truth, *panes])
        told = ", ".join(f"{name} {found[-1]:.1f}" for name, found in decibels.items())
        print(f"{azimuth:.0f} degrees: {told} dB", flush=True)
    names = ["Path traced", *PANES.values()]
    size = save_film(folder / "orbit.webp", list(_grids(pictures, names)), PER_SECOND, MOST_BYTES)
    facts = {
        "blender": bpy.app.version_string,
        "frames": frames,
        "texels": _TEXELS,
        "bytes": size,
        "decibels, worst to best": {
            PANES[name]: [round(min(found), 1), round(max(found), 1)] for name, found in decibels.items()
        },
        "bytes on a GPU": {PANES[name]: one.baked.bytes for name, one in turned.items()},
    }
    (folder / "orbit.json").write_text(json.dumps(facts, indent=1) + "\n")


def _turned(name: str, stage: Stage, folder: Path) -> Turned:
    method = import_module(f"{methods.__name__}.{name}").make(_TEXELS, _BAKE_SAMPLES)
    baked: Baked = method.bake(stage, folder)
    return Turned(baked, BakedSurface(baked.mesh, baked.matrix_world, baked.uv_layer))


def _camera(azimuth: float) -> Camera:
    """A camera at an azimuth in degrees, from -y."""
    around, above = np.radians(azimuth), np.radians(_ELEVATION)
    away = np.array([np.sin(around) * np.cos(above), -np.cos(around) * np.cos(above), np.sin(above)])
    x, y, z = (np.array(_TARGET) + _DISTANCE * away).tolist()
    return Camera((x, y, z), _TARGET, _LENS)


def _frame(
    tree: BVHTree, turned: dict[str, Turned], camera: Camera, decibels: dict[str, list[float]]
) -> tuple[Picture, list[Picture]]:
    """The path-traced picture and each method's; adds its decibels, inside the teapot; `tree` hides that."""
    truth = rendered(camera, SAMPLES, size=(PIXELS, PIXELS))[..., :3]
    rays = camera.rays(pixels=PIXELS)
    blocked = distances(tree, rays)
    panes = []
    for name, one in turned.items():
        seen = one.surface.gbuffer(rays, blocked)
        light = seen.resolve(one.baked.radiance(seen))
        decibels[name].append(psnr(light, truth, seen.eroded))
        panes.append(_laid_over(truth, light, seen))
    return truth, panes


def _laid_over(truth: Picture, light: Picture, seen: GBuffer) -> Picture:
    """The teapot's light over what is path traced around it; at its outline, over the nearest such pixel."""
    share: Array = seen.hit.reshape(PIXELS, PIXELS, -1).mean(axis=2)
    row, column = distance_transform_edt(share > 0, return_distances=False, return_indices=True)
    laid: Picture = share[..., None] * light + (1 - share[..., None]) * truth[row, column]
    return laid


def _grids(pictures: list[list[Picture]], names: list[str]) -> Iterator[Picture]:
    """Display values of two by two panes with captions."""
    for panes in pictures:
        shown = [captioned(graded(pane), name) for pane, name in zip(panes, names, strict=True)]
        yield np.concatenate([np.concatenate(shown[k : k + 2], axis=1) for k in (0, 2)])
