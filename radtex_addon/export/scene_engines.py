# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene for targets without a ready-made project: the shader includes of all bakes, and a README.txt."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from ..core.quoting import in_comment
from .engines import IMPORT_LINES, copy_includes, described, includes
from .export_manifest import EXTENSION, Manifest
from .pack import Pack
from .scene_manifest import SceneEntry, ScenePack


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
