# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Do a bake up to its first ray, and write a folder whose frames any farm can render."""

from __future__ import annotations

import logging
import secrets
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ..bake.plan import CapturePlan
from ..bake.progress import Progress, Stopwatch
from ..core.errors import BakeError, InputError
from ..core.messages import Setting, do
from ..core.sampler import Filter
from ..formats.disk.regular import digest
from ..formats.disk.temporary import hidden_folder
from ..formats.sidecar import Sidecar
from ..forms.bake_job import BakeJob
from ..forms.buckets.bake import capture_of, plan_buckets
from ..forms.outcome import Outcome
from ..job.baking import Baked, bake_unchecked
from ..job.checks import check_request
from ..job.split_parts import check_part
from ..job.variants import named_in
from ..scene.digests import Looks
from ..scene.scratch import at_frame, new_data_removed
from ..settings.spec import BakeSpec
from ..store.output_files import OutputFiles
from ..store.ownership import Overwrite
from .blend import SheetFrames, check_images_saved, check_seed, finish_blend, save_draft
from .farm_files import OUTPUT, FarmFiles, is_farm
from .farm_manifest import Copies, FarmManifest, check_farmable, check_frame_count, write_plan
from .farm_progress import AnyStep, FarmStep, FarmTask
from .freeze_scene import Held, check_holdable
from .self_contained import Carried, pack_files
from .templates import write_templates

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class Farm:
    """A prepared farm: `beside` are the files that its .blend needs beside it.

    `carried` are the files of this machine that were copied into the folder, in the .blend or beside it.
    """

    files: FarmFiles
    manifest: FarmManifest
    texels: int
    beside: tuple[str, ...]
    carried: tuple[Carried, ...]


@dataclass(eq=False)
class _Draft:
    """What the bake would capture, known after the preparation."""

    path: Path
    plan_path: Path
    found: list[tuple[CapturePlan, Sidecar, Looks, Held, str]] = field(default_factory=list)

    def bake(self, job: BakeJob) -> Generator[Progress, None, Outcome]:
        """Set the capture up as a bake does, and save it instead of rendering."""
        scratch, spec, prepared = job.scratch, job.spec, job.prepared
        texels = prepared.texels()
        plan, hidden, facts = yield from plan_buckets(scratch, spec, prepared, texels, job.folder, job.store)
        check_seed(spec.seed, plan.sheets)
        check_frame_count(plan.sheets)
        capture_of(scratch, plan, spec, job.folder, whole=True)
        looks, cached = save_draft(scratch, self.path)
        write_plan(self.plan_path, plan, hidden)
        self.found.append((plan, facts, looks, cached, scratch.name))
        count = len(plan.texel)
        return Outcome((), plan.layout, count, count * spec.bucket**2 * spec.samples, 0)


def prepare_steps(
    scene: bpy.types.Scene,
    name: str,
    spec: BakeSpec,
    folder: Path,
    *,
    view_layer: str | None = None,
    preview: Filter | None = None,
    overwrite: bool | Overwrite = False,
) -> Generator[AnyStep, None, Farm]:
    """Write `<name>.<kind>.radtex-farm` into `folder`, of what `bake_steps` would bake.

    Yields progress. No file of the user's changes, but **the session is empty afterwards**: Blender has to
    open the farm's. On failure nothing is left in the folder. Raises InputError for what cannot be baked, or
    not by a farm, BakeError for what fails meanwhile.
    """
    check_part(name, spec)
    check_farmable(spec)
    spec = named_in(scene, spec, overwrite.blend if isinstance(overwrite, Overwrite) else None)
    files = OutputFiles.of(name, spec, folder, preview is not None)
    for warning in check_request(scene, name, spec, folder, preview is not None, overwrite, view_layer):
        log.warning(warning)
    check_images_saved()
    check_holdable(scene)
    farm = FarmFiles.of(files.sidecar)
    with replacing_folder(farm.folder, bool(overwrite)) as place:
        inside = FarmFiles(place)
        inside.frames.mkdir()
        draft = _Draft(place / "draft.blend", inside.plan)
        with at_frame(scene, spec.frame), new_data_removed():
            baked = yield from bake_unchecked(
                scene, name, spec, files, view_layer, Stopwatch(), baker=draft.bake
            )
            copies = (
                None if preview is None else _save_copies(scene, spec, baked, inside, preview, view_layer)
            )
        yield FarmStep(FarmTask.HOLD, 0, 1)
        plan, facts, looks, cached, scene_name = draft.found[0]
        manifest = _manifest(name, baked.spec, plan, facts, baked, copies, inside)
        packed = finish_blend(
            draft.path, scene_name, inside.blend, _frames(manifest), looks, cached,
            partial(pack_files, inside.folder),
        )  # fmt: skip
        manifest = replace(manifest, carried=packed.carried)
        draft.path.unlink()
        write_templates(inside, manifest)
        inside.manifest.write_text(manifest.to_json(), encoding="utf-8", newline="\n")
    return Farm(farm, manifest, baked.made.covered_texels, packed.beside, packed.carried)


