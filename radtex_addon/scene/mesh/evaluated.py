# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh that Cycles renders, as arrays: modifiers at render level, constraints, parents, normals and all.

Blender shows the scene as renders evaluate it to render engines only. So a private engine is registered for a
moment: it renders nothing and reads the mesh.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, TypeVar, cast

import bpy
import numpy as np
import numpy.typing as npt

from ...core.arrays import Bools, Floats, Ints, blocks
from ...core.errors import BakeError, InputError
from ...core.frame import normalised
from ...core.messages import Message
from ..checks.file_checks import failed_drivers
from ..checks.refusals import refuse_adaptive_subdivision, refuse_displacement
from ..geometry_digests import drifts, made_of
from ..scratch import render_scene
from ..surfaces import is_own_mesh
from .attribute_arrays import ATTRIBUTE_LAYOUT
from .mesh_checks import FARTHEST, check_area, check_extent, check_matrix, check_positions, no_faces
from .painted_weights import WEIGHT, read_weights

log = logging.getLogger(__name__)

_Read = TypeVar("_Read")

_ENGINE = "RADTEX_EVALUATE"
_TINY = {  # settings of the private engine's render, whose picture is not used
    "engine": _ENGINE,
    "resolution_x": 4,
    "resolution_y": 4,
    "resolution_percentage": 100,
    "use_border": False,
}
_OWN = frozenset({"position", "custom_normal"})  # attributes that are fields of EvaluatedMesh


@dataclass(frozen=True, eq=False)
class MeshAttribute:
    """A named attribute on POINT (V, k), CORNER (F, 3, k) or FACE (F, k) of the triangulated mesh."""

    name: str
    domain: str
    data_type: str
    values: npt.NDArray[Any]


@dataclass(frozen=True, eq=False)
class EvaluatedMesh:
    """V vertices and F triangles in object space, as Cycles renders them.

    `position` (V, 3) and `normal` (F, 3, 3), the shading normals at the corners, float32; `triangles`
    (F, 3) vertex indices; `material_index` (F,) into `materials`; `matrix_world` (4, 4) float64 from
    object to world, never singular. `flat` is True if all faces are shaded flat; `instances` is the
    number of instances that modifiers or the object itself make in addition to the mesh. `made_of` is a
    digest of what Blender makes the mesh of, empty where it is the object's own; if it `drifts`, vertices may
    be rounded otherwise the next time.
    """

    name: str
    position: Floats
    triangles: Ints
    normal: Floats
    flat: bool
    attributes: tuple[MeshAttribute, ...]
    materials: tuple[bpy.types.Material | None, ...]
    material_index: Ints
    matrix_world: Floats
    active_uv: str | None
    active_color: str | None
    render_color: str | None
    texture_space: tuple[Floats, Floats]
    instances: int
    made_of: str = ""
    drifts: bool = False

    @property
    def mirrored(self) -> bool:
        """True if the object's matrix mirrors: its determinant is negative."""
        return float(np.linalg.det(self.matrix_world[:3, :3])) < 0

    @property
    def world_position(self) -> Floats:
        """Vertices in world space, (V, 3) float64."""
        matrix = self.matrix_world
        world: Floats = self.position.astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]
        return world

    @property
    def world_normal(self) -> Floats:
        """Unit corner normals in world space (by the inverse transpose), (F, 3, 3) float64."""
        turn = np.linalg.inv(self.matrix_world[:3, :3])
        world = np.empty(self.normal.shape)
        for some in blocks(len(world)):
            world[some] = normalised(self.normal[some].astype(np.float64) @ turn)
        return world

    @property
    def uv_layers(self) -> tuple[str, ...]:
        """Names of the UV layers, in the mesh's order."""
        return tuple(a.name for a in self.attributes if a.data_type == "FLOAT2" and a.domain == "CORNER")

    def uv(self, layer: str) -> Floats:
        """A UV layer's coordinates, (F, 3, 2) float32. Raises KeyError if there is no such layer."""
        for attribute in self.attributes:
            if attribute.name == layer and layer in self.uv_layers:
                return attribute.values
        raise KeyError(layer)


