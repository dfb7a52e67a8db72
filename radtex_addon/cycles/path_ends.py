# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene whose light encodes where it comes from: everything but the baked objects emits its own direction.

The objects keep their materials, so paths go through them as in the user's scene; but the light that they
return is the direction, from the objects' middle, of the point that they hit after leaving the objects. The
same paths, traced again with everything emitting white, return how much the objects let through. The
objects' own emission and all lamps are removed, so that no other light is returned.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, cast

import bpy
import numpy as np
from mathutils import Matrix

from ..core.arrays import Floats
from ..scene.checks.see_through import is_see_through
from ..scene.lights.light import without_emission
from ..scene.mesh.copy import copy_object
from ..scene.mesh.joined import values_in
from ..scene.mesh.render_contents import RAYS, Placed, Shape
from ..scene.nodes import NodeBuilder, close_group, open_group, open_material, open_world
from ..scene.scratch import remove_scene

TURNS = 3  # ways to assign a direction's components to red, green and blue
_DARK = 1e-4  # times a weight's brightest channel: darker channels are too dark to read a component in


@dataclass(frozen=True, eq=False)
class Body:
    """A baked object: the `original`, the `mesh` that renders for it, and its matrix (4, 4) in renders."""

    original: bpy.types.Object
    mesh: bpy.types.Mesh
    matrix: Floats

    @property
    def shape(self) -> Shape:
        """The mesh's faces, which are triangles."""
        corner = values_in(self.mesh.loops, "vertex_index", 1, np.int32)
        return Shape(values_in(self.mesh.vertices, "co", 3), corner.reshape(-1, 3))

    @property
    def shown_materials(self) -> set[bpy.types.Material | None]:
        """The materials that its faces have, not those of slots without faces; None of faces without one."""
        slots = list(self.mesh.materials) or [None]
        shown = np.unique(values_in(self.mesh.polygons, "material_index", 1, np.int32))
        return {slots[min(int(index), len(slots) - 1)] for index in shown}

    @property
    def hiding(self) -> Shape | None:
        """The mesh's faces that hide what is behind them, and are not clear; None if there are none."""
        shape, materials = self.shape, list(self.mesh.materials)
        clear = np.array([each is not None and is_see_through(each, glass=True) for each in materials])
        if not clear.any():
            return shape
        index = values_in(self.mesh.polygons, "material_index", 1, np.int32)[:, 0]
        triangles = shape.triangles[~clear[np.minimum(index, len(clear) - 1)]]
        return Shape(shape.position, triangles) if len(triangles) else None

    @property
    def places(self) -> Floats:
        """The mesh's vertices in world space, (V, 3) float64."""
        place = values_in(self.mesh.vertices, "co", 3).astype(np.float64)
        moved: Floats = place @ self.matrix[:3, :3].T + self.matrix[:3, 3]
        return moved


def black_material() -> bpy.types.Material:
    """A new material that ends paths: black, without gloss."""
    material, build = open_material("RadTex black")
    black = build.node("ShaderNodeBsdfDiffuse", (0.0, 0.0, 0.0, 1.0))
    build.node("ShaderNodeOutputMaterial", black.outputs[0])
    return material


class PathEnds:
    """The scene, the copies of the baked objects in it, and the light that everything else emits."""

    def __init__(
        self,
        scene: bpy.types.Scene,
        originals: Sequence[bpy.types.Object],
        copies: Sequence[bpy.types.Object],
        others: Sequence[bpy.types.Mesh],
        group: bpy.types.ShaderNodeTree,
    ) -> None:
        self.scene, self.copies, self._originals, self._group = scene, copies, originals, group
        self._others = others

    @contextmanager
    def named_alike(self) -> Iterator[None]:
        """Give the copies the objects' names during a render: Object Info's Random depends on the name."""
        names, own = ([item.name for item in items] for items in (self._originals, self.copies))
        # names of linked objects cannot clash with the file's own
        local = [item.library is None for item in self._originals]
        try:
            for original in (item for item, here in zip(self._originals, local, strict=True) if here):
                original.name = "RadTex original"
            for copy, name in zip(self.copies, names, strict=True):
                copy.name = name
            yield
        finally:
            for copy, name in zip(self.copies, own, strict=True):
                copy.name = name
            for original, name, here in zip(self._originals, names, local, strict=True):
                if here:
                    original.name = name

    def blacken_objects(self) -> None:
        """Make the objects black, so that paths end where they meet them."""
        self._cover(black_material())

    def emit(self, bodies: bpy.types.Material, others: bpy.types.Material) -> None:
        """Give the objects one material, and everything else another."""
        self._cover(bodies)
        for mesh in self._others:
            mesh.materials[0] = others

    def _cover(self, material: bpy.types.Material) -> None:
        for copy in self.copies:
            mesh = cast(bpy.types.Mesh, cast(bpy.types.ID, copy.data).copy())
            mesh.materials.clear()
            mesh.materials.append(material)
            copy.data = mesh

    def emit_directions(self, turn: int) -> None:
        """Emit directions d as d / 2 + 1/2, with components rotated by `turn` among red, green and blue."""
        self._write(turn)

    def emit_white(self) -> None:
        """Emit (1, 1, 1)."""
        self._write(None)

    def _write(self, turn: int | None) -> None:
        values = emission_values(turn)
        for node in self._group.nodes:
            if node.label in values:
                cast(Any, node).outputs[0].default_value = values[node.label]


