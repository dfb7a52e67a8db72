# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake from its first check to its preview and exports."""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection, Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import bpy

from ..bake.announce import publish_earlier
from ..bake.checkpoint import Checkpoint
from ..bake.pending_files import named_by_places
from ..bake.piece_store import NO_STORE, PieceStore
from ..bake.progress import Progress, Stage, finished
from ..bake.spec import BakeSpec, View
from ..bake.stopwatch import Stopwatch
from ..bake.thumbnail import Thumbnail
from ..core.atlas import AtlasLayout
from ..core.blas import one_blas_thread
from ..core.errors import InputError, RadTexError
from ..core.sampler import Filter
from ..cycles.device import use_device
from ..export.run import export_steps
from ..formats.disk.temporary import temporary_folder
from ..formats.sidecar import read_facts
from ..forms import form_for
from ..forms.bake_job import BakeJob
from ..forms.outcome import Condensed, Outcome
from ..prepare.prepared import Prepared, prepare
from ..prepare.unwrapping import Unwraps
from ..scene.eye import find_eye
from ..scene.frames import at_frame
from ..scene.lights.lamps import light_only
from ..scene.mesh.cage import take_cage_out
from ..scene.objects import find_object
from ..scene.proxy_content import EVERYTHING, show_content_only
from ..scene.scratch import find_view_layer, new_data_removed, scratch_scene
from ..textures.progress import Step
from ..textures.spec import ExportSpec, Target
from .bake_output import BakeOutput
from .checks import check_request, check_seen
from .files import OutputFiles
from .finished import images_of, is_there, misses_preview, missing_exports
from .parts import check_part
from .previews import save_preview_of
from .unfinished import open_checkpoint

log = logging.getLogger(__name__)

Baker: TypeAlias = Callable[[BakeJob], Generator[Progress, None, Outcome]]
BakeSteps: TypeAlias = "Generator[Progress | Step, None, BakeResult]"


