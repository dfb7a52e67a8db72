# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The form of kind `transfer`: one image of buckets that hold the whole sphere, of one view or several.

The object is captured under suns all around, and each texel's bucket fitted to that light.
"""

from __future__ import annotations

from collections.abc import Collection, Generator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ...bake.denoising import Denoiser, denoise_pictures, squares
from ...bake.plan import CapturePlan
from ...bake.progress import Progress, Stage
from ...bake.transfer_buckets import fit_buckets, mean_over_lights, view_shift
from ...core.arrays import Floats
from ...core.atlas import AtlasLayout
from ...core.errors import InputError
from ...core.messages import Setting, leave_out
from ...core.surface import SurfaceMesh
from ...core.texel_map import covered_texels
from ...cycles.denoiser import image_denoiser
from ...cycles.transfer_capture import MOST, LitTexels, capture_under_suns
from ...formats.image_files import Shapes
from ...formats.json_reader import Facts
from ...formats.sidecar import Sidecar
from ...formats.sidecar_file import SidecarFile
from ...formats.transfer_files import (
    TransferSidecar,
    open_transfer,
    read_transfer,
    read_transfer_sidecar,
    with_views,
    write_transfer,
)
from ...preview.node_group import check_previewable
from ...scene.camera_place import find_camera_place
from ...scene.scratch import scene_copied
from ...settings.forms import SPHERE, FormTraits
from ...settings.spec import BakeSpec, View
from ...textures.entry import TextureEntry
from ...textures.export_spec import Arrangement, ExportSpec, ExportStep, Target
from ...textures.flat_lightmap import check_stored
from ...textures.matrix import write_matrix
from ..bake_job import BakeJob
from ..buckets.form import Buckets, defines, has_samples_and_cells
from ..form import Form, PreviewOf
from ..hlsl_lookup import HlslLookup
from ..outcome import Outcome
from .hlsl import sphere_lookup
from .preview import add_transfer_osl_node, transfer_material

_PIXEL = 48  # bytes per pixel in an export, which reads the whole image


def write_sphere(sidecar: SidecarFile, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
    """As `Form.write_textures`."""
    check_sphere(sidecar, spec)
    image, facts = open_transfer(sidecar)
    return {facts.bake.kind: write_matrix(image, facts.stored, replace(spec, levels=1), folder)}


def check_sphere(sidecar: SidecarFile, spec: ExportSpec) -> None:
    """As `Form.check_textures`: buckets of the whole sphere are exported as a matrix without mip levels."""
    if spec.arrangement is not Arrangement.MATRIX or (spec.levels or 1) > 1:
        raise InputError(
            f"{sidecar} has one level in a matrix", leave_out(Setting.ARRANGEMENT, Setting.LEVELS)
        )


def flat_sphere(sidecar: SidecarFile, surface: SurfaceMesh) -> Floats:
    """The flat lightmap of a bake of kind `transfer`, under white surroundings; as `Form.flat`."""
    pixels, facts = read_transfer(sidecar)
    light = mean_over_lights(pixels, facts.layout, facts.views)[..., :3]
    check_stored(sidecar.path, covered_texels(surface, facts.layout.width, facts.layout.height), light)
    return light


def bake_transfer(job: BakeJob) -> Generator[Progress, None, Outcome]:
    """As `Form.bake`; every finished render is stored."""
    spec, prepared = job.spec, job.prepared
    eye = find_camera_place(job.scratch) if spec.view is View.CAMERA else None
    views = spec.view.along
    plan = yield from prepared.plan_of_seen(views, job.folder, job.store)
    suns, shift = spec.bucket**2, view_shift(plan, eye)
    with scene_copied(job.scratch) as scene:
        lit = yield from capture_under_suns(
            scene, plan, shift, suns, spec.samples, spec.seed, job.folder, job.store, job.thumbnail
        )
    facts = prepared.facts(spec)
    if spec.denoise:
        with image_denoiser(job.folder) as denoiser:
            if denoiser is not None:
                lit = yield from _denoised(plan, lit, denoiser)
                facts = replace(facts, denoised=True)
    atlas = yield from _atlas(plan, lit, spec.bucket)
    yield Progress(Stage.WRITE, 0, 1)
    layout = AtlasLayout(plan.layout.width, plan.layout.height, spec.bucket)
    place = None if eye is None else (*eye.place, 0.0 if eye.far else 1.0)
    described = TransferSidecar(facts, suns, spec.view, place, views)
    written = write_transfer(job.place, atlas, described, spec.half, spec.compression)
    count = len(plan.texel)
    paths = count * views**2 * suns * spec.samples
    return Outcome((job.sidecar.with_suffix(".exr"),), layout, count, paths, written.bake.clamped)


def _denoised(plan: CapturePlan, lit: LitTexels, denoiser: Denoiser) -> Generator[Progress, None, LitTexels]:
    """Denoise the light of each view: for each sun, the picture over texels."""
    light = np.empty_like(lit.light)
    count, views, done = len(plan.texel), light.shape[2], 0
    for square in squares(plan, len(light)):
        own = square.texels[square.own]
        for view in range(views):
            yield Progress(Stage.DENOISE, done // views, count)
            values = lit.light[:, square.texels, view].transpose(1, 0, 2)
            found = denoise_pictures(values, square.picture, denoiser)[square.own]
            light[:, own, view] = np.minimum(found, MOST).transpose(1, 0, 2)
            done += len(own)
    yield Progress(Stage.DENOISE, count, count)
    return LitTexels(light, lit.alpha)


def _atlas(plan: CapturePlan, lit: LitTexels, n: int) -> Generator[Progress, None, Floats]:
    """The image (H*k*n, W*k*n, 4) float32 of k x k views, gutter filled."""
    layout, k = plan.layout, plan.layout.bucket
    atlas = np.empty((layout.height, k, n, layout.width, k, n, 4), dtype=np.float32)
    for view in range(k * k):
        light = yield from fit_buckets(plan, lit.light[:, :, view], n)
        alpha = np.repeat(lit.alpha[:, view, None, None].astype(np.float32), n * n, axis=1)
        rgba = np.concatenate([light, alpha], axis=2).reshape(-1, n, n, 4)
        atlas[:, view // k, :, :, view % k] = plan.placed(rgba, gutter=True).transpose(0, 2, 1, 3, 4)
    return atlas.reshape(layout.height * k * n, layout.width * k * n, 4)


class Sphere(Buckets):
    """Buckets of all directions to the light, in one image: see `forms.form.Form`."""

    traits: FormTraits = SPHERE

    def bake(self, job: BakeJob) -> Generator[Progress, None, Outcome]:
        return bake_transfer(job)

    def check_previewable(self, spec: BakeSpec) -> None:
        layout = AtlasLayout(spec.texels, spec.texels, spec.bucket)
        check_previewable(with_views(layout, spec.view.along))

    def material(self, of: PreviewOf) -> bpy.types.Material:
        facts, atlas = read_transfer_sidecar(of.sidecar), of.sidecar.with_suffix(".exr")
        return transfer_material(of, atlas, facts.layout, facts.views)

    def script_node(self, tree: bpy.types.NodeTree, sidecar: SidecarFile) -> bpy.types.Node:
        facts, atlas = read_transfer_sidecar(sidecar), sidecar.path.with_suffix(".exr").absolute()
        return add_transfer_osl_node(tree, atlas, facts.layout, facts.views)

    def holds(self, facts: Facts) -> bool:
        return True

    def is_of(self, facts: Facts, spec: BakeSpec) -> bool:
        return has_samples_and_cells(facts, spec)

    def read_sidecar(self, sidecar: SidecarFile) -> Sidecar:
        return read_transfer_sidecar(sidecar).bake

    def shapes(self, sidecar: SidecarFile, texels: int = 1, cells: int = 1) -> Shapes:
        stored = read_transfer_sidecar(sidecar).stored
        factor = texels * cells
        return {"": (stored.pixel_width * factor, stored.pixel_height * factor, 4)}

    def export_bytes(self, sidecar: SidecarFile) -> int:
        stored = read_transfer_sidecar(sidecar).stored
        return _PIXEL * stored.pixel_width * stored.pixel_height

    def textures_of(self, facts: Facts, present: Collection[str]) -> tuple[str, ...]:
        return (TransferSidecar.from_facts(facts).bake.kind,)

    def flat(self, sidecar: SidecarFile, surface: SurfaceMesh) -> Generator[ExportStep, None, Floats]:
        yield from ()
        return flat_sphere(sidecar, surface)

    def check_textures(self, sidecar: SidecarFile, spec: ExportSpec) -> None:
        check_sphere(sidecar, spec)

    def write_textures(
        self, sidecar: SidecarFile, spec: ExportSpec, folder: Path, images: bool = False
    ) -> dict[str, TextureEntry]:
        return write_sphere(sidecar, spec, folder)

    def includes(self, bake: Mapping[str, Any]) -> tuple[str, ...]:
        return ("radtex", "radtex_transfer")

    def usage(self, bake: Mapping[str, Any], textures: Mapping[str, TextureEntry]) -> list[str]:
        size, n, views = "({}, {})".format(*bake["texels"]), bake["bucket"], bake["transfer"].get("views", 1)
        lookup = f"radtex_transfer(atlas, {size}, {n}, uv, L)"
        if views > 1:
            lookup = f"radtex_transfer_around(atlas, {size}, {views}, {n}, uv, I, L)"
        return [*defines(textures[bake["kind"]]), f"{lookup}, L being the light's direction"]

    def hlsl(
        self,
        bake: Mapping[str, Any],
        textures: Mapping[str, TextureEntry],
        target: Target,
        images: bool = False,
    ) -> HlslLookup:
        return sphere_lookup(bake, textures, target)


FORM: Form = Sphere()