def emission_values(turn: int | None) -> dict[str, float]:
    """Values of the light's nodes by their labels, for directions at a turn, or for white light if None."""
    turns = {f"turn {index}": float(index == (turn or 0)) for index in range(TURNS)}
    return {"white": float(turn is None)} | turns


def light_tree(scene: bpy.types.Scene) -> bpy.types.NodeTree:
    """The node group of the light in a scene that `path_ends` has made, with the nodes of these labels."""
    nodes = cast(Any, scene.world).node_tree.nodes
    return cast(bpy.types.NodeTree, next(node.node_tree for node in nodes if node.type == "GROUP"))


def any_dark(white: Floats) -> bool:
    """Whether any weight (..., 3) has a channel too dark to read a direction's component in."""
    brightest = white.max(axis=-1, keepdims=True)
    return bool(((white < _DARK * brightest) & (brightest > _DARK)).any())


def from_directions(emitted: Sequence[Floats], white: Floats) -> Floats:
    """Decode directions (..., 3): not of unit length where a sample mixes several, 0 where there is none.

    `white` (..., 3) is the render with white light; `emitted` are those with directions, at turn 0, or at all
    TURNS: then each component is read in the brightest channel.
    """
    shares = np.stack([_share(light, white) for light in emitted], axis=-2)
    if len(emitted) < TURNS:
        first: Floats = shares[..., 0, :] * 2 - 1
        return first
    brightest = white.argmax(axis=-1)[..., None]
    turn = (brightest - np.arange(3)) % TURNS  # puts each component into the brightest channel
    by_turn_and_channel = shares.reshape(*white.shape[:-1], TURNS * 3)
    read: Floats = np.take_along_axis(by_turn_and_channel, turn * 3 + brightest, axis=-1) * 2 - 1
    return read


def _share(light: Floats, white: Floats) -> Floats:
    return np.divide(light, white, out=np.full_like(light, 0.5), where=white > 0)


@contextmanager
def path_ends(
    scratch: bpy.types.Scene, bodies: Sequence[Body], others: Sequence[Placed], middle: Floats
) -> Iterator[PathEnds]:
    """Build the scene from the scratch scene `scratch`: copies of the baked `bodies`, and the `others`.

    Directions are from the point `middle` (3,). New data is removed together with the scratch scene's.
    """
    group = _light_group()
    scene = cast(bpy.types.Scene, scratch.copy())
    try:
        root = scene.collection
        for collection in list(root.children):
            root.children.unlink(collection)
        for item in list(root.objects):
            root.objects.unlink(item)
        scene.world = _world(group)
        anchor = cast(bpy.types.Object, bpy.data.objects.new("RadTex anchor", None))
        copies = [_stand_in(body.original, body.mesh) for body in bodies]
        for copy, body in zip(copies, bodies, strict=True):
            place_exactly(copy, anchor, body.matrix)
            root.objects.link(copy)
        meshes = _link_others(scene, anchor, others, _glow(group, middle))
        yield PathEnds(scene, [body.original for body in bodies], copies, meshes, group)
    finally:
        remove_scene(scene)


