# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Export a finished bake to a folder that engines and browsers can load."""

from __future__ import annotations

import json
from collections.abc import Generator, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path

import bpy

from ..core.errors import FormatError, InputError
from ..core.messages import Setting, do
from ..core.quoting import printable
from ..formats.disk.memory import check_allowed
from ..formats.file_names import FORBIDDEN, is_plain_stem
from ..formats.sidecar import Sidecar, preview_path
from ..formats.sidecar_file import AnySidecar, SidecarFile, opened
from ..forms import Form, form_in
from ..scene.mesh.backs import twin_numbers
from ..scene.preview_file import baked_copy, check_preview, surface_of
from ..settings.targets import check_target
from ..textures.choice import check_importable, pixel_bytes
from ..textures.entry import TextureEntry
from ..textures.export_spec import ExportSpec, ExportStep, ExportTask, Target, TextureFormat
from ..textures.flat_lightmap import flat_png
from ..version import VERSION
from .export_manifest import EXTENSION, Manifest, read_manifest, write_manifest
from .folder import check_out, files_in, is_export, is_whole, replacing_folder
from .gltf import check_exporter, write_gltf
from .material_images import MaterialPictures, material_pictures
from .mirror import check_mirror, materials_of, write_mirror
from .pack import Pack
from .targets import writer_of

_LEVELS = 4 / 3  # all mip levels together, relative to the first
_LEAST_BYTES = 192 * 2**20  # memory of any export: a few bands of rows, the mesh, the mesh's file


@dataclass(frozen=True)
class Exported:
    """The result of an export: the `folder`, the relative paths of its `files`, and their total `bytes`."""

    folder: Path
    name: str
    target: Target
    files: tuple[str, ...]
    bytes: int

    @classmethod
    def of(cls, written: Path, folder: Path, name: str, target: Target) -> Exported:
        """The result of the files in `written`, which becomes `folder`."""
        files = tuple(files_in(written))
        return cls(folder, name, target, files, sum((written / file).stat().st_size for file in files))


@dataclass(frozen=True)
class ExportSource:
    """A finished bake to be exported; `name` is the stem of its files' names."""

    sidecar: SidecarFile
    form: Form
    bake: Sidecar
    name: str

    @classmethod
    def of(cls, sidecar: AnySidecar) -> ExportSource:
        """The bake with this sidecar. Raises FormatError if it is none, or is not called NAME.KIND.json."""
        file = opened(sidecar)
        form = form_in(file.facts)
        bake = form.read_sidecar(file)
        ending = f".{bake.kind}.json"
        if not file.path.name.endswith(ending):
            raise FormatError(f"{file} is not called NAME{ending}: give the bake's files their names back")
        name = file.path.name.removesuffix(ending)
        if not is_plain_stem(name) or printable(name) != name:
            raise FormatError(
                f"{json.dumps(name)} is no name for files of an export, which have no line ends, invisible "
                f"characters or {FORBIDDEN}: rename all files of that bake"
            )
        return cls(file, form, bake, name)

    @property
    def preview(self) -> Path:
        return preview_path(self.sidecar.path, self.bake.kind, self.bake.part)

    def folder(self, target: Target) -> Path:
        """The folder that an export writes by default."""
        return self.sidecar.path.with_name(f"{self.name}.{target}")

    def copy(
        self, surfaces: Sequence[str] = (), pictures: Mapping[int, MaterialPictures] | None = None
    ) -> AbstractContextManager[tuple[bpy.types.Scene, bpy.types.Object]]:
        """The baked copy, alone in a scene, as of `baked_copy`; of a shared atlas only these `surfaces`.

        With the UV layers of the `pictures` that its materials are shown by.
        """
        part = None if self.bake.part is None else self.bake.part.index
        more = dict.fromkeys(each.facts.uv_map for each in (pictures or {}).values())
        return baked_copy(self.preview, surfaces or self.bake.surfaces, self.bake.uv_map, part, tuple(more))


@dataclass(frozen=True)
class Flat:
    """A bake's flat lightmap: the PNG, what its light was multiplied by, and whether it has alpha."""

    png: bytes
    scale: float
    clear: bool


