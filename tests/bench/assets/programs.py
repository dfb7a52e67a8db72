# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished bake as programs show it: the exported web page in Chromium, Godot, and the preview in Eevee.

All take SUBSAMPLES x SUBSAMPLES rays a pixel and give linear light, rows from the top.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from radtex_addon.bake.progress import finished
from radtex_addon.core.errors import InputError
from radtex_addon.export.exporting import export_steps
from radtex_addon.report.finished_bake import find_bakes_of_all, read_bake
from radtex_addon.report.metrics import Picture
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.real.exhibit import Camera
from tests.real.godot import Shot, imported, pictures
from tests.real.preview_shot import Shots
from tests.real.root import Root
from tests.real.web import Site

from ..engines.programs import blended
from .views import SUBSAMPLES

_RENDERER = "Forward+"  # Godot's own choice on a computer
_DITHERED = 4  # samples of Eevee for each ray, where one sees through a part


def pictures_by_programs(
    bakes: Path, cameras: list[Camera], root: Root, site: Site
) -> list[dict[str, Picture]]:
    """For each camera a picture by each program, under its name; exports lie below the site's folder.

    Raises InputError unless there is one bake in the folder `bakes`, for each bake is exported by itself.
    """
    sidecars = find_bakes_of_all(bakes, "shown by programs")
    if len(sidecars) != 1:
        raise InputError(f"{bakes} holds {len(sidecars)} bakes: programs show one, of parts baked together")
    sidecar = sidecars[0].path
    fine = [replace(camera, pixels=SUBSAMPLES * camera.pixels) for camera in cameras]
    shown = {
        "web page": _by_page(sidecar, fine, site),
        "Godot": _by_godot(sidecar, fine, root, site.folder / "godot"),
        "preview in Eevee": _by_preview(sidecar, fine, site.folder / "preview"),
    }
    return [
        {name: averaged(taken[number]) for name, taken in shown.items()} for number in range(len(cameras))
    ]


def averaged(picture: Picture) -> Picture:
    """The means (P, P, 3) of SUBSAMPLES x SUBSAMPLES pixels each of a finer picture."""
    side = len(picture) // SUBSAMPLES
    mean: Picture = picture.reshape(side, SUBSAMPLES, side, SUBSAMPLES, -1).mean(axis=(1, 3))
    return mean


def _by_page(sidecar: Path, cameras: list[Camera], site: Site) -> list[Picture]:
    """As on the screen, where clear parts are blended, and what is brighter than white is clipped."""
    finished(export_steps(sidecar, ExportSpec(Target.WEB), site.folder / "web", overwrite=True))
    side, found = cameras[0].pixels, []
    with site.opened("web/", width=side, height=side, device_scale_factor=1) as shown:
        shown.wait()
        for camera in cameras:
            shown.set_camera(camera)
            found.append(blended(shown, np.zeros((side // SUBSAMPLES, side // SUBSAMPLES, 3))))
    return found


def _by_godot(sidecar: Path, cameras: list[Camera], root: Root, folder: Path) -> list[Picture]:
    """Brighter than 1 is clipped before pixels are averaged."""
    finished(export_steps(sidecar, ExportSpec(Target.GODOT), folder, overwrite=True))
    return pictures(root, imported(root, folder), _RENDERER, [Shot(camera) for camera in cameras])


def _by_preview(sidecar: Path, cameras: list[Camera], folder: Path) -> list[Picture]:
    preview = read_bake(sidecar).preview
    return Shots(preview, "eevee", folder, "", _DITHERED).pictures(tuple(cameras))