def evaluate(
    scratch: bpy.types.Scene, original: bpy.types.Object, weights: str | None = None
) -> EvaluatedMesh:
    """Read the mesh of `original` as a render of the scratch scene's enabled view layer shows it.

    With the vertex group called `weights`, if it has one, as the attribute WEIGHT of its vertices.

    Raises InputError where there is nothing to bake (no faces, not rendered, coordinates that are not finite,
    no extent along an axis, too small, too large or too far away) or Cycles would move the surface
    (displacement, adaptive subdivision).
    """

    def read(depsgraph: bpy.types.Depsgraph) -> EvaluatedMesh:
        rendered, instances = find_rendered(depsgraph, original)
        for complaint in failed_drivers(depsgraph.ids):
            log.warning(complaint)
        return _read_checked(depsgraph, original, rendered, instances, weights)

    mesh = render_with(scratch, read)
    _check(mesh)
    return mesh


def why_not_evaluated(
    scratch: bpy.types.Scene, originals: Collection[bpy.types.Object]
) -> dict[bpy.types.Object, Message]:
    """Those of the `originals` for which `evaluate` would raise InputError, or that have no area; and why.

    The scene is evaluated once for all of them.
    """
    found: dict[bpy.types.Object, Message] = {}

    def read(depsgraph: bpy.types.Depsgraph) -> None:
        seen = _rendered_among(depsgraph, set(originals))
        for original in originals:
            try:
                mesh = _read_checked(depsgraph, original, *seen.get(original, (None, 0)))
                _check(mesh, warns=False)  # the bake will
                check_area(mesh.name, mesh.world_position, mesh.triangles)
            except InputError as error:
                found[original] = error.message

    render_with(scratch, read)
    return found


def _read_checked(
    depsgraph: bpy.types.Depsgraph,
    original: bpy.types.Object,
    rendered: bpy.types.Object | None,
    instances: int,
    weights: str | None = None,
) -> EvaluatedMesh:
    if rendered is None:
        raise InputError(f"object '{original.name}' is hidden from render: nothing shows it there")
    refuse_adaptive_subdivision(rendered, depsgraph.scene)
    return _read_object(original.name, rendered, instances, weights)


def _check(mesh: EvaluatedMesh, *, warns: bool = True) -> None:
    shown = [mesh.materials[index] for index in np.unique(mesh.material_index) if mesh.materials]
    refuse_displacement(mesh.name, shown)
    if not (np.abs(mesh.normal) < FARTHEST).all():
        raise InputError(f"object '{mesh.name}' has normals that are not finite: clear its custom normals")
    if mesh.instances and warns:
        log.warning(
            "'%s' shows %d instances, which are not baked with it: join them, or make them real",
            mesh.name,
            mesh.instances,
        )
    check_matrix(mesh.name, mesh.matrix_world)
    check_extent(mesh.name, mesh.world_position, warns=warns)


def _rendered_among(
    depsgraph: bpy.types.Depsgraph, originals: Collection[bpy.types.Object]
) -> dict[bpy.types.Object, tuple[bpy.types.Object | None, int]]:
    """For each of the objects that shows anything, what `find_rendered` tells of it."""
    shown: set[bpy.types.Object] = set()
    instances: dict[bpy.types.Object, int] = {}
    for item in depsgraph.object_instances:
        if is_own_mesh(item):
            continue
        of = item.parent if item.is_instance else item.object
        original = cast("bpy.types.Object | None", of.original if of is not None else None)
        if original not in originals or original is None:
            continue
        if item.is_instance:
            instances[original] = instances.get(original, 0) + 1
        elif item.show_self:
            shown.add(original)
    evaluated = {original: original.evaluated_get(depsgraph) for original in shown}
    every = shown | instances.keys()
    return {original: (evaluated.get(original), instances.get(original, 0)) for original in every}


def find_rendered(
    depsgraph: bpy.types.Depsgraph, original: bpy.types.Object
) -> tuple[bpy.types.Object | None, int]:
    """The evaluated object, None if it is hidden from render, and the number of instances that it makes."""
    evaluated: bpy.types.Object | None = None
    instances = 0
    for item in depsgraph.object_instances:
        if is_own_mesh(item):
            continue
        if item.is_instance:
            instances += item.parent is not None and item.parent.original == original
        elif item.object.original == original and item.show_self:
            evaluated = original.evaluated_get(depsgraph)
    return evaluated, instances


