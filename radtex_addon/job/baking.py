# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake from its first check to its preview and exports."""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection, Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TypeAlias

import bpy

from ..bake.piece_store import NO_STORE, PieceStore
from ..bake.progress import Progress, Stage, Stopwatch, finished
from ..bake.thumbnail import Thumbnail
from ..core.blas import one_blas_thread
from ..core.errors import InputError
from ..core.messages import Setting, do
from ..core.near_digest import is_same
from ..core.sampler import Filter
from ..cycles.device import use_device
from ..export.exporting import export_steps
from ..formats.disk.temporary import temporary_folder
from ..formats.fingerprint import Fingerprint
from ..formats.sidecar import check_readable
from ..formats.sidecar_file import read_facts
from ..forms import form_for
from ..forms.bake_job import BakeJob
from ..forms.outcome import Outcome
from ..prepare.map_checks import wasteful_map
from ..prepare.prepared import Prepared, prepare
from ..prepare.unwrapping import COUNTED, Unwraps
from ..preview.kept_copies import copies_not_rendered
from ..preview.swap import previews_not_rendered
from ..scene.camera_place import find_camera_place
from ..scene.lights.lamps import light_only, lit_by_lamps_alone
from ..scene.mesh.cage import take_cage_out
from ..scene.objects import find_object
from ..scene.proxy_content import EVERYTHING, show_content_only
from ..scene.regroup import leave_alone
from ..scene.scratch import at_frame, find_view_layer, new_data_removed, scratch_scene
from ..settings.cost import check_disk, check_memory
from ..settings.spec import BakeSpec, View
from ..store.bake_folder import BakeFolder
from ..store.output_files import BakeOutput, OutputFiles
from ..store.ownership import Overwrite, open_blend
from ..textures.export_spec import ExportSpec, ExportStep, Target
from .bake_fingerprint import fingerprint_of_bake, read_originals
from .checks import check_request, check_seen
from .previews import save_preview_of
from .split_parts import check_part
from .variants import named_in

log = logging.getLogger(__name__)

Baker: TypeAlias = Callable[[BakeJob], Generator[Progress, None, Outcome]]
BakeSteps: TypeAlias = "Generator[Progress | ExportStep, None, BakeResult]"


@dataclass(frozen=True)
class BakeResult(BakeOutput):
    """The result of a bake, and what this run of it cost: `seconds` are by stage.

    `paths` are camera paths; the UV layer has so many `islands`, which cover a share of it, the `coverage`;
    `wasteful` says why the map wastes its atlas, empty if it does not; `density` is the texels per metre that
    it has, if its size follows from a density. `exported` are the folders that were made. If the bake
    `was_finished`, only its missing preview and exports were made, and paths and covered texels are 0: they
    are not known. `triangles` of the baked surface are None where none was evaluated.
    """

    seconds: dict[Stage, float] = field(default_factory=dict)
    exported: tuple[Path, ...] = ()
    was_finished: bool = False
    triangles: int | None = None


def bake_object(
    scene: bpy.types.Scene,
    name: str,
    spec: BakeSpec,
    folder: Path,
    *,
    view_layer: str | None = None,
    preview: Filter | None = None,
    overwrite: bool | Overwrite = False,
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
    overwrite: bool | Overwrite = False,
    resume: bool = False,
    thumbnail: Thumbnail | None = None,
    unwraps: Unwraps | None = None,
    exports: Collection[Target] = (),
) -> BakeSteps:
    """Bake the mesh object `name` as it renders in `scene`'s `view_layer` (if None, the first that renders).

    If the specification has `objects`, these are baked, and `name` is their atlas's name. If it has a split,
    it must have a part.

    Writes `<name>.<kind>.json` and `.exr` into `folder`, or if layered `<name>.<kind>.<layer>.exr`, and with
    a `preview` filter `<name>.preview.blend`; the layered layout has only one filter. Then makes the
    `exports`, folders `<name>.<target>`. A frame's files are `<name>-<frame>.…`, the frame in four digits.

    Yields progress; returns the result. The scene is unchanged afterwards, also after an error or when the
    generator is closed. Finished pieces are in `<name>.<kind>.radtex-unfinished` until all is done, exports
    included. With `resume` the bake continues from there; if it is finished, only a missing preview and
    exports are made. Without `resume` an unfinished bake is replaced only with `overwrite`. An `Overwrite` in
    place of True keeps better bakes and those of other files; one of another object is never replaced. The
    `thumbnail` gets the captured light. `unwraps` are those of earlier bakes, such as other frames'; this
    bake's is added. Raises InputError for what cannot be baked or resumed, BakeError for what fails during
    the bake.
    """
    check_part(name, spec)
    overwrite = Overwrite.of(overwrite)
    spec = named_in(scene, spec, overwrite.blend)
    place = BakeFolder(name, spec, folder, preview is not None)
    files = place.files
    warnings = check_request(
        scene, name, spec, folder, preview is not None, overwrite, view_layer, resume, exports
    )
    for warning in warnings:
        log.warning(warning)
    was_finished = place.only_completes(bool(overwrite), resume)
    targets = place.missing_exports(exports) if was_finished else tuple(exports)
    shown = None if was_finished and not place.misses_preview() else preview
    watch = Stopwatch()
    with place.open(overwrite, resume, targets) as checkpoint:
        try:
            known = place.publish_again(checkpoint, was_finished)
            made, triangles = known, None
            if known is None or shown is not None:
                baker = None if known is None else finished_baker(known)
                with at_frame(scene, spec.frame), new_data_removed():
                    baked = yield from bake_unchecked(
                        scene,
                        name,
                        spec,
                        files,
                        view_layer,
                        watch,
                        checkpoint,
                        thumbnail,
                        unwraps,
                        baker,
                        blend=overwrite.blend,
                    )
                    made, triangles = baked.made, len(baked.prepared.surface.triangles)
                    if known is None:
                        place.publish(checkpoint, made)
                    if shown is not None:
                        yield watch.start(Stage.PREVIEW)
                        save_preview_of(scene, spec, made.files, baked.prepared, shown, view_layer)
            watch.stop()
            assert made is not None  # it was known before, or was just baked
            replaces = bool(overwrite) or resume  # check_request has checked it
            exported = yield from _export(files, targets, replaces)
        except InputError:  # the next try needs other settings, and could not resume this one
            checkpoint.drop_own()
            raise
        checkpoint.remove()
    return BakeResult(
        **vars(made),
        seconds=watch.seconds,
        exported=exported,
        was_finished=was_finished,
        triangles=triangles,
    )


