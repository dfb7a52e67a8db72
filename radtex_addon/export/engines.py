# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Targets without a ready-made project: the folder gets shader includes and a README beside the textures."""

from __future__ import annotations

import shutil
from collections.abc import Iterable
from pathlib import Path

from ..core.quoting import in_comment
from ..textures.entry import Container, TextureEntry
from ..textures.export_spec import Target
from .export_manifest import Manifest
from .pack import SHADERS, Pack

_LANGUAGES = {
    Target.GLTF: ("glsl",),
    Target.RAW: ("glsl", "hlsl", "wgsl", "gdshaderinc", "osl"),
}
_WHERE = {
    Target.GLTF: "Any program opens the .glb; one that knows no radiance textures shows the flat lightmap.",
    Target.RAW: "The includes say at their top how they are called.",
}
_FIRST_ROW = "first row: v = {}"
IMPORT_LINES = (  # of README.txt
    "Import textures whose format ends in _SRGB as sRGB, all others as linear data; with no compression",
    "and no mipmaps but their own.",
)


def write_engine(pack: Pack, folder: Path) -> None:
    """Add the shader includes that the bake's layout needs, and a README.txt, to a pack's folder."""
    copy_includes(includes(pack.spec.target, pack), folder)
    (folder / "README.txt").write_text(readme(pack), encoding="utf-8", newline="\n")


def copy_includes(sources: Iterable[Path], folder: Path) -> None:
    """Copy shader includes and their licence into the folder `shaders` of an export."""
    shaders = folder / "shaders"
    shaders.mkdir()
    for source in (*sources, SHADERS / "LICENSE"):
        shutil.copyfile(source, shaders / source.name)


def includes(target: Target, pack: Pack) -> list[Path]:
    """The shader includes to look the bake up, in the languages of the target."""
    stems = pack.manifest.form.includes(pack.manifest.bake)
    found = [SHADERS / f"{stem}.{ending}" for ending in _LANGUAGES[target] for stem in stems]
    if "wgsl" in _LANGUAGES[target]:
        found.append(SHADERS / "radtex_pages.wgsl")
    return [path for path in found if path.is_file()]


def readme(pack: Pack) -> str:
    """The text of README.txt: the files in the folder, and how to look the bake up."""
    manifest, target = pack.manifest, pack.spec.target
    lines = [
        f"{manifest.name}: a radiance texture, made by {manifest.tool}",
        "",
        *file_lines(manifest, "TEXCOORD_0 is the baked UV layer, NORMAL and TANGENT its frame."),
        "shaders/: the includes to look it up by (MIT licence).",
        "",
        *manifest.form.usage(manifest.bake, manifest.textures, target),
        "",
        *IMPORT_LINES,
        _WHERE[target],
    ]
    return "".join(f"{in_comment(line)}\n" for line in lines)


def file_lines(manifest: Manifest, mesh: str) -> list[str]:
    """Lines that say what a folder's mesh, textures and manifest are; `mesh`: what its attributes hold."""
    bake = manifest.bake
    width, height = bake["texels"]
    lines = [
        f"{manifest.mesh}: the mesh. {mesh}",
        f"{manifest.flat}: a flat lightmap, the mean of each texel's light; also inside the mesh's file.",
        f"{manifest.name}.export.json: all of this for programs.",
        *(described(layer, entry) for layer, entry in manifest.textures.items()),
        f"layout {bake['layout']}, {width} x {height} texels of {bake['bucket']} x {bake['bucket']} cells",
    ]
    return list(map(in_comment, lines))


def described(layer: str, entry: TextureEntry) -> str:
    """A line of README.txt on a texture."""
    width, height = entry.size
    layers = f" x {entry.layers} layers" if entry.layers > 1 else ""
    levels = f", {entry.levels} mip levels" if entry.levels > 1 else ""
    first = _FIRST_ROW.format("1, the top" if entry.container is Container.EXR else "0, the bottom")
    return f"{entry.file}: {layer}, {entry.format}, {width} x {height}{layers}{levels}; {first}"
