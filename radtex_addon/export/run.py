# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An export from a finished bake to a folder that engines and browsers take."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import dataclass
from pathlib import Path

from ..core.errors import FormatError, InputError
from ..formats.disk.memory import check_allowed
from ..formats.json_reader import Facts
from ..formats.sidecar import Sidecar, preview_path, read_facts
from ..forms import Form, form_in
from ..scene.preview_file import baked_copy, check_preview, surface_of
from ..textures.flat import flat_png
from ..textures.progress import Step, Task
from ..textures.spec import ExportSpec, Target
from ..version import VERSION
from .engines import write_engine
from .folder import check_out, files_in, replacing_folder
from .gltf import check_exporter, write_gltf
from .godot import write_godot
from .kinds import check_target
from .manifest import EXTENSION, Manifest, write_manifest
from .pack import Pack
from .web import check_page, write_web

_LEAST_BYTES = 192 * 2**20  # of any export: a few bands of rows, the mesh, its file
_WRITERS: dict[Target, Callable[[Pack, Path], None]] = {
    Target.WEB: write_web,
    Target.GODOT: write_godot,
    Target.GLTF: write_engine,
    Target.UNITY: write_engine,
    Target.UNREAL: write_engine,
    Target.RAW: write_engine,
}


@dataclass(frozen=True)
class Exported:
    """What an export made: the `folder`, and the `files` in it, relative, that take `bytes` together."""

    folder: Path
    name: str
    target: Target
    files: tuple[str, ...]
    bytes: int


@dataclass(frozen=True)
class _Bake:
    """What is exported; `name` is the stem of its files' names."""

    sidecar: Path
    facts: Facts
    form: Form
    bake: Sidecar
    name: str

    @classmethod
    def of(cls, sidecar: Path) -> _Bake:
        facts = read_facts(sidecar)
        form = form_in(facts)
        bake = form.read_sidecar(sidecar)
        ending = f".{bake.kind}.json"
        if not sidecar.name.endswith(ending):
            raise FormatError(f"{sidecar} is not called NAME{ending}: give the bake's files their names back")
        return cls(sidecar, facts, form, bake, sidecar.name.removesuffix(ending))

    @property
    def preview(self) -> Path:
        return preview_path(self.sidecar, self.bake.kind, self.bake.part)


def _check_layers(bake: _Bake, spec: ExportSpec) -> None:
    """Raise InputError for a layer that the bake does not have."""
    layers = bake.bake.layers if bake.form.traits.layers else ()
    for layer in spec.layers:
        if layer not in layers:
            known = ", ".join(layers) or "none"
            raise InputError(
                f"{bake.sidecar} has no layer {layer}, its layers are: {known}; bake it with --layer {layer}"
            )


def export_path(sidecar: Path, target: Target) -> Path:
    """Where the export of a bake goes, if nobody says. Raises FormatError for what is no sidecar."""
    return sidecar.with_name(f"{_Bake.of(sidecar).name}.{target}")


def check_writer(target: Target) -> None:
    """Find out before there is a bake what no export for the `target` can do without.

    Raises InputError where this Blender has no glTF exporter, or this copy of RadTex no web page.
    """
    check_exporter()
    if target is Target.WEB:
        check_page()


def check_export(sidecar: Path, spec: ExportSpec, out: Path, *, overwrite: bool = False) -> None:
    """Find out at once what would fail at once. Raises InputError and FormatError as `export_steps` does."""
    check_out(out, sidecar.parent, overwrite)
    bake = _Bake.of(sidecar)
    check_target(sidecar, bake.bake.kind, spec.target)
    _check_layers(bake, spec)
    check_allowed(f"an export of {sidecar}", _LEAST_BYTES + bake.form.export_bytes(sidecar), spec.memory_mb)
    check_preview(bake.preview)
    check_writer(spec.target)


def export_steps(
    sidecar: Path, spec: ExportSpec, out: Path | None = None, *, overwrite: bool = False
) -> Generator[Step, None, Exported]:
    """Make a folder of the finished bake whose sidecar is the file `sidecar`, at `export_path` by default.

    Yields progress; returns what was made. The folder is written whole or not at all, and Blender's session
    is what it was afterwards, also after an error or when the generator is closed. Raises InputError for what
    cannot be exported, FormatError for files that cannot be read, BakeError for what fails meanwhile.
    """
    out = out or export_path(sidecar, spec.target)
    check_export(sidecar, spec, out, overwrite=overwrite)
    bake = _Bake.of(sidecar)
    with replacing_folder(out) as folder:
        pack = yield from _pack(bake, spec, folder)
        yield Step(Task.PACK, 0, 1)
        _WRITERS[spec.target](pack, folder)
        files = tuple(files_in(folder))
        size = sum((folder / name).stat().st_size for name in files)
    return Exported(out, bake.name, spec.target, files, size)


def _pack(bake: _Bake, spec: ExportSpec, folder: Path) -> Generator[Step, None, Pack]:
    """What all targets have."""
    yield Step(Task.TEXTURES, 0, 1)
    textures = bake.form.write_textures(bake.sidecar, spec, folder)
    layer = bake.bake.uv_map
    part = None if bake.bake.part is None else bake.bake.part.index
    with baked_copy(bake.preview, bake.bake.surfaces, layer, part) as (scene, copy):
        yield Step(Task.FLAT, 0, 1)
        light = yield from bake.form.flat(bake.sidecar, surface_of(copy, layer))
        flat, scale = flat_png(light)
        clear = light.shape[2] > 3  # it has alpha
        manifest = Manifest(
            tool=f"RadTex {VERSION}",
            name=bake.name,
            mesh=f"{bake.name}.glb",
            flat=f"{bake.name}.flat.png",
            bake=bake.facts.values,
            textures=textures,
            flat_scale=scale,
        )
        (folder / manifest.flat).write_bytes(flat)
        yield Step(Task.MESH, 0, 1)
        write_gltf(scene, copy, layer, flat, manifest, folder / manifest.mesh, clear)
    write_manifest(folder / f"{bake.name}.{EXTENSION}", manifest)
    return Pack(bake.name, manifest, folder, spec)