def _manifest(
    name: str,
    spec: BakeSpec,
    plan: CapturePlan,
    facts: Sidecar,
    baked: Baked,
    copies: Copies | None,
    files: FarmFiles,
) -> FarmManifest:
    needed = [files.plan, *(path for path in (files.preview, files.parts) if path.exists())]
    return FarmManifest(
        job=secrets.token_hex(16),
        name=name,
        spec=spec,
        facts=facts,
        sheets=plan.sheets,
        columns=plan.columns,
        rows=plan.rows,
        sheet_rows=plan.sheet_rows,
        sheet_side=plan.sheet,
        device=baked.made.device,
        islands=baked.prepared.islands,
        digests={path.name: digest(path) for path in needed},
        copies=copies,
    )


def _frames(manifest: FarmManifest) -> SheetFrames:
    return SheetFrames(range(manifest.sheets), manifest.sheet_rows, manifest.spec.seed, OUTPUT, manifest.note)


def _save_copies(
    scene: bpy.types.Scene,
    spec: BakeSpec,
    baked: Baked,
    files: FarmFiles,
    preview: Filter,
    view_layer: str | None,
) -> Copies:
    """Save the user's scene with the baked copies' meshes, from which the preview is made later."""
    prepared = baked.prepared
    meshes: list[Any] = [piece.mesh for piece in prepared.pieces]
    for mesh in meshes:
        mesh.use_fake_user = True
    try:
        bpy.ops.wm.save_as_mainfile(
            filepath=str(files.preview), copy=True, relative_remap=True, compress=True
        )
    except RuntimeError as error:
        raise BakeError(
            f"{files.preview}: Blender cannot write it ({error}); choose another folder"
        ) from error
    if spec.split is not None:
        np.savez_compressed(files.parts, *(piece.part for piece in prepared.pieces if piece.part is not None))
    return Copies(
        objects=spec.objects or (prepared.name,),
        meshes=tuple(mesh.name for mesh in meshes),
        scene=scene.name,
        view_layer=view_layer,
        parts=prepared.parts,
        filter=preview,
    )


@contextmanager
def replacing_folder(folder: Path, overwrite: bool) -> Iterator[Path]:
    """Yield a new folder that gets the farm's name on success, and is deleted on failure.

    An earlier farm, of frames or of tasks, is replaced as a whole, or kept.
    """
    if folder.exists() and not (overwrite and is_farm(folder)):
        raise InputError(
            f"{folder} is already there",
            do("overwrite it", Setting.OVERWRITE),
            do("choose another folder", Setting.OUT),
        )
    try:
        with hidden_folder(folder.parent) as hidden:
            place, earlier = hidden.with_suffix(".new"), hidden / "earlier"  # paths in .blends are relative
            place.mkdir()
            yield place.absolute()
            if folder.exists():
                folder.rename(earlier)  # it goes with the hidden folder
            try:
                place.rename(folder)
            except OSError:
                if earlier.exists():
                    earlier.rename(folder)
                raise
    except OSError as error:
        raise BakeError(
            f"{folder} could not be written: {error.strerror or error}; choose another folder"
        ) from error
