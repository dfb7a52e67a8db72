# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a moving mirror needs of an export: the mesh as a texture for tracing rays, and the ball's way.

docs/format.md, "The mirror", describes the texture; shaders/radtex_trace.* read it.

A mirror ball moves by itself on an ellipse that keeps clear of the surface and is before its front.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..core.arrangements import Pages
from ..core.arrays import Floats
from ..core.errors import FormatError, InputError
from ..core.ray_tree import IN_LEAF, RayTree, build_tree
from ..core.surface import SurfaceMesh
from ..formats.containers.texture import PixelFormat, Texture
from ..formats.json_reader import Facts
from ..settings.kinds import KINDS, Kind
from ..textures.entry import Arranged, Container, TextureEntry
from ..textures.export_spec import ExportSpec
from ..textures.texture_files import entry_of, write_encoded

_SAMPLES = 6000  # points of the surface that distances are taken to
_PLACES = 24  # of an ellipse that are tried
_SIZE = 0.14  # radius, in shares of half the surface's greatest extent
_SCALES = (0.5, 0.35, 0.7, 0.9, 1.2, 1.5, 1.9)  # of ellipses, in shares of half the extents
_HEIGHTS = (0.5, 0.65, 0.8, 0.35, 1.2)  # in shares of the extent, from below
_CLEAR = 1.15  # radii
MOST_MATERIALS = 16  # of a layered bake: shaders have the values of all in their uniforms
_OF_NODE, _OF_TRIANGLE = 2, 9  # texels
_EXACT = 2**24  # whole numbers up to here are exact in 32-bit floats
_WIDTH, _WIDER, _TALL = 1024, 4096, 8192  # texels
_BLACK = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class BallPath:
    """A level ellipse about `middle`, with half axes `across` along x and y, and the ball's `radius`.

    In Blender's world space of the bake.
    """

    middle: tuple[float, float, float]
    across: tuple[float, float]
    radius: float

    def facts(self) -> dict[str, Any]:
        """The JSON's keys and values."""
        return {"middle": list(self.middle), "across": list(self.across), "radius": self.radius}

    @classmethod
    def from_facts(cls, facts: Facts) -> BallPath:
        """Inverse of `facts`. Raises FormatError for a missing or mistyped key."""
        x, y, z = facts.numbers("middle", 3)
        a, b = facts.numbers("across", 2)
        return cls((x, y, z), (a, b), facts.positive("radius"))


def path_over(surface: SurfaceMesh, mirrored: bool, culled: bool) -> BallPath:
    """The first of some ellipses on which the ball touches nothing and is not inside; else the widest one.

    With `culled`, faces have twins, so that the front of one is the back of another: no side is the inside.
    """
    points, normals = _points(surface, mirrored)
    low, high = surface.position.min(axis=0), surface.position.max(axis=0)
    half = np.maximum((high - low) / 2, 1e-6 * float(np.ptp(surface.position)) + 1e-9)
    middle, radius = (low + high) / 2, _SIZE * float(half.max())
    found = None
    for scale in _SCALES:
        across = np.maximum(scale * half[:2], radius)
        for height in _HEIGHTS:
            place = np.array([middle[0], middle[1], low[2] + height * (high[2] - low[2])])
            if height > 1 or high[2] - low[2] < 3 * radius:
                place[2] = max(place[2], low[2] + 2 * radius)
            found = BallPath(_three(place), (float(across[0]), float(across[1])), radius)
            if _is_clear(found, points, normals, culled):
                return found
    assert found is not None
    return found


def _is_clear(path: BallPath, points: Floats, normals: Floats, culled: bool) -> bool:
    angles = np.linspace(0, 2 * np.pi, _PLACES, endpoint=False)
    circle = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(_PLACES)])
    for place in np.array(path.middle) + circle * np.array([*path.across, 0.0]):
        away = place - points
        squared = np.sum(away * away, axis=1)
        nearest = int(np.argmin(squared))
        if squared[nearest] < (_CLEAR * path.radius) ** 2:
            return False
        if not culled and float(away[nearest] @ normals[nearest]) < 0:
            return False
    return True


def _points(surface: SurfaceMesh, mirrored: bool) -> tuple[Floats, Floats]:
    """Points of the surface (N, 3), in proportion to area, and their triangles' normals."""
    corners = surface.corner_position.astype(np.float64)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal *= -1.0 if mirrored else 1.0
    area = np.linalg.norm(normal, axis=1)
    chance = area / area.sum() if area.sum() > 0 else np.full(len(area), 1 / len(area))
    random = np.random.default_rng(0)
    chosen = random.choice(len(corners), _SAMPLES, p=chance)
    weight = random.dirichlet((1.0, 1.0, 1.0), _SAMPLES)
    points: Floats = np.einsum("nk,nkc->nc", weight, corners[chosen])
    return points, normal[chosen]


def _three(place: Floats) -> tuple[float, float, float]:
    return float(place[0]), float(place[1]), float(place[2])


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