def render_with(scratch: bpy.types.Scene, read: Callable[[bpy.types.Depsgraph], _Read]) -> _Read:
    """What `read` returns of the depsgraph of a render of the scratch scene. Raises what `read` raises."""
    found: list[_Read] = []
    failures: list[Exception] = []

    class Reader(bpy.types.RenderEngine):
        bl_idname = _ENGINE
        bl_label = "RadTex Evaluate"

        def render(self, depsgraph: Any) -> None:  # type: ignore[override]  # the stubs declare other arguments
            try:
                found.append(read(depsgraph))
            except Exception as error:  # noqa: BLE001 (Blender would print it and go on)
                failures.append(error)

    with _registered(Reader), _tiny(scratch):
        result = render_scene(scratch)
    if failures:
        raise failures[0]
    if result != {"FINISHED"}:
        raise BakeError(f"Blender did not evaluate scene '{scratch.name}' for rendering: {sorted(result)}")
    return found[0]


@contextmanager
def _registered(engine: type[bpy.types.RenderEngine]) -> Iterator[None]:
    bpy.utils.register_class(engine)
    try:
        yield
    finally:
        bpy.utils.unregister_class(engine)


@contextmanager
def _tiny(scratch: bpy.types.Scene) -> Iterator[None]:
    """Let the scratch scene render with our engine, at a tiny size; restore its settings at exit."""
    render, camera = cast("Any", scratch.render), scratch.camera
    before = {name: getattr(render, name) for name in _TINY}
    lens = bpy.data.cameras.new("RadTex camera")
    stand_in = bpy.data.objects.new("RadTex camera", lens)
    try:
        scratch.collection.objects.link(stand_in)
        scratch.camera = stand_in  # Blender renders nothing without a camera
        for name, value in _TINY.items():
            setattr(render, name, value)
        yield
    finally:
        for name, value in before.items():
            setattr(render, name, value)
        scratch.camera = camera
        bpy.data.cameras.remove(lens)  # and the object with it


def read_shown(rendered: Any) -> EvaluatedMesh | None:
    """The mesh of what a render's depsgraph shows, maybe an instance, at its own place; None without faces.

    Its `active_uv` is the layer that renders take where none is named. Raises InputError for coordinates that
    are not finite.
    """
    mesh = cast(Any, rendered.to_mesh())
    try:
        if len(mesh.polygons) == 0:
            return None
        found = _read_mesh(rendered.name, mesh, rendered, 0, None)
        shown = (None if one is None else one.original for one in materials_shown(rendered, mesh))
        uv = next((layer.name for layer in mesh.uv_layers if layer.active_render), None)
        return replace(found, materials=tuple(cast("Any", shown)), active_uv=uv)
    finally:
        rendered.to_mesh_clear()


def materials_shown(item: Any, mesh: Any) -> list[bpy.types.Material | None]:
    """The materials of an evaluated object's mesh; the object may have others in their place.

    Geometry nodes instance bare meshes: there the slots are of the object that has the nodes.
    """
    materials = list(mesh.materials)
    for place, slot in enumerate(item.material_slots[: len(materials)]):
        if slot.link == "OBJECT":
            materials[place] = slot.material
    return materials


def _read_object(name: str, rendered: bpy.types.Object, instances: int, weights: str | None) -> EvaluatedMesh:
    mesh = cast("bpy.types.Mesh", rendered.to_mesh())
    try:
        return _read_mesh(name, mesh, rendered, instances, weights)
    finally:
        rendered.to_mesh_clear()


def _read_mesh(
    name: str, mesh: bpy.types.Mesh, rendered: bpy.types.Object, instances: int, weights: str | None
) -> EvaluatedMesh:
    if len(mesh.polygons) == 0:
        raise no_faces(name, instances)
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    vertices = _bulk(mesh.loop_triangles, "vertices", count, 3, np.int32)
    corners = _bulk(mesh.loop_triangles, "loops", count, 3, np.int32)
    faces = _bulk(mesh.loop_triangles, "polygon_index", count, 1, np.int32)[:, 0]
    used, triangles = _used(vertices, len(mesh.vertices))
    positions = _bulk(mesh.vertices, "co", len(mesh.vertices), 3, np.float32)
    check_positions(name, positions[used])
    take = {"POINT": used, "CORNER": corners, "FACE": faces}
    materials = tuple(slot.material.original if slot.material else None for slot in rendered.material_slots)
    index = _bulk(mesh.polygons, "material_index", len(mesh.polygons), 1, np.int32)[faces, 0]
    return EvaluatedMesh(
        name=name,
        position=positions[used],
        triangles=triangles,
        normal=_cycles_normals(mesh, positions, vertices, corners, faces),
        flat=mesh.normals_domain == "FACE",
        attributes=(*_attributes(mesh, take), *_painted(rendered, mesh, used, weights)),
        materials=materials,
        material_index=np.clip(index, 0, max(len(materials) - 1, 0)),
        matrix_world=np.array(rendered.matrix_world, dtype=np.float64),
        active_uv=mesh.uv_layers.active.name if mesh.uv_layers.active else None,
        active_color=mesh.color_attributes.active_color_name or None,
        render_color=mesh.color_attributes.default_color_name or None,
        texture_space=(np.array(mesh.texspace_location), np.array(mesh.texspace_size)),
        instances=instances,
        made_of=made_of(rendered),
        drifts=drifts(rendered),
    )