def _stand_in(baked: bpy.types.Object, mesh: bpy.types.Mesh) -> bpy.types.Object:
    """A copy of the object that emits no light, without animation and constraints."""
    dark = cast(bpy.types.Mesh, mesh.copy())
    for index, material in enumerate(dark.materials):
        if material is not None:
            dark.materials[index] = without_emission(material)
    _render_layer_of(baked, dark)
    copy = copy_object(baked, dark)
    for collection in copy.users_collection:  # Blender 5 adds a rigid body's copy to its world
        collection.objects.unlink(copy)
    copy.animation_data_clear()
    copy.constraints.clear()
    copy.instance_type = "NONE"
    return copy


def _render_layer_of(baked: bpy.types.Object, mesh: bpy.types.Mesh) -> None:
    """Let textures without a named UV layer use the object's own render layer, not the baked one."""
    for layer in getattr(baked.data, "uv_layers", ()):
        if layer.active_render and layer.name in mesh.uv_layers:
            cast(Any, mesh).uv_layers[layer.name].active_render = True


def place_exactly(item: bpy.types.Object, anchor: bpy.types.Object, matrix: Floats) -> None:
    """Give an object exactly this `matrix` (4, 4), as parent inverse: its own transform would lose shear."""
    item.parent, item.parent_type = anchor, "OBJECT"
    item.matrix_basis = Matrix.Identity(4)
    item.delta_location, item.delta_scale = (0, 0, 0), (1, 1, 1)
    item.delta_rotation_euler, item.delta_rotation_quaternion = (0, 0, 0), (1, 0, 0, 0)
    item.matrix_parent_inverse = Matrix(matrix.tolist())


def _link_others(
    scene: bpy.types.Scene, anchor: bpy.types.Object, others: Sequence[Placed], glow: bpy.types.Material
) -> list[bpy.types.Mesh]:
    """Add everything else that renders, with the emitting material `glow`; returns its meshes."""
    meshes: dict[Shape, bpy.types.Mesh] = {}
    for placed in others:
        mesh = meshes.get(placed.shape)
        if mesh is None:
            mesh = meshes[placed.shape] = bpy.data.meshes.new("RadTex other")
            mesh.from_pydata(placed.shape.position, [], placed.shape.triangles)
            mesh.materials.append(glow)
        item = cast(bpy.types.Object, bpy.data.objects.new("RadTex other", mesh))
        for ray in RAYS:
            setattr(item, f"visible_{ray}", ray in placed.seen_by)
        place_exactly(item, anchor, placed.matrix)
        scene.collection.objects.link(item)
    return list(meshes.values())


def _light_group() -> bpy.types.ShaderNodeTree:
    """A node group: the colour to emit for the unit direction of a point."""
    build, (direction,) = open_group("RadTex ends", Direction="Vector")
    coded = build.vector("MULTIPLY_ADD", direction, (0.5, 0.5, 0.5), (0.5, 0.5, 0.5))
    x, y, z = build.separate(coded)
    turns = [
        build.vector("SCALE", build.combine(*order), _constant(build, f"turn {index}", index == 0))
        for index, order in enumerate(((x, y, z), (z, x, y), (y, z, x)))
    ]
    turned = build.vector("ADD", build.vector("ADD", turns[0], turns[1]), turns[2])
    white = _constant(build, "white", False)
    return close_group(build, Emission=build.mix(white, turned, (1.0, 1.0, 1.0)))


def _constant(build: NodeBuilder, label: str, on: bool) -> bpy.types.NodeSocket:
    node = build.node("ShaderNodeValue", label=label)
    cast(Any, node).outputs[0].default_value = float(on)
    return node.outputs[0]


def _world(group: bpy.types.ShaderNodeTree) -> bpy.types.World:
    world, build = open_world("RadTex ends")
    direction = build.node("ShaderNodeTexCoord").outputs["Generated"]
    (emission,) = build.group(group, direction)
    background = build.node("ShaderNodeBackground", emission, 1.0)
    build.node("ShaderNodeOutputWorld", background.outputs[0])
    cast(Any, world).cycles.sampling_method = "NONE"  # light is only found where paths hit it
    return world


def _glow(group: bpy.types.ShaderNodeTree, middle: Floats) -> bpy.types.Material:
    material, build = open_material("RadTex ends")
    from_middle = build.vector("SUBTRACT", build.geometry("Position"), tuple(middle.tolist()))
    (emission,) = build.group(group, build.vector("NORMALIZE", from_middle))
    shader = build.node("ShaderNodeEmission", emission, 1.0)
    build.node("ShaderNodeOutputMaterial", shader.outputs[0])
    cast(Any, material).cycles.emission_sampling = "NONE"
    return material
