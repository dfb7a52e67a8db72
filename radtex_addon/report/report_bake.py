# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Make a report: from a bake's files to the HTML page."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, field, replace
from pathlib import Path

import bpy

from ..core.errors import InputError
from ..core.messages import do
from ..cycles.device import use_device
from ..formats.disk.atomic import check_writable, replacing_together
from ..formats.disk.temporary import temporary_folder
from ..formats.sidecar import file_name
from ..formats.sidecar_file import AnySidecar, opened
from ..prepare.unwrapping import unwrap_options
from ..scene.objects import find_object
from ..scene.scratch import at_frame, scratch_scene
from ..scene.units import metres_per_unit
from ..settings.spec import Unwrap
from .causes import bake_variants, first_change
from .finished_bake import Finished, called_of, check_whole, read_bake
from .judging import PartFigures, judge, mean_energy, mean_flip, mean_psnr, noise_floor, part_figures
from .map_pictures import map_pictures
from .mesh import SurfaceFound, find_mesh
from .page import Contents, page
from .report_progress import ReportStep, ReportTask
from .shared_atlas import find_shared
from .sizes import check_judged, gpu_bytes, sizes_of
from .views import MOST_PIXELS, TracedView, make_views, reference_of

_CHECKERS = 2  # views that also show the checker
_LIMITS = {"views": (1, 64), "pixels": (16, MOST_PIXELS), "samples": (1, 2**24)}


@dataclass(frozen=True)
class ReportSpec:
    """How a bake is judged: `views` pictures of `pixels` a side, path traced at `samples` and denoised.

    With `variants` the object is also baked with half of each setting. A bake that takes more than
    `memory_mb` to read is refused. Raises InputError for numbers out of range.
    """

    views: int = 3
    pixels: int = 256
    samples: int = 128
    variants: bool = False
    device: str = "auto"
    memory_mb: int | None = None

    def __post_init__(self) -> None:
        for name, (least, most) in _LIMITS.items():
            value = getattr(self, name)
            if not least <= value <= most:
                raise InputError(f"{name} {value}: give a whole number from {least} to {most}")


@dataclass(frozen=True)
class ReportResult:
    """The results of a report.

    `floor` is the reference's PSNR against another seed's; `disk` and `gpu` are bytes, `lost` are decibels by
    cause. `flip` is None if FLIP is not available, `first_change` if no variants were baked. `parts` are the
    mean figures of each of several objects that share the atlas, as far as the views show it.
    """

    page: Path
    verdict: str
    psnr: float
    flip: float | None
    energy: float
    floor: float
    disk: int
    gpu: int
    lost: dict[str, float]
    first_change: str | None
    parts: dict[str, PartFigures] = field(default_factory=dict)


def report_path(sidecar: AnySidecar) -> Path:
    """The default path of the report on a bake; each frame's bake has a report of its own.

    Raises FormatError for a file that is no sidecar.
    """
    file = opened(sidecar)
    stem = file.path.name.removesuffix(f".{file.facts.text('kind')}.json")
    if stem == file.path.name:  # it was renamed
        return file.path.with_name(file_name(called_of(file), "report", "html"))
    return file.path.with_name(f"{stem}.report.html")


def report_steps(
    scene: bpy.types.Scene, sidecar: AnySidecar, spec: ReportSpec, out: Path
) -> Generator[ReportStep, None, ReportResult]:
    """Judge the bake with this sidecar against views of its objects in `scene`, and write a page to `out`.

    It is judged as it was baked: at its frame, with its lamps, and against the object whose light it shows.
    Yields progress; returns the results. Afterwards the scene is as it was, also after an error or when the
    generator is closed; the page is written whole or not at all. Raises InputError for an object, a source or
    a lamp that is missing or does not fit, FormatError for files that cannot be read, BakeError if rendering
    or writing fails.
    """
    check_writable(out.parent)
    file = opened(sidecar)
    check_whole(file)
    check_judged(file, spec.memory_mb)
    bake = read_bake(file)
    if spec.variants and bake.sidecar.objects:
        raise InputError(
            f"{file} is of several objects, of which no halves are baked", do("leave variants out")
        )
    with at_frame(scene, bake.sidecar.frame):
        found, views = yield from _look(scene, bake, spec)
        yield ReportStep(ReportTask.COMPARE, 0, 1)
        judged = judge(bake, found.surface, views, found.parts)
        pictures = map_pictures(found.surface, views[:_CHECKERS], bake.sidecar.width, bake.sidecar.height)
        variants = None
        if spec.variants:
            again = replace(bake.spec(spec.device), uv_layer=found.uv_layer, unwrap=found.unwrap)
            name, whole = bake.sidecar.object_name, mean_psnr(judged)
            variants = yield from bake_variants(scene, again, name, views, whole)
    yield ReportStep(ReportTask.PAGE, 0, 1)
    sizes = sizes_of(bake)
    contents = Contents(bake, judged, noise_floor(judged), sizes, variants, spec.samples, pictures)
    with replacing_together(out) as beside:
        beside.write_text(page(contents), encoding="utf-8", newline="\n")
    return ReportResult(
        page=out,
        verdict=contents.verdict,
        psnr=mean_psnr(judged),
        flip=mean_flip(judged),
        energy=mean_energy(judged),
        floor=contents.floor.psnr,
        disk=sum(size.disk for size in sizes),
        gpu=gpu_bytes(bake),
        lost={variant.cause.value: variant.lost for variant in variants or ()},
        first_change=None if variants is None else first_change(bake, variants),
        parts=part_figures(judged),
    )


def _look(
    scene: bpy.types.Scene, bake: Finished, spec: ReportSpec
) -> Generator[ReportStep, None, tuple[SurfaceFound, list[TracedView]]]:
    with (
        temporary_folder() as folder,
        scratch_scene(scene) as scratch,
        use_device(scratch, spec.device),
    ):
        original = find_object(scratch, bake.sidecar.surfaces[0])
        if bake.sidecar.objects:
            yield ReportStep(ReportTask.FIND_MESH, 0, 1)
            surface, parts = find_shared(scratch, bake)
            found = SurfaceFound(surface, None, Unwrap.AUTO, parts)
        else:
            options = unwrap_options(bake.spec(spec.device), metres_per_unit(scratch))
            found = yield from find_mesh(scratch, original, bake, options)
        with reference_of(scratch, original, bake.sidecar) as shown:
            views = yield from make_views(shown, found.surface, spec.views, spec.pixels, spec.samples, folder)
    return found, views
