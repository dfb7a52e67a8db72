# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Targets without a ready-made project: the folder gets shader includes and a README beside the textures."""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path

from ..core.quoting import in_comment
from ..textures.entry import Container, TextureEntry
from .export_manifest import EXTENSION, Manifest
from .pack import SHADERS, Pack, ScenePack, write_text_file
from .targets import Writer

_IMPORT_LINES = (  # of README.txt
    "Import textures whose format ends in _SRGB as sRGB, all others as linear data; with no compression",
    "and no mipmaps but their own.",
)
_ATTRIBUTES = "TEXCOORD_0 is the baked UV layer, NORMAL and TANGENT its frame."
_OF_IMAGES = "TEXCOORD_0 is that of the images, with NORMAL and TANGENT, TEXCOORD_1 the baked UV layer."


def engine_writer(where: str) -> Writer:
    """The writer of a folder with shader includes and a README.txt; `where` is the last line for one bake."""
    return Writer(partial(_write, where=where), _write_scene)


def _write(pack: Pack, folder: Path, where: str) -> None:
    manifest = pack.manifest
    _copy_includes(pack, folder)
    lines = [
        f"{manifest.name}: a radiance texture, made by {manifest.tool}",
        "",
        *file_lines(manifest, _OF_IMAGES if manifest.images else _ATTRIBUTES),
        "shaders/: the includes to look it up by (MIT licence).",
        "",
        *manifest.form.usage(manifest.bake, manifest.textures),
        "",
        *_IMPORT_LINES,
        where,
    ]
    _write_readme(lines, folder)


def _write_scene(pack: ScenePack, folder: Path) -> None:
    _copy_includes(pack, folder)
    _write_readme(_lines_of_scene(pack), folder)


def _write_readme(lines: Iterable[str], folder: Path) -> None:
    write_text_file(folder / "README.txt", "".join(f"{in_comment(line)}\n" for line in lines))


def _copy_includes(pack: Pack | ScenePack, folder: Path) -> None:
    """Copy the shader includes that look the bakes up, in the target's languages, into `shaders`."""
    languages = pack.spec.target.traits.languages
    stems = {stem for manifest in pack.manifests for stem in manifest.form.includes(manifest.bake)}
    names = [f"{stem}.{ending}" for ending in languages for stem in stems]
    (folder / "shaders").mkdir()
    for name in (*names, *(["radtex_pages.wgsl"] * ("wgsl" in languages)), "LICENSE"):
        if (SHADERS / name).is_file():
            shutil.copyfile(SHADERS / name, folder / "shaders" / name)


def _lines_of_scene(pack: ScenePack) -> Iterator[str]:
    """The lines of README.txt: the files, the nodes, and how each bake is looked up."""
    yield f"{pack.name}: a scene of {len(pack.manifests)} radiance textures, made by {pack.manifests[0].tool}"
    yield ""
    yield f"{pack.mesh}: the meshes, a node for each object. TEXCOORD_0 is the baked UV layer, NORMAL and"
    yield "TANGENT its frame."
    yield f"{pack.name}.{EXTENSION}: which node has which textures, for programs."
    yield "shaders/: the includes to look them up by (MIT licence)."
    yield ""
    for entry in pack.entries:
        farther = ", ".join(level.node for level in entry.levels)
        yield f"node {entry.node}: {entry.manifest.name}" + (f"; farther away {farther}" if farther else "")
    for manifest in pack.manifests:
        yield from _bake(manifest, pack)
    yield ""
    yield from _IMPORT_LINES


def _bake(manifest: Manifest, pack: ScenePack) -> Iterator[str]:
    bake = manifest.bake
    width, height = bake["texels"]
    yield ""
    yield f"{manifest.name}"
    yield f"layout {bake['layout']}, {width} x {height} texels of {bake['bucket']} x {bake['bucket']} cells"
    yield f"{manifest.flat}: a flat lightmap, the mean of each texel's light; also inside {pack.mesh}."
    for layer, entry in manifest.textures.items():
        yield _described(layer, entry)
    yield from manifest.form.usage(bake, manifest.textures)


def file_lines(manifest: Manifest, mesh: str) -> list[str]:
    """Lines that say what a folder's mesh, textures and manifest are; `mesh`: what its attributes hold."""
    bake = manifest.bake
    width, height = bake["texels"]
    whole = not set(bake.get("layers", ())) <= set(manifest.textures)  # all materials show images
    inside = "" if manifest.images and whole else "; also inside the mesh's file"
    lines = [
        f"{manifest.mesh}: the mesh. {mesh}",
        f"{manifest.flat}: a flat lightmap, the mean of each texel's light{inside}.",
        f"{manifest.name}.export.json: all of this for programs.",
        *(_described(layer, entry) for layer, entry in manifest.textures.items()),
        f"layout {bake['layout']}, {width} x {height} texels of {bake['bucket']} x {bake['bucket']} cells",
    ]
    return list(map(in_comment, lines))


def _described(layer: str, entry: TextureEntry) -> str:
    """A line of README.txt on a texture."""
    width, height = entry.size
    layers = f" x {entry.layers} layers" if entry.layers > 1 else ""
    levels = f", {entry.levels} mip levels" if entry.levels > 1 else ""
    first = "v = 1, the top" if entry.container is Container.EXR else "v = 0, the bottom"
    return f"{entry.file}: {layer}, {entry.format}, {width} x {height}{layers}{levels}; first row: {first}"