@dataclass(frozen=True)
class BakeResult:
    """What a bake made, and what it took: `paths` are camera paths, `seconds` are by stage.

    `fireflies` is the share of the light that a fit lost: single paths brought it, and no others. `condensed`
    says what was chosen for a budget or a target. `exported` are the folders that were made. A bake that
    `was_there` got what was missing beside it: of its paths and covered texels nothing is known.
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
    exported: tuple[Path, ...] = ()
    was_there: bool = False

    @classmethod
    def of(
        cls, made: BakeOutput, seconds: dict[Stage, float], exported: tuple[Path, ...], was_there: bool
    ) -> BakeResult:
        return cls(
            files=made.files,
            layout=made.layout,
            covered_texels=made.covered_texels,
            islands=made.islands,
            paths=made.paths,
            device=made.device,
            clamped=made.clamped,
            fireflies=made.fireflies,
            condensed=made.condensed,
            seconds=seconds,
            exported=exported,
            was_there=was_there,
        )


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
    exports: Collection[Target] = (),
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
            exports=exports,
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
    exports: Collection[Target] = (),
) -> BakeSteps:
    """Bake the mesh object `name` as `scene`'s `view_layer` renders it (the first that does, if None).

    Where the specification has `objects`, these are baked, and `name` is what their atlas is called; where it
    has a split, it has a part, too.

    Writes `<name>.<kind>.json` and `.exr` into `folder`, or in the shared layout `<name>.<kind>.<layer>.exr`,
    and with a `preview` filter `<name>.preview.blend`; the shared layout has but one filter. From these it
    makes the `exports`, folders `<name>.<target>`. Yields progress; returns the result. The scene is what it
    was afterwards, also after an error or when the generator is closed. What is finished of a bake lies in
    `<name>.<kind>.radtex-unfinished` until all of it is, its exports among it: with `resume` the bake goes on
    from there, and where it is finished but lacks its preview or exports, these are made; without it needs
    `overwrite` to begin anew. The `thumbnail` is shown what comes in. `unwraps` are those of earlier bakes,
    such as other frames', and learn of this one's. A frame's files are `<name>-<frame>.…`, the frame in four
    digits. Raises InputError for what cannot be baked, or resumed, BakeError for what fails meanwhile.
    """
    check_part(name, spec)
    files = OutputFiles.of(name, spec, folder, preview is not None)
    warnings = check_request(
        scene, name, spec, folder, preview is not None, overwrite, view_layer, resume, exports
    )
    for warning in warnings:
        log.warning(warning)
    was_there = is_there(files, overwrite, resume)
    targets = missing_exports(files, exports) if was_there else tuple(exports)
    shown = None if was_there and not misses_preview(files) else preview
    if not resume:
        publish_earlier(files.unfinished)
    earlier = frozenset() if was_there else images_of(files.sidecar)
    watch = Stopwatch()
    with (
        open_checkpoint(name, spec, files, resume, overwrite, targets) as checkpoint,
        errors_by_places(files),
    ):
        try:
            known = _made_before(checkpoint, files, was_there)
            made = known
            if known is None or shown is not None:
                baker = None if known is None else _no_baker(known)
                with at_frame(scene, spec.frame), new_data_removed():
                    baked = yield from bake_and_keep(
                        scene, name, spec, files, view_layer, watch, checkpoint, thumbnail, unwraps, baker
                    )
                    made = baked.made
                    if known is None:
                        publish(checkpoint, files, made, earlier)
                    if shown is not None:
                        yield watch.start(Stage.PREVIEW)
                        save_preview_of(scene, spec, made.files, baked.prepared, shown, view_layer)
            watch.stop()
            assert made is not None  # it was known, or baked
            exported = yield from _export(files, targets, overwrite or resume)  # as was checked
        except InputError:  # there is nothing to go on with: another try asks for something else
            checkpoint.drop_own()
            raise
        checkpoint.remove()
    return BakeResult.of(made, watch.seconds, exported, was_there)


@contextmanager
def errors_by_places(files: OutputFiles) -> Iterator[None]:
    """Let errors name files by the places that they are to have, not by where they wait."""
    try:
        yield
    except RadTexError as error:
        said = named_by_places(str(error), files.unfinished)
        if said == str(error):
            raise
        raise type(error)(said) from error


def _made_before(checkpoint: Checkpoint, files: OutputFiles, was_there: bool) -> BakeOutput | None:
    """What a bake came to whose files are all written, which are in their places then; None for another."""
    told = BakeOutput.known(files).told() if was_there else checkpoint.made
    if told is None:
        return None
    known = BakeOutput.of(told, files)
    publish(checkpoint, files, known, BakeOutput.replaced(told, files))
    return known


def publish(
    checkpoint: Checkpoint, files: OutputFiles, made: BakeOutput, earlier: Collection[Path] = ()
) -> None:
    """Give all files their places, and remove those that an overwritten bake had and this one has not.

    These are images that this layout may have, and the `earlier` bake's, which may be in another layout.
    """
    checkpoint.publish(made.told(earlier))
    for path in {*files.images, *earlier} - set(made.files.images):
        path.unlink(missing_ok=True)


def _no_baker(known: BakeOutput) -> Baker:
    """In a baker's place, for a bake that is done. Raises InputError for a mesh that is another now."""

    def bake(job: BakeJob) -> Generator[Progress, None, Outcome]:
        if read_facts(job.sidecar).values.get("mesh") != job.prepared.digest:
            raise InputError(
                f"object '{job.prepared.name}' or its unwrap is no longer what {job.sidecar} is of, so that "
                "no preview can be made: bake it anew (--overwrite)"
            )
        yield from ()
        return known.outcome

    return bake


def _export(
    files: OutputFiles, targets: Collection[Target], overwrite: bool
) -> Generator[Step, None, tuple[Path, ...]]:
    """Make a folder for each target of the bake with these files."""
    made = []
    for target in targets:
        steps = export_steps(files.sidecar, ExportSpec(target), overwrite=overwrite)
        made.append((yield from steps).folder)
    return tuple(made)


@dataclass(frozen=True, eq=False)
class Baked:
    """What is on disk, and the mesh that it belongs to."""

    made: BakeOutput
    prepared: Prepared


def bake_and_keep(
    scene: bpy.types.Scene,
    name: str,
    spec: BakeSpec,
    files: OutputFiles,
    view_layer: str | None,
    watch: Stopwatch,
    store: PieceStore = NO_STORE,
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
        store.set_facts({"device": device})
        if spec.view is View.CAMERA:
            store.set_facts({"camera's place": str(find_eye(scratch))})
        prepared = yield from watch.over(prepare(scratch, originals, spec, kept, store, unwraps, name))
        if prepared.source is not None:
            show_content_only(scratch, prepared.original, EVERYTHING)
        if spec.cage is not None:
            take_cage_out(scratch, spec.cage)
        if spec.lights:
            light_only(scratch, spec.lights)
        bake = baker or form_for(spec).bake
        job = BakeJob(scratch, spec, files.sidecar, prepared, temporary, store, thumbnail)
        outcome = yield from watch.over(bake(job))
    return Baked(BakeOutput.by(outcome, files, device, prepared.islands), prepared)
