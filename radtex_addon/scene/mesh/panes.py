# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Flat panes of clear glass before other things, such as table tops and display cases.

Light leaves a flat pane as it entered. So an engine shows what lies behind one exactly, by blending the pane
over it, where a picture of the surroundings shows it in about its place. For that a pane is baked with a
material that is clear to all rays, and reflects as both of its faces do together; only its fronts are drawn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import sqrt
from typing import Any, TypeAlias, cast

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from ...core.arrays import Floats, Ints
from ...core.frame import normalised
from ...core.islands import surface_areas
from ..checks.see_through import fills_volume, source_of, value_at
from ..nodes import NodeBuilder, operand_of
from .evaluated import EvaluatedMesh
from .scene_rays import Thing, cast_rays, read_things
from .triangle_tree import triangle_tree

_POINTS = 400  # on the glass, from which rays go through it
_PAIRED = 0.9  # share of them that must leave by a face parallel to theirs, and meet no more glass
_PARALLEL = -0.999  # at most, of both faces' outer normals' cosine
_THICKEST = 0.05  # times the square root of a face's area
_OPEN = 0.15  # most rays that may leave the scene: engines may have nothing there
_SMOOTH = 0.05  # most roughness of what one sees through clearly
_DENSEST = 2.5  # index of refraction
_OFF = 1e-5  # times the glass's size, by which rays start off faces
_MIXES = 8  # of shaders, one after another, that are followed
_WHITE = (1.0, 1.0, 1.0, 1.0)

Panes: TypeAlias = frozenset[bpy.types.Material]


def find_panes(
    scratch: bpy.types.Scene, originals: Sequence[bpy.types.Object], meshes: Sequence[EvaluatedMesh]
) -> list[Panes]:
    """Of each mesh, those of its materials that make flat panes before things of a scratch scene.

    The `meshes` are those of the scene's `originals`. Raises BakeError where Blender does not render.
    """
    glass = [[one for one in mesh.materials if one is not None and glass_in(one)] for mesh in meshes]
    if not any(glass):
        return [frozenset()] * len(meshes)
    things = read_things(scratch, originals)
    return [
        frozenset(one for one in own if _is_pane(_Glass.of(mesh, one), things))
        for mesh, own in zip(meshes, glass, strict=True)
    ]


def as_pane(material: bpy.types.Material) -> bpy.types.Material:
    """A copy of a pane's material that is clear, and reflects as a pane's two faces do: 2 F / (1 + F)."""
    copy = cast(bpy.types.Material, material.copy())
    tree: Any = copy.node_tree
    glass, build = glass_in(copy), NodeBuilder(tree)
    principled = glass.type == "BSDF_PRINCIPLED"
    colour = build.vector("SCALE", operand_of(glass.inputs["Base Color" if principled else "Color"]), 1.0)
    once = build.node("ShaderNodeFresnel", operand_of(glass.inputs["IOR"])).outputs[0]
    both = build.math("DIVIDE", build.math("MULTIPLY", once, 2.0), build.math("ADD", once, 1.0))
    # a Glass shader has its colour at each face, a Principled one its square root
    through = colour if principled else build.vector("MULTIPLY", colour, colour)
    clear = build.node("ShaderNodeBsdfTransparent", through)
    mirror: Any = build.node("ShaderNodeBsdfGlossy", _WHITE if principled else colour)
    build.feed(mirror.inputs["Roughness"], operand_of(glass.inputs["Roughness"]))
    shown = build.node("ShaderNodeMixShader", both, clear.outputs[0], mirror.outputs[0])
    tree.links.new(shown.outputs[0], tree.get_output_node("CYCLES").inputs["Surface"])
    return copy


def glass_in(material: bpy.types.Material, roughest: float = _SMOOTH) -> Any:
    """The node of glass that all camera rays meet in a material; None if it is not that alone.

    Of glass that is no rougher than `roughest`, of one index of refraction, without a normal map.
    """
    tree: Any = material.node_tree
    output = None if tree is None else tree.get_output_node("CYCLES")
    if output is None or fills_volume(material):
        return None
    socket = output.inputs["Surface"]
    for _ in range(_MIXES):
        node, _, groups = source_of(socket, ()) or (None, None, ())
        if node is None or groups:
            return None
        if node.type != "MIX_SHADER":
            return node if _is_glass(node, roughest) else None
        share = value_at(node.inputs[0], ())
        if share not in (0.0, 1.0):
            return None
        socket = node.inputs[1 + int(share)]
    return None


