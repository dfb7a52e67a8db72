# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a render shows, where, and to which rays: asked of the evaluated scene of a render.

`scene.objects` does not tell: it has what collections leave out of renders, and lacks instances. An object's
own `matrix_world` is that of the last evaluation for a viewport, which skips what is hidden there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias, TypeVar, cast

import bpy
import numpy as np

from ...core.arrays import Bools, Floats, Ints
from ..surfaces import is_own_mesh
from .evaluated import materials_shown, render_with

RAYS = ("camera", "diffuse", "glossy", "transmission", "volume_scatter", "shadow")
_Read = TypeVar("_Read")
_LeftOut: TypeAlias = Callable[[bpy.types.Material | None], bool]
_TOP = "radtex_top"  # a custom property of scratch scenes


@dataclass(frozen=True, eq=False)
class Shape:
    """Vertices (V, 3) float32 in object space and triangles (F, 3), at least one."""

    position: Floats
    triangles: Ints


@dataclass(frozen=True, eq=False)
class Placed:
    """A shape in the world: `matrix` (4, 4) from object to world, and the kinds of RAYS that see it."""

    shape: Shape
    matrix: Floats
    seen_by: frozenset[str]


@dataclass(frozen=True, eq=False)
class Beside:
    """An object's matrix (4, 4) in renders, and all `others` around it; instances share their shapes."""

    matrix: Floats
    others: tuple[Placed, ...]


@dataclass(frozen=True, eq=False)
class Shown:
    """One thing in a render: an object by itself, or an instance of one. See `read_render`.

    `evaluated` is the object as it renders, `original` what it was evaluated from, and `owner` the original
    of the scene's object that puts it there: the object itself, or the one that instances it, maybe by its
    particles (`of_particles`). `matrix` (4, 4)
    float64, from object to world, and `bounds` (8, 3), the corners of its box in the world, may have values
    that are not finite.
    """

    evaluated: Any
    is_instance: bool
    matrix: Floats
    of_particles: bool
    _evaluated_owner: Any
    _layer: Any
    _shapes: dict[tuple[int, int], Shape | None]

    @property
    def original(self) -> bpy.types.Object:
        return cast(bpy.types.Object, self.evaluated.original)

    @property
    def owner(self) -> bpy.types.Object:
        return cast(bpy.types.Object, self._evaluated_owner.original)

    @property
    def seen_by(self) -> frozenset[str]:
        """The kinds of RAYS that see it: those that see both the object and its owner."""
        both = self.evaluated, self._evaluated_owner
        seen = {ray for ray in RAYS if all(getattr(item, f"visible_{ray}") for item in both)}
        if any(item.indirect_only_get(view_layer=self._layer) for item in (self.original, self.owner)):
            seen.discard("camera")
        return frozenset(seen)

    @property
    def bounds(self) -> Floats:
        corners = np.array(self.evaluated.bound_box, dtype=np.float64)
        found: Floats = corners @ self.matrix[:3, :3].T + self.matrix[:3, 3]
        return found

    @property
    def shape(self) -> Shape | None:
        """Its faces without those that are a mere volume's boundary; None if there are none.

        Instances of one mesh have the same shape.
        """
        item = self.evaluated
        if item.type != "MESH":  # curves, texts and metaballs come as meshes, too
            return None
        key = item.original.session_uid, item.data.as_pointer()  # geometry nodes instance bare meshes
        if key not in self._shapes:
            self._shapes[key] = _shape_of(item, _is_mere_volume)
        return self._shapes[key]

    def shape_without(self, left_out: Callable[[bpy.types.Material], bool]) -> Shape | None:
        """As `shape`, without the faces whose material is to be left out; it is read anew each time."""

        def both(material: bpy.types.Material | None) -> bool:
            original = None if material is None else cast(bpy.types.Material, material.original)
            return _is_mere_volume(material) or (original is not None and left_out(original))

        return _shape_of(self.evaluated, both) if self.evaluated.type == "MESH" else None


def read_render(scratch: bpy.types.Scene, read: Callable[[Iterator[Shown]], _Read]) -> _Read:
    """Call `read` with all that a render of the scratch scene's enabled view layer shows, lamps included.

    Things are only valid until the next one is taken. Raises BakeError where Blender does not render, and
    what `read` raises.
    """
    return render_with(scratch, lambda graph: read(shown_in(graph)))


