# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Export several finished bakes as one scene: one folder, one glTF with a node for each object."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from pathlib import Path

from ..core.errors import InputError
from ..formats.sidecar import safe_name
from ..formats.sidecar_file import AnySidecar
from ..textures.export_spec import ExportSpec, ExportStep, ExportTask, Target
from ..textures.kept_exports import KeptExport
from ..version import VERSION
from .export_manifest import Manifest
from .exporting import (
    Exported,
    ExportSource,
    Flat,
    check_bake,
    check_writer,
    export_steps,
    flat_steps,
    manifest_of,
    pictures_of,
    shown_whole,
)
from .folder import check_out, replacing_folder
from .gltf import Pictures, baked_mesh
from .pack import SceneEntry, ScenePack
from .scene_gltf import SceneGltf, SceneNode, scene_nodes
from .targets import writer_of


@dataclass(frozen=True, eq=False)
class _Baked:
    """A bake of the scene whose textures are written; `texture` is its flat lightmap's in the glTF."""

    source: ExportSource
    manifest: Manifest
    flat: Flat
    texture: int | None
    pictures: Pictures


def scene_sources(sidecars: Sequence[AnySidecar]) -> tuple[ExportSource, ...]:
    """The bakes with these sidecars, each once. Raises as `ExportSource.of`, and InputError for none."""
    found = [ExportSource.of(sidecar) for sidecar in sidecars]
    if not found:
        raise InputError("a scene of no bakes: name one at least")
    return tuple({bake.sidecar.path.resolve(): bake for bake in found}.values())


def scene_folder(bakes: Sequence[ExportSource], name: str, target: Target) -> Path:
    """The folder that an export as the scene `name` writes by default: beside the first of the bakes."""
    return bakes[0].sidecar.path.with_name(f"{safe_name(name)}.{target}")


def check_scene(
    bakes: Sequence[ExportSource], spec: ExportSpec, out: Path, *, overwrite: bool = False
) -> tuple[SceneNode, ...]:
    """Preflight checks of an export as one scene; returns its nodes. Raises InputError and FormatError."""
    if spec.mirror:
        raise InputError("a mirror ball mirrors one bake, not a whole scene: leave the ball out")
    if writer_of(spec.target).write_scene is None:
        raise InputError(
            f"a scene for {spec.target}: its import script takes one bake a folder; export them one by one"
        )
    for bake in bakes:
        check_out(out, bake.sidecar.path.parent, overwrite)
        check_bake(bake, spec)
    check_writer(spec.target)
    return scene_nodes(bakes)


def export_scene_steps(
    sidecars: Sequence[AnySidecar],
    spec: ExportSpec,
    name: str,
    out: Path | None = None,
    *,
    overwrite: bool = False,
) -> Generator[ExportStep, None, Exported]:
    """Export finished bakes, by their sidecars, as the scene `name` into the folder `out`.

    `out` is by default NAME.TARGET beside the first bake. Yields progress; returns the result; raises as
    `export_steps` does, and InputError if two of the bakes show the same thing.
    """
    bakes = scene_sources(sidecars)
    out = out or scene_folder(bakes, name, spec.target)
    nodes = check_scene(bakes, spec, out, overwrite=overwrite)
    with replacing_folder(out) as folder:
        pack = yield from _pack(bakes, nodes, spec, safe_name(name), folder)
        yield ExportStep(ExportTask.PACK, 0, 1)
        write = writer_of(spec.target).write_scene
        assert write is not None  # see `check_scene`
        write(pack, folder)
        made = Exported.of(folder, out, pack.name, spec.target)
    return made


def export_again_steps(kept: KeptExport) -> Generator[ExportStep, None, Exported]:
    """Make a kept export again, in the place of what is there.

    As of `export_steps`, and of `export_scene_steps` for a scene.
    """
    if kept.scene is None:
        return export_steps(kept.sidecars[0], kept.spec, kept.out, overwrite=True)
    return export_scene_steps(kept.sidecars, kept.spec, kept.scene, kept.out, overwrite=True)


def _pack(
    bakes: Sequence[ExportSource], nodes: Sequence[SceneNode], spec: ExportSpec, name: str, folder: Path
) -> Generator[ExportStep, None, ScenePack]:
    """Write the files that all targets need. Yields progress."""
    scene = SceneGltf(name, f"RadTex {VERSION}")
    baked = yield from _bakes_written(bakes, scene, f"{name}.glb", spec, folder)
    every = [each for node in nodes for each in (node, *node.levels)]
    places: dict[str, int] = {}
    for number, node in enumerate(every):
        yield ExportStep(ExportTask.MESH, number, len(every))
        places[node.name] = _add_node(scene, node, baked[node.bake], spec)
    shown = [(places[node.name], [places[level.name] for level in node.levels]) for node in nodes]
    scene.write(folder / f"{name}.glb", shown, spec.compressed)
    pack = ScenePack(name, [_entry(node, baked) for node in nodes], folder, spec)
    pack.write_manifest()
    return pack


def _bakes_written(
    bakes: Sequence[ExportSource], scene: SceneGltf, mesh: str, spec: ExportSpec, folder: Path
) -> Generator[ExportStep, None, list[_Baked]]:
    """Write each bake's textures and flat lightmap, into the glTF too. Yields progress."""
    textures, shown = [], []
    for number, bake in enumerate(bakes):
        yield ExportStep(ExportTask.TEXTURES, number, len(bakes))
        shown.append(pictures_of(bake, spec))
        whole = shown_whole(bake, shown[-1])
        textures.append(bake.form.write_textures(bake.sidecar, spec, folder, whole))
    found = []
    for number, (bake, written, pictures) in enumerate(zip(bakes, textures, shown, strict=True)):
        step = ExportStep(ExportTask.FLAT, number, len(bakes))
        yield step
        with bake.copy() as (_, copy):
            steps = flat_steps(bake, copy)
            flat = yield from _told_as(step, steps)
            manifest = manifest_of(bake, mesh, written, flat, copy, bool(pictures))
        (folder / manifest.flat).write_bytes(flat.png)
        texture = None if shown_whole(bake, pictures) else scene.add_flat(flat.png, manifest)
        found.append(_Baked(bake, manifest, flat, texture, pictures))
    return found


def _told_as(step: ExportStep, steps: Generator[ExportStep, None, Flat]) -> Generator[ExportStep, None, Flat]:
    """The result of `steps`; each of them is told as `step`, a part of something larger."""
    while True:
        try:
            next(steps)
        except StopIteration as stop:
            flat: Flat = stop.value
            return flat
        yield step


def _add_node(scene: SceneGltf, node: SceneNode, baked: _Baked, spec: ExportSpec) -> int:
    """Add a node to the glTF; returns its index."""
    layer, pictures = baked.source.bake.uv_map, baked.pictures
    with baked.source.copy(node.surfaces, pictures) as (alone, copy):
        told = alone, copy, layer, baked.manifest, (node.name,), spec.target.traits, pictures
        mesh = baked_mesh(*told, compressed=spec.compressed)
    return scene.add_node(mesh, baked.texture, baked.manifest, baked.flat.clear, pictures)


def _entry(node: SceneNode, baked: Sequence[_Baked]) -> SceneEntry:
    levels = tuple(_entry(level, baked) for level in node.levels)
    return SceneEntry(node.name, baked[node.bake].manifest, levels)