def _used(vertices: Ints, count: int) -> tuple[Ints, Ints]:
    """Which of `count` vertices are in `vertices` (F, 3), and the triangles (F, 3) int32 of these alone."""
    there = np.zeros(count, dtype=bool)
    there[vertices] = True
    return np.flatnonzero(there), (np.cumsum(there, dtype=np.int32) - np.int32(1))[vertices]


def _bulk(collection: Any, name: str, count: int, width: int, dtype: type[np.generic]) -> npt.NDArray[Any]:
    values = np.empty(count * width, dtype=dtype)
    collection.foreach_get(name, values)
    return values.reshape(count, width)


def _attributes(mesh: Any, take: dict[str, Ints]) -> Iterator[MeshAttribute]:
    for layer in mesh.attributes:
        if layer.name.startswith(".") or layer.name in _OWN or layer.domain not in take:
            continue
        if layer.data_type not in ATTRIBUTE_LAYOUT:
            continue
        name, width, dtype = ATTRIBUTE_LAYOUT[layer.data_type]
        values = _bulk(layer.data, name, len(layer.data), width, dtype)
        yield MeshAttribute(layer.name, layer.domain, layer.data_type, values[take[layer.domain]])


def _painted(rendered: bpy.types.Object, mesh: Any, used: Ints, weights: str | None) -> list[MeshAttribute]:
    """The attribute WEIGHT of the `used` vertices, if the mesh has the vertex group called `weights`."""
    found = None if weights is None else read_weights(rendered, mesh, weights)
    return [] if found is None else [MeshAttribute(WEIGHT, "POINT", "FLOAT", found[used])]


def _cycles_normals(
    mesh: bpy.types.Mesh, positions: Floats, vertices: Ints, corners: Ints, faces: Ints
) -> Floats:
    """Shading normals as Cycles computes them (intern/cycles/blender/mesh.cpp), not always `corner_normals`.

    Flat faces get the normals of their triangles, not of the polygon. In Blender 4.5, smooth faces next to
    flat ones keep their vertex normals.
    """
    split = _bulk(mesh.corner_normals, "vector", len(mesh.loops), 3, np.float32)[corners]
    if mesh.normals_domain == "FACE":
        return _facets(positions, vertices, split)
    if bpy.app.version >= (5, 0, 0) or mesh.has_custom_normals or _any_sharp_edge(mesh):
        return split
    smooth = _bulk(mesh.vertex_normals, "vector", len(mesh.vertices), 3, np.float32)[vertices]
    sharp = _sharp_faces(mesh)[faces]
    smooth[sharp] = _facets(positions, vertices[sharp], split[sharp])
    return smooth


def _facets(positions: Floats, vertices: Ints, split: Floats) -> Floats:
    """Normals of triangles at their corners, (F, 3, 3) float32; `split` (F, 3, 3) of those without area."""
    found = np.empty((len(vertices), 3, 3), dtype=np.float32)
    for some in blocks(len(vertices)):
        a, b, c = (positions[vertices[some, k]].astype(np.float64) for k in range(3))
        found[some] = normalised(np.cross(b - a, c - a))[:, None]
    degenerate = ~found.any(axis=(1, 2))
    found[degenerate] = split[degenerate]
    return found


def _any_sharp_edge(mesh: bpy.types.Mesh) -> bool:
    return bool(_bulk(mesh.edges, "use_edge_sharp", len(mesh.edges), 1, np.bool_).any())


def _sharp_faces(mesh: bpy.types.Mesh) -> Bools:
    return ~_bulk(mesh.polygons, "use_smooth", len(mesh.polygons), 1, np.bool_)[:, 0]
