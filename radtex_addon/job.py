# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole job: an object and a specification in, an atlas with its sidecar and a preview out.

The batch and the panel call these functions; so can a script. Data goes one way: evaluated mesh, UVs, texel
map, tiles, atlas, files.
"""

from __future__ import annotations

import logging
import tempfile
from collections.abc import Generator
from dataclasses import dataclass
from pathlib import Path

import bpy

from .bake.capture import Capture
from .bake.plan import CapturePlan, plan_capture
from .bake.progress import Progress, Stage
from .bake.session import fill_atlas
from .bake.spec import BakeSpec, CaptureMethod, Kind
from .bake.stopwatch import Stopwatch
from .core.arrays import Bools, Floats
from .core.atlas import AtlasLayout
from .core.errors import BakeError, InputError
from .core.inset import inset
from .core.sampler import Filter
from .core.texel_map import TexelMap, rasterise
from .cycles.device import use_device
from .cycles.hidden import find_hidden
from .cycles.offset import ray_offset
from .cycles.panoramic import PanoramicCapture
from .cycles.portal import PortalCapture
from .formats.atomic import check_absent, check_writable
from .formats.exr import write_atlas
from .formats.sidecar import Sidecar, file_name, write_sidecar
from .preview.material import preview_material
from .preview.node_group import check_previewable
from .preview.save import save_preview
from .scene.copy import UV_LAYER, baked_mesh, copy_object, surface_mesh
from .scene.evaluated import EvaluatedMesh, evaluate
from .scene.fog import volumes_around
from .scene.light import is_dark
from .scene.objects import find_object
from .scene.scratch import find_view_layer, new_data_removed, scratch_scene
from .scene.unwrap import unwrap_steps
from .scene.unwrap_options import UnwrapOptions
from .scene.uv_layer import user_uv
from .scene.xatlas_process import check_xatlas
from .version import VERSION

log = logging.getLogger(__name__)

_RIM = 0.2  # of a ray's offset: how far from its triangle's edges a ray starts


@dataclass(frozen=True)
class OutputFiles:
    """Where a bake of one object goes; `preview` is None if none is wanted."""

    atlas: Path
    sidecar: Path
    preview: Path | None

    @classmethod
    def of(cls, object_name: str, spec: BakeSpec, folder: Path, preview: bool) -> OutputFiles:
        """The names of the contract, DESIGN.md section 3, below `folder`."""
        atlas, sidecar = (folder / file_name(object_name, spec.kind, ending) for ending in ("exr", "json"))
        shown = folder / file_name(object_name, "preview", "blend")
        return cls(atlas, sidecar, shown if preview else None)

    @property
    def all(self) -> tuple[Path, ...]:
        return (self.atlas, self.sidecar, *((self.preview,) if self.preview else ()))


@dataclass(frozen=True)
class BakeResult:
    """What a bake made, and what it took: `paths` are camera paths, `seconds` are by stage."""

    files: OutputFiles
    layout: AtlasLayout
    covered_texels: int
    islands: int | None
    paths: int
    device: str
    clamped: int
    seconds: dict[Stage, float]


@dataclass(frozen=True)
class _Unwrapped:
    uv: Floats
    layer: str
    width: int
    height: int
    islands: int | None


def bake_object(
    scene: bpy.types.Scene,
    name: str,
    spec: BakeSpec,
    folder: Path,
    *,
    view_layer: str | None = None,
    preview: Filter | None = None,
    overwrite: bool = False,
) -> BakeResult:
    """Bake one object and write its files; see `bake_steps`."""
    steps = bake_steps(scene, name, spec, folder, view_layer=view_layer, preview=preview, overwrite=overwrite)
    while True:
        try:
            next(steps)
        except StopIteration as stop:
            result: BakeResult = stop.value
            return result


def check_request(
    scene: bpy.types.Scene,
    name: str,
    spec: BakeSpec,
    folder: Path,
    preview: bool,
    overwrite: bool,
    view_layer: str | None = None,
) -> list[str]:
    """Everything that can be known to fail before a bake starts; returns warnings.

    Raises InputError for an object or a view layer that is not there, an object that cannot be baked, and for
    files that would be lost or cannot be written.
    """
    item = find_object(scene, name)
    layer = find_view_layer(scene, view_layer)
    if spec.uv_layer is None:
        check_xatlas()
    files = OutputFiles.of(name, spec, folder, preview)
    check_writable(folder)
    if files.preview is not None and _is_open(files.preview):
        raise InputError(
            f"{files.preview} is the open file, which a bake never changes: choose another folder"
        )
    check_absent(files.all, overwrite)
    if preview:
        check_previewable(AtlasLayout(spec.texels, spec.texels, spec.bucket))
    warnings = []
    if is_dark(scene, layer):
        warnings.append(f"scene '{scene.name}' has no light: no lamp, a black world, nothing that emits")
    if spec.capture is CaptureMethod.PORTAL:
        warnings.extend(
            f"object '{name}' stands in the volume of '{fog}', which the bake will not show: "
            "make it the world's volume, or hide it from render"
            for fog in volumes_around(layer, item)
        )
    return warnings


def _is_open(path: Path) -> bool:
    return bool(bpy.data.filepath) and path.resolve() == Path(bpy.data.filepath).resolve()


def bake_steps(
    scene: bpy.types.Scene,
    name: str,
    spec: BakeSpec,
    folder: Path,
    *,
    view_layer: str | None = None,
    preview: Filter | None = None,
    overwrite: bool = False,
) -> Generator[Progress, None, BakeResult]:
    """Bake the mesh object `name` as `scene`'s `view_layer` renders it (the first that does, if None).

    Writes `<name>.<kind>.exr` and `.json` into `folder`, and with a `preview` filter `<name>.preview.blend`.
    Yields progress; returns the result. The scene is what it was afterwards, also after an error or when the
    generator is closed. Raises InputError for what cannot be baked, BakeError for what fails meanwhile.
    """
    files = OutputFiles.of(name, spec, folder, preview is not None)
    for warning in check_request(scene, name, spec, folder, preview is not None, overwrite, view_layer):
        log.warning(warning)
    watch = Stopwatch()
    with new_data_removed():
        baked = yield from _bake(scene, name, spec, files, view_layer, watch)
        if preview is not None and files.preview is not None:
            yield watch.start(Stage.PREVIEW)
            original, layout = scene.objects[name], baked.layout
            material = preview_material(
                f"RadTex {name}", files.atlas.absolute(), layout, baked.uv_layer, preview, spec.half
            )
            save_preview(
                scene, original, copy_object(original, baked.mesh), material, files.preview.absolute()
            )
    watch.stop()
    return BakeResult(
        files=files,
        layout=baked.layout,
        covered_texels=baked.covered_texels,
        islands=baked.islands,
        paths=baked.covered_texels * spec.bucket**2 * spec.samples,
        device=baked.device,
        clamped=baked.clamped,
        seconds=watch.seconds,
    )


@dataclass(frozen=True)
class _Baked:
    """An atlas on disk, and the mesh that it belongs to."""

    mesh: bpy.types.Mesh
    uv_layer: str
    layout: AtlasLayout
    covered_texels: int
    islands: int | None
    device: str
    clamped: int


def _bake(
    scene: bpy.types.Scene,
    name: str,
    spec: BakeSpec,
    files: OutputFiles,
    view_layer: str | None,
    watch: Stopwatch,
) -> Generator[Progress, None, _Baked]:
    kept: list[bpy.types.ID] = []
    with (
        tempfile.TemporaryDirectory(prefix="radtex-") as temporary,
        scratch_scene(scene, view_layer, kept) as scratch,
        use_device(scratch, spec.device) as device,  # before the unwrap, which may take long
    ):
        folder = Path(temporary)
        original = find_object(scratch, name)
        yield watch.start(Stage.EVALUATE)
        evaluated = evaluate(scratch, original)
        yield watch.start(Stage.UNWRAP)
        unwrapped = yield from watch.over(_unwrap(evaluated, spec))
        yield watch.start(Stage.RASTER)
        mesh = baked_mesh(evaluated, unwrapped.uv, unwrapped.layer)
        kept.append(mesh)
        surface = surface_mesh(evaluated, mesh, unwrapped.layer)
        texels = rasterise(surface, unwrapped.width, unwrapped.height)
        texels = inset(texels, surface, _RIM * ray_offset(surface.position))
        plan, hidden = yield from watch.over(_plan(texels, mesh, evaluated, spec, folder))
        capture = _capture(scratch, plan, spec, folder)
        image = yield from watch.over(fill_atlas(plan, capture, spec.memory_mb, hidden))
        yield watch.start(Stage.WRITE)
        sidecar = _sidecar(name, spec, plan, unwrapped)
        clamped = _write(files, image, sidecar, spec)
    return _Baked(mesh, unwrapped.layer, plan.layout, len(plan.texel), unwrapped.islands, device, clamped)


def _unwrap(evaluated: EvaluatedMesh, spec: BakeSpec) -> Generator[Progress, None, _Unwrapped]:
    if spec.uv_layer is not None:
        uv = user_uv(evaluated, spec.uv_layer)
        return _Unwrapped(uv, spec.uv_layer, spec.texels, spec.texels, None)
    options = UnwrapOptions(padding=spec.padding)
    found = yield from unwrap_steps(evaluated, spec.texels, spec.unwrap, options)
    return _Unwrapped(found.uv, UV_LAYER, found.width, found.height, found.islands)


def _plan(
    texels: TexelMap, mesh: bpy.types.Mesh, evaluated: EvaluatedMesh, spec: BakeSpec, folder: Path
) -> Generator[Progress, None, tuple[CapturePlan, Bools | None]]:
    """What to capture, and which cells of it nobody sees; texels that nobody sees at all cost no path."""
    plan = plan_capture(texels, spec.bucket)
    if spec.kind is not Kind.RADIANCE:
        return plan, None
    hidden = yield from find_hidden(mesh, evaluated.matrix_world, plan, folder)
    buried = hidden.all(axis=(1, 2))
    return plan_capture(texels, spec.bucket, without=plan.texel[buried]), hidden[~buried]


def _capture(scratch: bpy.types.Scene, plan: CapturePlan, spec: BakeSpec, folder: Path) -> Capture:
    capture = PortalCapture if spec.capture is CaptureMethod.PORTAL else PanoramicCapture
    return capture(scratch, plan, spec.kind, spec.samples, spec.seed, folder)


def _write(files: OutputFiles, image: Floats, sidecar: Sidecar, spec: BakeSpec) -> int:
    """Write both files, or leave neither; returns how many values were clamped."""
    written = write_atlas(files.atlas, image, sidecar, spec.half, spec.compression)
    try:
        write_sidecar(files.sidecar, written)
    except BakeError:  # an atlas must not lie beside the sidecar of another
        for path in (files.atlas, files.sidecar):
            path.unlink(missing_ok=True)
        raise
    return written.clamped


def _sidecar(name: str, spec: BakeSpec, plan: CapturePlan, unwrapped: _Unwrapped) -> Sidecar:
    return Sidecar(
        object_name=name,
        kind=spec.kind,
        width=plan.layout.width,
        height=plan.layout.height,
        bucket=plan.layout.bucket,
        uv_map=unwrapped.layer,
        samples=spec.samples,
        seed=spec.seed,
        capture=spec.capture,
        tool=f"RadTex {VERSION}",
        blender=bpy.app.version_string,
    )