def _is_glass(node: Any, roughest: float) -> bool:
    least = {"Roughness": (0.0, roughest), "IOR": (1.0, _DENSEST)}
    if node.type == "BSDF_PRINCIPLED":
        least |= {"Transmission Weight": (1.0, 1.0), "Alpha": (1.0, 1.0)}
        least |= dict.fromkeys(("Metallic", "Coat Weight", "Sheen Weight", "Emission Strength"), (0.0, 0.0))
    elif node.type != "BSDF_GLASS":
        return False
    values = {name: value_at(node.inputs[name], ()) for name in least}
    known = all(
        value is not None and least[name][0] <= value <= least[name][1] for name, value in values.items()
    )
    return known and not node.inputs["Normal"].is_linked


@dataclass(frozen=True, eq=False)
class _Glass:
    """Triangles of one material of a mesh: their `faces` (F',), among those of the mesh's `tree`.

    `corners` (F, 3, 3) and outer unit `normals` (F, 3) are the mesh's, in world space.
    """

    tree: BVHTree
    corners: Floats
    normals: Floats
    faces: Ints

    @classmethod
    def of(cls, mesh: EvaluatedMesh, material: bpy.types.Material) -> _Glass:
        triangles = mesh.triangles[:, ::-1] if mesh.mirrored else mesh.triangles
        place = mesh.world_position
        corners = place[triangles]
        a, b, c = corners.transpose(1, 0, 2)
        normals = normalised(np.cross(b - a, c - a))
        own = np.array([one == material for one in mesh.materials])[mesh.material_index]
        return cls(triangle_tree(place, triangles), corners, normals, np.flatnonzero(own))

    @cached_property
    def areas(self) -> Floats:
        """Of its faces, (F',)."""
        return surface_areas(self.corners[self.faces])

    def through(self) -> tuple[Floats, Floats, float]:
        """Rays along the normals of places on it that leave by a parallel face near by, and meet no more.

        The places where they leave and their ways, (P, 3) both, and which share of all these are.
        """
        areas, random = self.areas, np.random.default_rng(0)
        face = self.faces[random.choice(len(areas), _POINTS, p=areas / areas.sum())]
        one, other = random.random((2, _POINTS, 1))
        turned = one + other > 1
        one, other = np.where(turned, 1 - one, one), np.where(turned, 1 - other, other)
        a, b, c = self.corners[face].transpose(1, 0, 2)
        start, way = a + one * (b - a) + other * (c - a), -self.normals[face]
        off = _OFF * float(np.ptp(self.corners.reshape(-1, 3), axis=0).max())
        thickest = _THICKEST * sqrt(float(areas.sum()) / 2)
        own, cast_ray = set(self.faces.tolist()), cast(Any, self.tree.ray_cast)
        ends, ways = [], []
        for place, along in zip(start, way, strict=True):
            met, _, hit, far = cast_ray(Vector(place + off * along), Vector(along), thickest)
            if met is None or hit not in own or self.normals[hit] @ -along > _PARALLEL:
                continue
            end = place + (far + 2 * off) * along
            if (beyond := cast_ray(Vector(end), Vector(along))[2]) is None or beyond not in own:
                ends.append(end)
                ways.append(along)
        return np.array(ends).reshape(-1, 3), np.array(ways).reshape(-1, 3), len(ends) / _POINTS


def _is_pane(glass: _Glass, things: Sequence[Thing]) -> bool:
    """Whether it is a flat pane through which one sees `things`, nearly wherever one looks."""
    if not len(glass.faces) or not glass.areas.sum() > 0:
        return False
    ends, ways, share = glass.through()
    if share < _PAIRED:
        return False
    aside = normalised(np.random.default_rng(1).normal(size=ways.shape))
    return bool(cast_rays(things, ends, normalised(ways + 0.999 * aside)).leaves.mean() < _OPEN)