def _check_layers(bake: ExportSource, spec: ExportSpec) -> None:
    """Raise InputError for a layer that the bake does not have."""
    layers = bake.bake.layers if bake.form.traits.layers else ()
    for layer in spec.layers:
        if layer not in layers:
            known = ", ".join(layers) or "none"
            raise InputError(
                f"{bake.sidecar} has no layer {layer}, its layers are: {known}",
                do("bake it with that layer", Setting.LAYER, value=str(layer)),
            )


def check_writer(target: Target) -> None:
    """Check, even before a bake, what every export for the `target` needs.

    Raises InputError if this Blender has no glTF exporter, or this copy of RadTex lacks the target's files.
    """
    check_exporter()
    writer_of(target).check()


def check_folders_differ(outs: Sequence[Path]) -> None:
    """Raise InputError if two bakes would be exported into the same folder, where one would be lost."""
    twice = [out for number, out in enumerate(outs) if out in outs[:number]]
    if twice:
        raise InputError(
            f"several bakes do not fit in one folder, and {twice[0]} would be that of two: "
            "export them one by one, into different folders, or as one scene"
        )


def check_export(bake: ExportSource, spec: ExportSpec, out: Path, *, overwrite: bool = False) -> None:
    """Preflight checks of an export. Raises InputError and FormatError."""
    check_out(out, bake.sidecar.path.parent, overwrite)
    check_bake(bake, spec)
    check_writer(spec.target)


def check_bake(bake: ExportSource, spec: ExportSpec) -> None:
    """Check whether a bake can be exported by this specification. Raises InputError and FormatError."""
    path = bake.sidecar.path
    check_target(path, bake.bake.kind, spec.target)
    _check_layers(bake, spec)
    bake.form.check_textures(bake.sidecar, spec)
    check_importable(path, spec, bake.form.shapes(bake.sidecar))
    if spec.mirror:
        check_mirror(path, bake.bake.kind, 1)
    needed = _LEAST_BYTES + bake.form.export_bytes(bake.sidecar)
    check_allowed(f"an export of {path}", needed, spec.memory_mb)
    check_preview(bake.preview)


def export_steps(
    sidecar: AnySidecar, spec: ExportSpec, out: Path | None = None, *, overwrite: bool = False
) -> Generator[ExportStep, None, Exported]:
    """Export a finished bake, by its sidecar, into the folder `out`, by default NAME.TARGET beside it.

    Yields progress; returns the result. The folder is written whole or not at all, and Blender's session is
    afterwards as it was, also after an error or when the generator is closed. Raises InputError for a bake
    that cannot be exported, FormatError for files that cannot be read, BakeError if the export fails.
    """
    bake = ExportSource.of(sidecar)
    out = out or bake.folder(spec.target)
    check_export(bake, spec, out, overwrite=overwrite)
    with replacing_folder(out) as folder:
        pack = yield from _pack(bake, spec, folder)
        yield ExportStep(ExportTask.PACK, 0, 1)
        writer_of(spec.target).write(pack, folder)
        made = Exported.of(folder, out, bake.name, spec.target)
    return made


def _pack(bake: ExportSource, spec: ExportSpec, folder: Path) -> Generator[ExportStep, None, Pack]:
    """Write the files that all targets need. Yields progress."""
    yield ExportStep(ExportTask.TEXTURES, 0, 1)
    pictures = pictures_of(bake, spec)
    textures = bake.form.write_textures(bake.sidecar, spec, folder, shown_whole(bake, pictures))
    layer = bake.bake.uv_map
    with bake.copy((), pictures) as (scene, copy):
        yield ExportStep(ExportTask.FLAT, 0, 1)
        flat = yield from flat_steps(bake, copy)
        manifest = manifest_of(bake, f"{bake.name}.glb", textures, flat, copy, bool(pictures))
        if spec.mirror:
            check_mirror(bake.sidecar.path, bake.bake.kind, materials_of(manifest.shader))
            mirrored = copy.matrix_world.determinant() < 0
            surface = surface_of(copy, layer)
            mirror = write_mirror(surface, mirrored, manifest.culled, bake.name, spec, folder)
            manifest = replace(manifest, mirror=mirror)
        (folder / manifest.flat).write_bytes(flat.png)
        yield ExportStep(ExportTask.MESH, 0, 1)
        # A loader that takes no scene takes one mesh.
        names = bake.bake.objects if writer_of(spec.target).write_scene is not None else ()
        path = folder / manifest.mesh
        traits = spec.target.traits
        write_gltf(
            *(scene, copy, layer, flat.png, manifest, path, traits, flat.clear, names, pictures),
            compressed=spec.compressed,
        )
    write_manifest(folder / f"{bake.name}.{EXTENSION}", manifest)
    return Pack(bake.name, manifest, folder, spec)


