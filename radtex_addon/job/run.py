# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake from its first check to its preview."""

from __future__ import annotations

import logging
from collections.abc import Callable, Generator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import bpy

from ..bake.checkpoint import KEEPS_NOTHING, Keeper
from ..bake.progress import Progress, Stage, finished
from ..bake.spec import OCCLUSION, BakeSpec, Kind, Layout, View
from ..bake.stopwatch import Stopwatch
from ..bake.thumbnail import Thumbnail
from ..core.atlas import AtlasLayout
from ..core.blas import one_blas_thread
from ..core.errors import InputError
from ..core.sampler import Filter
from ..cycles.device import use_device
from ..formats.temporary import temporary_folder
from ..scene.cage import take_cage_out
from ..scene.enclosed import EVERYTHING, show_content_only
from ..scene.eye import find_eye
from ..scene.frames import at_frame
from ..scene.lamps import light_only
from ..scene.objects import find_object
from ..scene.scratch import find_view_layer, new_data_removed, scratch_scene
from .buckets import bake_buckets
from .checks import check_request, check_seen
from .condensed import Condensed
from .files import OutputFiles
from .made import Made
from .occlusion import bake_occlusion
from .parts import check_part
from .prepare import Prepared, prepare
from .previews import save_preview_of
from .shared import bake_shared
from .transfer import bake_transfer
from .unfinished import open_checkpoint
from .unwrapping import Unwraps

log = logging.getLogger(__name__)

Baker: TypeAlias = Callable[..., Generator[Progress, None, Made]]


@dataclass(frozen=True)
class BakeResult:
    """What a bake made, and what it took: `paths` are camera paths, `seconds` are by stage.

    `fireflies` is the share of the light that a fit left out: too few paths brought it. `condensed` says what
    was chosen for a budget or a target.
    """

    files: OutputFiles
    layout: AtlasLayout
    covered_texels: int
    islands: int | None
    paths: int
    device: str
    clamped: int
    fireflies: float
    condensed: Condensed | None
    seconds: dict[Stage, float]


def bake_object(
    scene: bpy.types.Scene,
    name: str,
    spec: BakeSpec,
    folder: Path,
    *,
    view_layer: str | None = None,
    preview: Filter | None = None,
    overwrite: bool = False,
    resume: bool = False,
    thumbnail: Thumbnail | None = None,
    unwraps: Unwraps | None = None,
) -> BakeResult:
    """Bake one object and write its files; see `bake_steps`."""
    return finished(
        bake_steps(
            scene,
            name,
            spec,
            folder,
            view_layer=view_layer,
            preview=preview,
            overwrite=overwrite,
            resume=resume,
            thumbnail=thumbnail,
            unwraps=unwraps,
        )
    )


def bake_steps(
    scene: bpy.types.Scene,
    name: str,
    spec: BakeSpec,
    folder: Path,
    *,
    view_layer: str | None = None,
    preview: Filter | None = None,
    overwrite: bool = False,
    resume: bool = False,
    thumbnail: Thumbnail | None = None,
    unwraps: Unwraps | None = None,
) -> Generator[Progress, None, BakeResult]:
    """Bake the mesh object `name` as `scene`'s `view_layer` renders it (the first that does, if None).

    Where the specification has `objects`, these are baked, and `name` is what their atlas is called; where it
    has a split, it has a part, too.

    Writes `<name>.<kind>.json` and `.exr` into `folder`, or in the shared layout `<name>.<kind>.<layer>.exr`,
    and with a `preview` filter `<name>.preview.blend`; the shared layout has but one filter. Yields progress;
    returns the result. The scene is what it was afterwards, also after an error or when the generator is
    closed. What is finished of a bake lies in `<name>.<kind>.radtex-unfinished` until all of it is: with
    `resume` the bake goes on from there, without it needs `overwrite` to begin anew. The `thumbnail` is shown
    what comes in. `unwraps` are those of earlier bakes, such as other frames', and learn of this one's. A
    frame's files are `<name>-<frame>.…`, the frame in four digits. Raises InputError for what cannot be
    baked, or resumed, BakeError for what fails meanwhile.
    """
    check_part(name, spec)
    files = OutputFiles.of(name, spec, folder, preview is not None)
    warnings = check_request(scene, name, spec, folder, preview is not None, overwrite, view_layer, resume)
    for warning in warnings:
        log.warning(warning)
    watch = Stopwatch()
    with open_checkpoint(name, spec, files, resume, overwrite) as checkpoint:
        try:
            with at_frame(scene, spec.frame), new_data_removed():
                baked = yield from bake_and_keep(
                    scene, name, spec, files, view_layer, watch, checkpoint, thumbnail, unwraps
                )
                if preview is not None:
                    yield watch.start(Stage.PREVIEW)
                    save_preview_of(scene, spec, baked.made.files, baked.prepared, preview, view_layer)
        except InputError:  # there is nothing to go on with: another try asks for something else
            checkpoint.drop_own()
            raise
        checkpoint.remove()
    watch.stop()
    made = baked.made
    return BakeResult(
        files=made.files,
        layout=made.layout,
        covered_texels=made.covered_texels,
        islands=baked.prepared.islands,
        paths=made.paths,
        device=baked.device,
        clamped=made.clamped,
        fireflies=made.fireflies,
        condensed=made.condensed,
        seconds=watch.seconds,
    )


@dataclass(frozen=True, eq=False)
class Baked:
    """What is on disk, and the mesh that it belongs to."""

    made: Made
    prepared: Prepared
    device: str


def bake_and_keep(
    scene: bpy.types.Scene,
    name: str,
    spec: BakeSpec,
    files: OutputFiles,
    view_layer: str | None,
    watch: Stopwatch,
    keeper: Keeper = KEEPS_NOTHING,
    thumbnail: Thumbnail | None = None,
    unwraps: Unwraps | None = None,
    baker: Baker | None = None,
) -> Generator[Progress, None, Baked]:
    """Bake as `bake_steps` does, without its checks; the baked mesh stays, for the caller to remove.

    Another `baker` than that of the specification may make something else of what was prepared.
    """
    kept: list[bpy.types.ID] = []
    with (
        one_blas_thread(),
        temporary_folder() as temporary,
        scratch_scene(scene, view_layer, kept) as scratch,
        use_device(scratch, spec.device) as device,  # before the unwrap, which may take long
    ):
        originals = [find_object(scratch, each) for each in spec.objects or (name,)]
        if spec.frame is not None:
            check_seen(scratch, find_view_layer(scratch, None), originals, spec)
        keeper.expect({"device": device})
        if spec.view is View.CAMERA:
            keeper.expect({"camera's place": str(find_eye(scratch))})
        prepared = yield from watch.over(prepare(scratch, originals, spec, kept, keeper, unwraps, name))
        if prepared.source is not None:
            show_content_only(scratch, prepared.original, EVERYTHING)
        if spec.cage is not None:
            take_cage_out(scratch, spec.cage)
        if spec.lights:
            light_only(scratch, spec.lights)
        bake = baker or _baker(spec)
        steps = bake(scratch, spec, files, prepared, temporary, keeper, thumbnail)
        made = yield from watch.over(steps)
    return Baked(made, prepared, device)


def _baker(spec: BakeSpec) -> Baker:
    if spec.kind is Kind.TRANSFER:
        return bake_transfer
    if spec.kind in OCCLUSION:
        return bake_occlusion
    return bake_shared if spec.layout is Layout.SHARED else bake_buckets