def finished_baker(known: BakeOutput) -> Baker:
    """A baker for a finished bake: bakes nothing. It raises InputError if the mesh has changed since."""

    def bake(job: BakeJob) -> Generator[Progress, None, Outcome]:
        if not is_same(str(read_facts(job.sidecar).values.get("mesh")), job.prepared.digest):
            raise InputError(
                f"object '{job.prepared.name}' or its unwrap is no longer what {job.sidecar} is of, so that "
                "no preview can be made",
                do("bake it anew", Setting.OVERWRITE),
            )
        yield from ()
        return known.outcome

    return bake


def _export(
    files: OutputFiles, targets: Collection[Target], overwrite: bool
) -> Generator[ExportStep, None, tuple[Path, ...]]:
    """Make a folder for each target of the bake with these files."""
    made = []
    for target in targets:
        steps = export_steps(files.sidecar, ExportSpec(target), overwrite=overwrite)
        made.append((yield from steps).folder)
    return tuple(made)


@dataclass(frozen=True, eq=False)
class Baked:
    """The result of a bake, the prepared objects that it belongs to, and the specification of their size."""

    made: BakeOutput
    prepared: Prepared
    spec: BakeSpec


def bake_unchecked(
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
    warns: bool = True,
    blend: Path | None = None,
    fingerprint: Fingerprint | None = None,
) -> Generator[Progress, None, Baked]:
    """Bake as `bake_steps` does, but without checks, preview and exports; the caller removes the baked mesh.

    Where a bake of another object is shown in its place, the object is rendered, not its stored light. A
    `baker` replaces that of the specification's form, to make something else of the prepared objects. It
    `warns` of a UV map that wastes its atlas. `blend` is the scene's file, None for the open one.
    The scene may be a copy of one with a `fingerprint` that was read before.
    """
    kept: list[bpy.types.ID] = []
    with (
        one_blas_thread(),
        temporary_folder() as temporary,
        scratch_scene(scene, view_layer, kept) as scratch,
        copies_not_rendered(scratch),
        previews_not_rendered(scratch),
        use_device(scratch, spec.device) as device,  # before the unwrap, which may take long
    ):
        originals = [find_object(scratch, each) for each in spec.objects or (name,)]
        if spec.alone:
            leave_alone(scratch, {*(spec.objects or (name,)), spec.source, spec.cage})
        if spec.frame is not None:
            check_seen(scratch, find_view_layer(scratch, None), originals, spec)
        store.set_facts({"device": device})
        if spec.view is View.CAMERA:
            store.set_facts({"camera's place": str(find_camera_place(scratch))})
        prepared = yield from watch.over(
            prepare(scratch, originals, spec, kept, store, unwraps, name, spec.form.backs)
        )
        now, layer = read_originals(scratch), find_view_layer(scratch, None)
        prepared = replace(
            prepared,
            fingerprint=fingerprint or fingerprint_of_bake(now, layer, name, spec, files),
            scene="" if spec.lights or spec.alone else f"{now.whole} {scratch.frame_current_final} {device}",
            blend=(open_blend() if blend is None else blend).name,
        )
        check_readable(prepared.facts(spec))
        if spec.density is not None:
            spec = prepared.sized(spec)
            check_memory(spec)
            check_disk(spec, files.sidecar.parent)
        if warns:
            _warn_of_map(prepared, spec)
        if thumbnail is not None and len(prepared.surface.triangles) <= COUNTED:
            thumbnail.draw_map(prepared.uv_map)
        if prepared.source is not None:
            show_content_only(scratch, prepared.original, EVERYTHING)
        if spec.cage is not None:
            take_cage_out(scratch, spec.cage)
        bake = baker or form_for(spec).bake
        job = BakeJob(scratch, spec, files.sidecar, prepared, temporary, store, thumbnail)
        with _lit(scratch, spec):
            outcome = yield from watch.over(bake(job))
    made = BakeOutput.by(outcome, files, device, prepared.facts(spec))
    return Baked(made, prepared, spec)


def _warn_of_map(prepared: Prepared, spec: BakeSpec) -> None:
    warning = wasteful_map(prepared.name, prepared.wasteful, prepared.uv_layer, spec)
    if warning is not None:
        log.warning(warning)


@contextmanager
def _lit(scratch: bpy.types.Scene, spec: BakeSpec) -> Iterator[None]:
    """Light the scratch scene by the lamps that the specification names, if any."""
    if not spec.lights:
        yield
    elif spec.form.by_paths:  # it needs the passes of lobes, which Cycles does not split by light groups
        with lit_by_lamps_alone(scratch, spec.lights):
            yield
    else:
        light_only(scratch, spec.lights)
        yield
