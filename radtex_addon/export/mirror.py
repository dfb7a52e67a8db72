# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a moving mirror needs of an export: the mesh as a texture for tracing rays, and the ball's way.

docs/format.md, "The mirror", describes the texture; shaders/radtex_trace.* read it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..bake.kinds import KINDS, Kind
from ..core.arrangements import Pages
from ..core.arrays import Floats
from ..core.errors import FormatError, InputError
from ..core.ray_tree import IN_LEAF, RayTree, build_tree
from ..core.surface import SurfaceMesh
from ..formats.containers.texture import PixelFormat, Texture
from ..formats.json_reader import Facts
from ..textures.entry import Arranged, Container, TextureEntry
from ..textures.export_spec import ExportSpec
from ..textures.texture_files import entry_of, write_encoded
from .mirror_path import BallPath, path_over

MOST_MATERIALS = 16  # of a layered bake: shaders have the values of all in their uniforms
_OF_NODE, _OF_TRIANGLE = 2, 9  # texels
_EXACT = 2**24  # whole numbers up to here are exact in 32-bit floats
_WIDTH, _WIDER, _TALL = 1024, 4096, 8192  # texels
_BLACK = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Mirror:
    """The manifest's `mirror`: the texture's entry and contents, the `sky`, and the ball's `path`."""

    entry: TextureEntry
    nodes: int
    triangles: int
    sky: tuple[float, float, float]
    path: BallPath

    def facts(self) -> dict[str, Any]:
        """The JSON's keys and values, in order."""
        return {
            **self.entry.facts(),
            "nodes": self.nodes,
            "triangles": self.triangles,
            "sky": list(self.sky),
            **self.path.facts(),
        }

    @classmethod
    def from_facts(cls, facts: Facts) -> Mirror:
        """Inverse of `facts`. Raises FormatError for a missing or mistyped key, or too large a tree."""
        red, green, blue = facts.numbers("sky", 3)
        entry = TextureEntry.from_facts(facts)
        nodes = facts.whole_number("nodes", 1, _EXACT)
        triangles = facts.whole_number("triangles", 1, _EXACT)
        if _OF_NODE * nodes + _OF_TRIANGLE * triangles > entry.size[0] * entry.size[1]:
            raise FormatError(f"{facts.source} has more nodes and triangles than pixels: export it again")
        return cls(entry, nodes, triangles, (red, green, blue), BallPath.from_facts(facts))


def check_mirror(bake: Path | str, kind: str, materials: int) -> None:
    """Raise InputError if no mirror shows bakes of this kind, or with so many materials."""
    if not KINDS[Kind(kind)].looks_at_surface:
        raise InputError(f"{bake} is of kind {kind}: a mirror ball shows radiance alone")
    if materials > MOST_MATERIALS:
        raise InputError(
            f"{bake} has {materials} materials: a mirror ball tells {MOST_MATERIALS} apart at most"
        )


def write_mirror(
    surface: SurfaceMesh, mirrored: bool, culled: bool, name: str, spec: ExportSpec, folder: Path
) -> Mirror:
    """Write a bake's surface as a texture; `mirrored` if its object's matrix is, `culled` as in the manifest.

    Raises InputError for a mesh with too many triangles.
    """
    corners = surface.corner_position.astype(np.float64)
    tree = build_tree(corners)
    texels = packed(surface, tree, mirrored)
    width = _WIDTH if len(texels) <= _WIDTH * _TALL else _WIDER
    height = -(-len(texels) // width)
    if height > _TALL or 8 * len(corners) + IN_LEAF >= _EXACT:
        raise InputError(f"{name} has {len(corners)} triangles: too many for a mirror ball")
    image = np.zeros((height * width, 4), np.float32)
    image[: len(texels)] = texels
    blocks = image.reshape(1, height, width, 4).view(np.uint8)
    texture = Texture(PixelFormat.RGBA32F, width, height, (blocks,))
    path = folder / f"{name}.mirror.ktx2"
    zstd = write_encoded(path, Container.KTX2, texture, spec, premultiplied=False)
    pages = Pages(1, 1, width, height)
    entry = entry_of(path, Container.KTX2, texture, zstd, Arranged.TREE, (width, height), pages)
    ball = path_over(surface, mirrored, culled)
    return Mirror(entry, len(tree.skip), len(corners), spec.sky or _BLACK, ball)


def packed(surface: SurfaceMesh, tree: RayTree, mirrored: bool) -> Floats:
    """The texels (K, 4) of a tree and its triangles, whose corners `mirrored` turns the other way round."""
    nodes = np.zeros((len(tree.skip), _OF_NODE, 4), np.float32)
    nodes[:, 0, :3] = np.nextafter(tree.low.astype(np.float32), np.float32(-np.inf))
    nodes[:, 1, :3] = np.nextafter(tree.high.astype(np.float32), np.float32(np.inf))
    nodes[:, 0, 3] = tree.skip
    nodes[:, 1, 3] = np.where(tree.count > 0, 8 * tree.first + tree.count, 0)
    turn = [0, 2, 1] if mirrored else [0, 1, 2]
    triangles = np.zeros((len(tree.order), 3, 3, 4), np.float32)  # what, corner, value
    order = tree.order
    triangles[:, 0, :, :3] = surface.corner_position[order][:, turn]
    triangles[:, 1, :, :3] = surface.normal[order][:, turn]
    triangles[:, 2, :, :3] = surface.tangent[order][:, turn]
    triangles[:, 0, :, 3] = surface.uv[order][:, turn, 0]
    triangles[:, 1, :, 3] = surface.uv[order][:, turn, 1]
    triangles[:, 2, 0, 3] = surface.sign[order][:, 0]
    triangles[:, 2, 1, 3] = surface.material_numbers[order]
    found: Floats = np.concatenate([nodes.reshape(-1, 4), triangles.reshape(-1, 4)])
    assert len(found) == _OF_NODE * len(nodes) + _OF_TRIANGLE * len(triangles)
    return found


def materials_of(shader: Mapping[str, Any] | None) -> int:
    """How many materials a bake's shader tells apart, by the manifest's `shader`."""
    return 1 if shader is None else len(shader["materials"])