def shown_in(graph: bpy.types.Depsgraph) -> Iterator[Shown]:
    """All that the depsgraph of a render shows, lamps included; valid until the next one is taken."""
    shapes: dict[tuple[int, int], Shape | None] = {}
    for instance in graph.object_instances:
        if not instance.show_self:
            continue
        item = instance.object
        owner = instance.parent if instance.is_instance and instance.parent else item
        matrix = np.array(instance.matrix_world, dtype=np.float64)
        is_instance = instance.is_instance and not is_own_mesh(instance)
        of_particles = is_instance and instance.particle_system is not None
        yield Shown(item, is_instance, matrix, of_particles, owner, graph.view_layer, shapes)


def read_beside(scratch: bpy.types.Scene, baked: bpy.types.Object) -> Beside:
    """Read what a render of the scratch scene's enabled view layer shows besides `baked`.

    That includes instances of `baked`, and objects that it instances. Faces whose material has a volume but
    no surface are left out, since light passes through them. Raises BakeError where Blender does not render.
    """

    def others(shown: Iterator[Shown]) -> tuple[Placed, ...]:
        beside = (one for one in shown if one.is_instance or one.original != baked)
        return tuple(
            Placed(shape, one.matrix, one.seen_by) for one in beside if (shape := one.shape) is not None
        )

    return Beside(matrices_in_renders(scratch, [baked])[0], read_render(scratch, others))


def matrices_in_renders(scratch: bpy.types.Scene, items: Sequence[bpy.types.Object]) -> list[Floats]:
    """The matrices (4, 4), from object to world, of objects in renders of a scratch scene.

    Raises BakeError where Blender does not render.
    """

    def read(graph: bpy.types.Depsgraph) -> list[Floats]:
        return [np.array(item.evaluated_get(graph).matrix_world, dtype=np.float64) for item in items]

    return render_with(scratch, read)


def top_of_render(scratch: bpy.types.Scene) -> float:
    """The height of the highest point of all that a scratch scene renders; 0 if all is below.

    It is kept in the scene, and so in its copies, which have nothing higher.
    """
    kept = cast(Any, scratch)
    if _TOP not in kept:
        heights = read_render(scratch, lambda shown: [float(one.bounds[:, 2].max()) for one in shown])
        kept[_TOP] = max([0.0, *filter(np.isfinite, heights)])
    return float(kept[_TOP])


def _shape_of(item: bpy.types.Object, left_out: _LeftOut) -> Shape | None:
    mesh = cast(Any, item.to_mesh())
    if mesh is None:
        return None
    try:
        mesh.calc_loop_triangles()
        position = np.empty((len(mesh.vertices), 3), dtype=np.float32)
        triangles = np.empty((len(mesh.loop_triangles), 3), dtype=np.int32)
        material = np.empty(len(mesh.loop_triangles), dtype=np.int32)
        mesh.vertices.foreach_get("co", position.ravel())
        mesh.loop_triangles.foreach_get("vertices", triangles.ravel())
        mesh.loop_triangles.foreach_get("material_index", material)
        triangles = triangles[_kept(item, mesh, material, left_out)]
    finally:
        item.to_mesh_clear()
    return Shape(position, triangles) if len(triangles) else None


def _kept(item: bpy.types.Object, mesh: bpy.types.Mesh, index: Ints, left_out: _LeftOut) -> Bools:
    """Which triangles, by their material indices `index` (F,), have a material that is kept: (F,)."""
    materials = materials_shown(item, mesh)
    if not materials:
        return np.ones(len(index), dtype=bool)
    kept = np.array([not left_out(material) for material in materials])
    found: Bools = kept[np.clip(index, 0, len(materials) - 1)]
    return found


def _is_mere_volume(material: bpy.types.Material | None) -> bool:
    if material is None or material.node_tree is None:
        return False
    output = cast(Any, material.node_tree).get_output_node("CYCLES")
    return output is not None and output.inputs["Volume"].is_linked and not output.inputs["Surface"].is_linked
