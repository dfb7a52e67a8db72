# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Export several finished bakes as one scene: one folder, one glTF with a node for each object."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from ..core.errors import InputError
from ..core.quoting import in_comment
from ..formats.sidecar import safe_name
from ..formats.sidecar_file import AnySidecar
from ..textures.export_spec import ExportSpec, Step, Target, Task
from ..version import VERSION
from .engines import IMPORT_LINES, copy_includes, described, includes
from .export_manifest import EXTENSION, Manifest
from .exporting import Exported, ExportSource, Flat, check_bake, check_writer, flat_steps, manifest_of
from .folder import check_out, replacing_folder
from .gltf import baked_mesh
from .pack import Pack
from .scene_gltf import SceneGltf, SceneNode, scene_nodes
from .scene_manifest import SceneEntry, ScenePack
from .web import write_web
from .write_godot import write_godot


def write_engine_scene(pack: ScenePack, folder: Path) -> None:
    """Add the shader includes that the bakes need, and a README.txt, to a scene's folder."""
    target = pack.spec.target
    packs = [Pack(manifest.name, manifest, folder, pack.spec) for manifest in pack.manifests]
    copy_includes(dict.fromkeys(path for each in packs for path in includes(target, each)), folder)
    text = "".join(f"{in_comment(line)}\n" for line in _lines(pack))
    (folder / "README.txt").write_text(text, encoding="utf-8", newline="\n")


def _lines(pack: ScenePack) -> Iterator[str]:
    """The lines of README.txt: the files, the nodes, and how each bake is looked up."""
    yield f"{pack.name}: a scene of {len(pack.manifests)} radiance textures, made by {pack.manifests[0].tool}"
    yield ""
    yield f"{pack.mesh}: the meshes, a node for each object. TEXCOORD_0 is the baked UV layer, NORMAL and"
    yield "TANGENT its frame."
    yield f"{pack.name}.{EXTENSION}: which node has which textures, for programs."
    yield "shaders/: the includes to look them up by (MIT licence)."
    yield ""
    for entry in pack.entries:
        yield _node(entry)
    for manifest in pack.manifests:
        yield from _bake(manifest, pack)
    yield ""
    yield from IMPORT_LINES


def _node(entry: SceneEntry) -> str:
    levels = ", ".join(level.node for level in entry.levels)
    return f"node {entry.node}: {entry.manifest.name}" + (f"; farther away {levels}" if levels else "")


def _bake(manifest: Manifest, pack: ScenePack) -> Iterator[str]:
    bake = manifest.bake
    width, height = bake["texels"]
    yield ""
    yield f"{manifest.name}"
    yield f"layout {bake['layout']}, {width} x {height} texels of {bake['bucket']} x {bake['bucket']} cells"
    yield f"{manifest.flat}: a flat lightmap, the mean of each texel's light; also inside {pack.mesh}."
    for layer, entry in manifest.textures.items():
        yield described(layer, entry)
    yield from manifest.form.usage(bake, manifest.textures, pack.spec.target)


_WRITERS: dict[Target, Callable[[ScenePack, Path], None]] = {
    Target.WEB: write_web,
    Target.GODOT: write_godot,
    Target.GLTF: write_engine_scene,
    Target.RAW: write_engine_scene,
}


@dataclass(frozen=True, eq=False)
class _Baked:
    """A bake of the scene whose textures are written; `texture` is its flat lightmap's in the glTF."""

    source: ExportSource
    manifest: Manifest
    flat: Flat
    texture: int


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
    if spec.target not in _WRITERS:
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
) -> Generator[Step, None, Exported]:
    """Export finished bakes, by their sidecars, as the scene `name` into the folder `out`.

    `out` is by default NAME.TARGET beside the first bake. Yields progress; returns the result; raises as
    `export_steps` does, and InputError if two of the bakes show the same thing.
    """
    bakes = scene_sources(sidecars)
    out = out or scene_folder(bakes, name, spec.target)
    nodes = check_scene(bakes, spec, out, overwrite=overwrite)
    with replacing_folder(out) as folder:
        pack = yield from _pack(bakes, nodes, spec, safe_name(name), folder)
        yield Step(Task.PACK, 0, 1)
        _WRITERS[spec.target](pack, folder)
        made = Exported.of(folder, out, pack.name, spec.target)
    return made


def _pack(
    bakes: Sequence[ExportSource], nodes: Sequence[SceneNode], spec: ExportSpec, name: str, folder: Path
) -> Generator[Step, None, ScenePack]:
    """Write the files that all targets need. Yields progress."""
    scene = SceneGltf(name, f"RadTex {VERSION}")
    baked = yield from _bakes_written(bakes, scene, f"{name}.glb", spec, folder)
    every = [each for node in nodes for each in (node, *node.levels)]
    places: dict[str, int] = {}
    for number, node in enumerate(every):
        yield Step(Task.MESH, number, len(every))
        places[node.name] = _add_node(scene, node, baked[node.bake])
    shown = [(places[node.name], [places[level.name] for level in node.levels]) for node in nodes]
    scene.write(folder / f"{name}.glb", shown)
    pack = ScenePack(name, [_entry(node, baked) for node in nodes], folder, spec)
    pack.write_manifest()
    return pack


def _bakes_written(
    bakes: Sequence[ExportSource], scene: SceneGltf, mesh: str, spec: ExportSpec, folder: Path
) -> Generator[Step, None, list[_Baked]]:
    """Write each bake's textures and flat lightmap, into the glTF too. Yields progress."""
    textures = []
    for number, bake in enumerate(bakes):
        yield Step(Task.TEXTURES, number, len(bakes))
        textures.append(bake.form.write_textures(bake.sidecar, spec, folder))
    found = []
    for number, (bake, written) in enumerate(zip(bakes, textures, strict=True)):
        step = Step(Task.FLAT, number, len(bakes))
        yield step
        with bake.copy() as (_, copy):
            steps = flat_steps(bake, copy)
            flat = yield from _told_as(step, steps)
            manifest = manifest_of(bake, mesh, written, flat, copy)
        (folder / manifest.flat).write_bytes(flat.png)
        found.append(_Baked(bake, manifest, flat, scene.add_flat(flat.png, manifest)))
    return found


def _told_as(step: Step, steps: Generator[Step, None, Flat]) -> Generator[Step, None, Flat]:
    """The result of `steps`; each of them is told as `step`, a part of something larger."""
    while True:
        try:
            next(steps)
        except StopIteration as stop:
            flat: Flat = stop.value
            return flat
        yield step


def _add_node(scene: SceneGltf, node: SceneNode, baked: _Baked) -> int:
    """Add a node to the glTF; returns its index."""
    with baked.source.copy(node.surfaces) as (alone, copy):
        mesh = baked_mesh(alone, copy, baked.source.bake.uv_map, baked.manifest, node.name)
    return scene.add_node(mesh, baked.texture, baked.manifest, baked.flat.clear)


def _entry(node: SceneNode, baked: Sequence[_Baked]) -> SceneEntry:
    levels = tuple(_entry(level, baked) for level in node.levels)
    return SceneEntry(node.name, baked[node.bake].manifest, levels)