def pictures_of(bake: ExportSource, spec: ExportSpec) -> dict[int, MaterialPictures]:
    """The images of the bake's materials, by number, if the target shows materials by these; all or none.

    Raises FormatError for a preview that cannot be read.
    """
    numbers = bake.form.own_images(bake.sidecar) if spec.shows_images else ()
    if not numbers:
        return {}
    found = material_pictures(bake.preview, bake.bake.surfaces, numbers, spec.image_limit)
    return found if len(found) == len(numbers) else {}


def shown_whole(bake: ExportSource, pictures: Mapping[int, MaterialPictures]) -> bool:
    """Whether all materials are shown by these images, so that the bake's own maps are not needed."""
    return bool(pictures) and len(pictures) == bake.form.material_count(bake.sidecar)


def flat_steps(bake: ExportSource, copy: bpy.types.Object) -> Generator[ExportStep, None, Flat]:
    """The flat lightmap of a bake with this baked copy. Yields progress."""
    light = yield from bake.form.flat(bake.sidecar, surface_of(copy, bake.bake.uv_map))
    png, scale = flat_png(light)
    return Flat(png, scale, clear=light.shape[2] > 3)


def manifest_of(
    bake: ExportSource,
    mesh: str,
    textures: Mapping[str, TextureEntry],
    flat: Flat,
    copy: bpy.types.Object,
    images: bool,
) -> Manifest:
    """The manifest of a bake with this baked copy, which is in the file `mesh`; without a mirror.

    `images`: materials are shown by their own images, where they can be.
    """
    return Manifest(
        tool=f"RadTex {VERSION}",
        name=bake.name,
        mesh=mesh,
        flat=f"{bake.name}.flat.png",
        bake=bake.sidecar.facts.values,
        textures=textures,
        flat_scale=flat.scale,
        culled=bake.form.traits.backs and twin_numbers(copy.data) is not None,
        images=images,
    )


def about_texture_bytes(bake: ExportSource, spec: ExportSpec) -> float:
    """Bytes of the textures before Zstandard packs them, for light without alpha; reads no images."""
    form, shapes = bake.form.traits, bake.form.shapes(bake.sidecar).values()
    if form.bits:
        return float(sum(width * height * words * 4 for width, height, words in shapes))
    pixels = sum(width * height for width, height, _ in shapes)
    whole = not form.by_paths and (not form.arranges or spec.levels == 1 or spec.format is TextureFormat.EXR)
    return pixels * (1 if whole else _LEVELS) * pixel_bytes(spec, by_paths=form.by_paths)


def current_manifest(bake: ExportSource, out: Path) -> Manifest | None:
    """The manifest of a whole export of this very bake by this version of RadTex; None if there is none."""
    manifest = earlier_manifest(bake, out)
    if manifest is None or not is_whole(out) or manifest.tool != f"RadTex {VERSION}":
        return None
    newer = _modified(out / f"{bake.name}.{EXTENSION}") >= _modified(bake.sidecar.path)
    return manifest if newer and manifest.bake == bake.sidecar.facts.values else None


def earlier_manifest(bake: ExportSource, out: Path) -> Manifest | None:
    """The manifest of an export of any bake by this name; None if there is none."""
    try:
        return read_manifest(out / f"{bake.name}.{EXTENSION}") if is_export(out) else None
    except FormatError:
        return None


def _modified(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0
