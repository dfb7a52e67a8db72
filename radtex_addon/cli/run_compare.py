# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run `bake.py compare`."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import bpy

from ..core.messages import do
from ..formats.disk.atomic import check_writable
from ..formats.sidecar_file import SidecarFile
from ..job.instances import join_for
from ..preview.swap import original_of
from ..report.metrics import Figures
from ..report.shown import bakes_of, frame_of
from ..report.side_by_side import ComparisonFiles, compare_steps, write_comparison
from ..report.viewpoint import Viewpoint
from ..scene.demo import OBJECT
from ..scene.objects import check_only_one, find_object
from ..scene.scratch import at_frame, find_view_layer
from .compare_arguments import CompareRequest
from .interruption import Interruption
from .opening import open_asked
from .options import check_psnr
from .reporting import Report

_OWN_VIEW = do("give a view by --view and --window")


def run_compare(request: CompareRequest, report: Report, interruption: Interruption) -> None:
    """Render both pictures and report how they differ. Raises RadTexError.

    QualityError: the pictures are further apart than `min_psnr` allows.
    """
    check_writable(request.out)
    scene = open_asked(request, interruption)
    join_for(scene, request.objects or (OBJECT,))
    items = [_object(scene, name) for name in request.objects or (OBJECT,)]
    bakes = _bakes(items, request)
    with at_frame(scene, frame_of(scene, bakes)):
        eye = request.eye or Viewpoint.of_camera(scene, find_view_layer(scene, None), _OWN_VIEW)
    name = ", ".join(item.name for item in items)
    steps = compare_steps(scene, bakes, eye, request.spec)
    found = interruption.between(steps, partial(report.progress, name))
    files = ComparisonFiles.of(request.out, [item.name for item in items])
    write_comparison(found, files)
    report.event(
        "done",
        object=name,
        summary=_summary(name, found.figures),
        files=[str(path) for path in files.all],
        traced=str(files.traced),
        baked=str(files.baked),
        **_facts(found.figures),
    )
    check_psnr(name, found.figures.psnr, request.min_psnr)


def _bakes(
    items: Sequence[bpy.types.Object], request: CompareRequest
) -> dict[bpy.types.Object, SidecarFile | None]:
    """The bake of each object, None if its preview is on. Raises RadTexError."""
    if not request.sidecars:
        return bakes_of(items, request.bake)
    pairs = zip(items, request.sidecars, strict=True)
    return {item: None if path is None else SidecarFile.read(path) for item, path in pairs}


def _object(scene: bpy.types.Scene, name: str) -> bpy.types.Object:
    """The object called `name`; for a preview, its original. Raises InputError."""
    item = scene.objects.get(name)
    if item is None:
        return find_object(scene, name)  # raises, and lists the objects that exist
    check_only_one(scene.objects, name)
    return original_of(item) or item


def _summary(name: str, figures: Figures) -> str:
    flip = "" if figures.flip is None else f", FLIP {figures.flip:.3f}"
    return f"{name}: {figures.psnr:.1f} dB from path traced{flip}, energy {figures.energy:.3f}"


def _facts(figures: Figures) -> dict[str, object]:
    return {
        "psnr": round(figures.psnr, 3),
        "flip": None if figures.flip is None else round(figures.flip, 4),
        "energy": round(figures.energy, 4),
    }
