# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Assemble a farm's frames to the atlas that a local bake would have made."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ..bake.progress import Stage, Stopwatch
from ..core.errors import FormatError, InputError
from ..formats.containers.numpy_files import read_npz
from ..formats.disk.atomic import check_writable
from ..formats.disk.temporary import temporary_folder
from ..formats.json_reader import shown
from ..forms.buckets.bake import join_buckets
from ..job.baking import BakeResult
from ..job.previews import save_preview_of
from ..prepare.prepared import BakedCopy
from ..scene.mesh.copy import MATRIX
from ..settings.spec import BakeSpec
from ..store.bake_folder import BakeFolder, FolderState
from ..store.output_files import BakeOutput, OutputFiles
from ..store.ownership import Overwrite
from .farm_files import FarmFiles
from .farm_manifest import Copies, FarmManifest, check_files, read_manifest, read_plan
from .farm_progress import AnyStep
from .rendered_frames import FarmCapture, check_frames

_FARM = "the farm's job"  # in a key: which frames are joined


@dataclass(frozen=True)
class Assembled:
    """The result, and the specification of the bake."""

    name: str
    spec: BakeSpec
    result: BakeResult


def assemble_steps(
    folder: Path, out: Path | None = None, *, overwrite: bool = False, overwrite_any: bool = False
) -> Generator[AnyStep, None, Assembled]:
    """Check the frames of the farm in `folder`, and write what a local bake would.

    The files go into `out`, by default beside the farm's folder. Nothing is evaluated or rendered. If a
    preview was asked for, **another .blend is open afterwards**. `overwrite` replaces no better bake and none
    of another .blend without `overwrite_any`. Yields progress. Raises FormatError for a folder without a
    complete farm, InputError for files that would be overwritten, BakeError, with their names, for missing
    or unusable frames; then nothing is written.
    """
    files = FarmFiles(folder)
    manifest = read_manifest(files)
    check_files(files, manifest)
    spec, copies = manifest.spec, manifest.copies
    out = folder.absolute().parent if out is None else out
    place = BakeFolder(manifest.name, spec, out, copies is not None)
    outputs = place.files
    check_writable(out)
    begun = _was_begun(place, manifest)  # nothing was rendered: to begin anew is as good as to go on
    replaces = Overwrite(overwrite or begun, overwrite_any or begun, Path(manifest.facts.blend))
    place.check_may_write(replaces)
    plan, hidden = read_plan(files, manifest)
    yield from check_frames(files, manifest)
    watch = Stopwatch()
    capture = FarmCapture(files, manifest, plan)
    # Cells are more than memory may hold.
    with place.open(replaces) as cells, temporary_folder() as temporary:
        cells.set_facts({_FARM: manifest.job})
        try:
            sidecar = outputs.sidecar
            outcome = yield from watch.over(
                join_buckets(plan, capture, hidden, spec, sidecar, manifest.facts, temporary, cells)
            )
            made = BakeOutput.by(outcome, outputs, manifest.device, manifest.facts)
            place.publish(cells, made)
            if copies is not None:
                yield watch.start(Stage.PREVIEW)
                _save_preview(files, manifest, copies, outputs)
        except BaseException:
            if cells.made is None:  # else its files are being moved: assembling again goes on with that
                cells.drop_own()
            raise
        cells.drop_own()
    watch.stop()
    return Assembled(manifest.name, spec, BakeResult(**vars(made), seconds=watch.seconds))


def _was_begun(place: BakeFolder, manifest: FarmManifest) -> bool:
    """Whether a killed process left an unfinished assembly of the same frames."""
    if place.state is not FolderState.UNFINISHED:
        return False
    try:
        return place.begun_facts().get(_FARM) == manifest.job
    except InputError:  # it has no key that can be read: so it is not taken for ours
        return False


@dataclass(frozen=True, eq=False)
class _Copied:
    """What the preview needs of a bake whose baked copies were saved."""

    name: str
    pieces: tuple[BakedCopy, ...]
    uv_layer: str
    digest: str
    parts: tuple[str, ...]


def _save_preview(files: FarmFiles, manifest: FarmManifest, copies: Copies, outputs: OutputFiles) -> None:
    """Save the preview. Raises FormatError if the .blend does not have what the manifest lists."""
    try:
        bpy.ops.wm.open_mainfile(filepath=str(files.preview.absolute()), load_ui=False, use_scripts=False)
        scene = _named(files, bpy.data.scenes, "scene", copies.scene)
        pieces = []
        for number, (name, mesh_name) in enumerate(zip(copies.objects, copies.meshes, strict=True)):
            item = _named(files, scene.objects, "object", name)
            mesh = _named(files, bpy.data.meshes, "mesh", mesh_name)
            mesh.use_fake_user = False
            matrix = np.array(mesh[MATRIX], dtype=np.float64).reshape(4, 4)
            part = _part(files, number, mesh, copies) if manifest.spec.split is not None else None
            pieces.append(BakedCopy(item, mesh, matrix, part))
        facts = manifest.facts
        copied = _Copied(manifest.name, tuple(pieces), facts.uv_map, facts.mesh, copies.parts)
        save_preview_of(scene, manifest.spec, outputs, copied, copies.filter, copies.view_layer)
    except (LookupError, TypeError, ValueError, AttributeError, RuntimeError) as error:
        raise FormatError(
            f"{files.preview} holds other things than {files.manifest} says "
            f"({' '.join(str(error).split())}): prepare the farm anew"
        ) from error


def _named(files: FarmFiles, blocks: Any, what: str, name: str) -> Any:
    """The data-block of that name. Raises FormatError if there is none."""
    try:
        found = blocks.get(name)
    except SystemError:  # Blender's answer to a name that is no Unicode
        found = None
    if found is None:
        raise FormatError(f"{files.preview} holds no {what} '{shown(name)}': prepare the farm anew")
    return found


def _part(files: FarmFiles, number: int, mesh: Any, copies: Copies) -> Any:
    """The part of each of a copy's triangles. Raises FormatError."""
    key, count = f"arr_{number}", len(mesh.polygons)
    part = read_npz(files.parts, {key: "iu"}, 8 * count)[key]
    if part.shape != (count,) or (count and not 0 <= part.min() <= part.max() < len(copies.parts)):
        raise FormatError(
            f"{files.parts} tells of parts that mesh '{mesh.name}' has not: prepare the farm anew"
        )
    return part
