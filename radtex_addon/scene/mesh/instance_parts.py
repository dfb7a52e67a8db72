# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What an object shows as instances, of a collection or of geometry nodes, as meshes that can be baked.

A bake needs a UV map of its own for each thing, and an instance has none: all of one owner become one mesh.
Blender's Realize Instances turns mirrored ones inside out, and loses materials that objects have in the place
of their mesh's; so the meshes are read as they render, and joined here.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, cast

import bpy
import numpy as np
import numpy.typing as npt

from ...core.arrays import Floats, Ints
from ...core.errors import InputError
from ...core.frame import normalised
from ...core.near_digest import hash_of
from ..checks.own_coordinates import reads_instancer, reads_its_place
from ..checks.refusals import refuse_adaptive_subdivision
from .evaluated import EvaluatedMesh, MeshAttribute, read_shown, render_with
from .render_contents import RAYS, Shown, shown_in

MOST_PARTS, MOST_TRIANGLES = 20_000, 4_000_000  # of an owner
_MOST_APART = 64  # meshes of an owner
_NONE = frozenset(  # types of which renders show nothing, or the mesh that is listed beside them
    (
        *("ARMATURE", "CAMERA", "CURVE", "EMPTY", "FONT", "GREASEPENCIL"),
        *("LATTICE", "LIGHT_PROBE", "META", "SPEAKER", "SURFACE"),
    )
)
_CALLED = {"CURVES": "hair", "POINTCLOUD": "points", "VOLUME": "a volume"}
_MAKING = ("CollectionInfo", "Import", "Instance", "ObjectInfo", "StringToCurves")  # in names of nodes
_INDEX = "material_index"


@dataclass(frozen=True, eq=False)
class Lamp:
    """A lamp that an owner instances: its object, where (4, 4) it is, and the kinds of RAYS that see it."""

    original: bpy.types.Object
    matrix: Floats
    seen_by: frozenset[str]


@dataclass(frozen=True, eq=False)
class Part:
    """A mesh that an owner shows, in the space of `mesh.matrix_world`, and the kinds of RAYS that see it.

    Of its `original`, which it is read of, light linking and what materials read of an object are kept.
    """

    mesh: EvaluatedMesh
    seen_by: frozenset[str]
    original: bpy.types.Object

    @property
    def materials(self) -> list[bpy.types.Material]:
        """Those that its faces have."""
        used = np.unique(self.mesh.material_index) if self.mesh.materials else ()
        found = (self.mesh.materials[index] for index in used)
        return [material for material in found if material is not None]

    @property
    def linking(self) -> tuple[bpy.types.Collection | None, bpy.types.Collection | None]:
        """The collections of light linking that its original has of its own."""
        linking: Any = self.original.light_linking
        return linking.receiver_collection, linking.blocker_collection

    @property
    def has_modifiers(self) -> bool:
        """Whether its mesh is not the one that generated coordinates are of."""
        item: Any = self.original
        return any(modifier.show_render for modifier in item.modifiers) or bool(
            getattr(item.data, "shape_keys", None)
        )


@dataclass(eq=False)
class Owned:
    """What one owner shows: its `parts` and `lamps`; `why_not` says why these cannot be meshes, if so."""

    owner: bpy.types.Object
    matrix: Floats
    parts: list[Part] = field(default_factory=list)
    lamps: list[Lamp] = field(default_factory=list)
    instances: int = 0
    triangles: int = 0
    why_not: str = ""


def shows_instances(item: bpy.types.Object) -> bool:
    """Whether an object may show instances by itself: of a collection, or by geometry nodes."""
    if item.type == "EMPTY":
        return item.instance_type == "COLLECTION" and item.instance_collection is not None
    trees = (
        modifier.node_group
        for modifier in cast("list[Any]", item.modifiers)
        if modifier.type == "NODES" and modifier.show_render
    )
    return any(_makes_instances(tree, set()) for tree in trees)


def _makes_instances(tree: Any, known: set[Any]) -> bool:
    if tree is None or tree in known:
        return False
    known.add(tree)
    makes = any(name in node.bl_idname for node in tree.nodes for name in _MAKING)
    return makes or any(_makes_instances(getattr(node, "node_tree", None), known) for node in tree.nodes)


def read_owned(scratch: bpy.types.Scene, owners: Collection[bpy.types.Object]) -> list[Owned]:
    """What those of the owners that have instances show in a render of a scratch scene, in their order.

    Raises BakeError where Blender does not render.
    """

    def read(graph: bpy.types.Depsgraph) -> dict[bpy.types.Object, Owned]:
        found: dict[bpy.types.Object, Owned] = {}
        meshes: dict[tuple[int, int], EvaluatedMesh | None] = {}
        for one in shown_in(graph):
            if one.owner in owners:
                if one.owner not in found:
                    matrix = np.array(one.owner.evaluated_get(graph).matrix_world, dtype=np.float64)
                    found[one.owner] = Owned(one.owner, matrix)
                _take(found[one.owner], one, graph.scene, meshes)
        return found

    known = render_with(scratch, read)
    found = [known[owner] for owner in owners if owner in known and known[owner].instances]
    for owned in found:
        if not (np.isfinite(owned.matrix).all() and abs(np.linalg.det(owned.matrix)) > 0):
            owned.why_not = "its scale is 0, or its place is not finite"
    return found


def _take(owned: Owned, one: Shown, scene: Any, meshes: dict[tuple[int, int], EvaluatedMesh | None]) -> None:
    """Add a thing that its owner shows."""
    item = one.evaluated
    if item.type in _NONE:
        return
    owned.instances += one.is_instance
    if owned.why_not:
        return
    if item.type == "LIGHT":
        owned.lamps.append(Lamp(one.original, one.matrix, one.seen_by))
    elif item.type != "MESH":
        owned.why_not = f"it shows {_CALLED.get(item.type, item.type.lower())}, '{one.original.name}'"
    elif one.of_particles:
        owned.why_not = "its particles are instances"
    elif item.is_holdout or item.is_shadow_catcher:
        owned.why_not = f"'{one.original.name}' is a holdout or catches shadows"
    elif any(system.settings.render_type == "PATH" for system in item.particle_systems):
        owned.why_not = f"'{one.original.name}' has hair"
    else:
        _take_mesh(owned, one, scene, meshes)


def _take_mesh(
    owned: Owned, one: Shown, scene: Any, meshes: dict[tuple[int, int], EvaluatedMesh | None]
) -> None:
    key = one.original.session_uid, one.evaluated.data.as_pointer()
    if key not in meshes:
        try:
            refuse_adaptive_subdivision(one.evaluated, scene)
            meshes[key] = read_shown(one.evaluated)
        except InputError as error:
            owned.why_not = error.message.problem
            return
    mesh = meshes[key]
    if mesh is None or not np.isfinite(one.matrix).all() or not _cofactors(one.matrix).any():
        return  # nothing to see
    owned.parts.append(Part(replace(mesh, matrix_world=one.matrix), one.seen_by, one.original))
    owned.triangles += len(mesh.triangles)
    if len(owned.parts) > MOST_PARTS or owned.triangles > MOST_TRIANGLES:
        owned.why_not = f"it shows more than {MOST_PARTS:,} parts, or {MOST_TRIANGLES:,} triangles"


def joined_parts(owned: Owned) -> list[Part]:
    """The owner's parts as few meshes: of those that can be one, in the owner's space, then of the others.

    Parts that other rays see, that lamps light otherwise, that have another UV layer where materials name
    none, or whose attributes of one name differ in kind are apart, and so is each whose material reads its
    own place. Raises InputError where a part would look different, or where too many are apart.
    """
    reads = cache(reads_its_place)
    groups: list[_Group] = []
    for part in owned.parts:
        alone = any(map(reads, part.materials))
        group = None if alone else next((one for one in groups if one.takes(part)), None)
        if group is None:
            group = _Group(part, alone)
            groups.append(group)
        group.add(part)
        if len(groups) > _MOST_APART:
            raise InputError(f"more than {_MOST_APART} of its parts cannot be one mesh")
    for group in groups:
        if group.alone:
            _check_alone(group.first)
    groups.sort(key=lambda group: group.alone)
    return [replace(group.first, mesh=_joined(owned, group)) for group in groups]


def _check_alone(part: Part) -> None:
    name = part.original.name
    if any(map(reads_instancer, part.materials)):
        raise InputError(f"a material of '{name}' reads what its instancer tells")
    if part.has_modifiers:
        raise InputError(f"'{name}' has modifiers, and its material reads its object's own coordinates")


@dataclass(eq=False)
class _Group:
    """Parts that can be one mesh, as the `first`; one that stays `alone` has no others."""

    first: Part
    alone: bool
    parts: list[Part] = field(default_factory=list)
    kinds: dict[str, str] = field(default_factory=dict)

    def takes(self, part: Part) -> bool:
        first = self.first
        if self.alone or (part.seen_by, part.linking) != (first.seen_by, first.linking):
            return False
        return all(self.kinds.get(name, kind) == kind for name, kind in _kinds(part.mesh).items())

    def add(self, part: Part) -> None:
        self.parts.append(part)
        self.kinds |= _kinds(part.mesh)


def _kinds(mesh: EvaluatedMesh) -> dict[str, str]:
    """What must be alike of meshes that are joined, as far as they have it."""
    found = {one.name: f"{one.domain} {one.data_type}" for one in mesh.attributes if one.name != _INDEX}
    found["which UV map"] = mesh.active_uv or ""  # without, tangents are of generated coordinates
    if mesh.render_color is not None:
        found["which colours"] = mesh.render_color
    return found


def _joined(owned: Owned, group: _Group) -> EvaluatedMesh:
    """A group's parts as one mesh in the owner's space; one that stays alone in its own."""
    if group.alone:
        return group.parts[0].mesh
    meshes = [_in_space_of(owned.matrix, part.mesh) for part in group.parts]
    materials, numbers = _materials(meshes)
    first = np.cumsum([0, *(len(mesh.position) for mesh in meshes)])
    made = sorted({mesh.made_of for mesh in meshes} - {""})
    return replace(
        meshes[0],
        position=np.concatenate([mesh.position for mesh in meshes]),
        triangles=np.concatenate(
            [mesh.triangles + start for mesh, start in zip(meshes, first, strict=False)]
        ).astype(np.int32),
        normal=np.concatenate([mesh.normal for mesh in meshes]),
        flat=all(mesh.flat for mesh in meshes),
        attributes=tuple(_attributes(meshes, numbers)),
        materials=materials,
        material_index=numbers,
        matrix_world=owned.matrix,
        active_uv=_first(mesh.active_uv for mesh in meshes),
        active_color=_first(mesh.active_color for mesh in meshes),
        render_color=_first(mesh.render_color for mesh in meshes),
        made_of=hash_of(made) if made else "",
        drifts=any(mesh.drifts for mesh in meshes),
    )


def _first(names: Iterable[str | None]) -> str | None:
    return next((name for name in names if name is not None), None)


def _in_space_of(matrix: Floats, mesh: EvaluatedMesh) -> EvaluatedMesh:
    """The mesh as an object at `matrix` (4, 4) shows it; mirrored ones have their corners turned."""
    move = np.linalg.inv(matrix) @ mesh.matrix_world
    position = mesh.position.astype(np.float64) @ move[:3, :3].T + move[:3, 3]
    mirrors = bool(np.linalg.det(move[:3, :3]) < 0)
    normal = normalised(mesh.normal.astype(np.float64) @ _cofactors(move).T * (-1.0 if mirrors else 1.0))
    found = replace(
        mesh,
        position=position.astype(np.float32),
        normal=normal.astype(np.float32),
        matrix_world=matrix,
    )
    if not mirrors:
        return found
    return replace(
        found,
        triangles=found.triangles[:, ::-1],
        normal=found.normal[:, ::-1],
        attributes=tuple(map(_turned, found.attributes)),
    )


def _cofactors(matrix: Floats) -> Floats:
    """By which a matrix (4, 4) turns normals (3, 3), up to its determinant; 0 where it leaves no area."""
    x, y, z = matrix[:3, :3]
    found: Floats = np.array([np.cross(y, z), np.cross(z, x), np.cross(x, y)])
    return found


def _turned(attribute: MeshAttribute) -> MeshAttribute:
    turns = attribute.domain == "CORNER"
    return replace(attribute, values=attribute.values[:, ::-1]) if turns else attribute


def _materials(meshes: Sequence[EvaluatedMesh]) -> tuple[tuple[bpy.types.Material | None, ...], Ints]:
    """The materials that the meshes use, each once, and which one each triangle (F,) has."""
    found: dict[bpy.types.Material | None, int] = {}
    numbers = []
    for mesh in meshes:
        there = mesh.materials or (None,)
        places = np.array([found.setdefault(material, len(found)) for material in there], dtype=np.int32)
        numbers.append(places[np.minimum(mesh.material_index, len(there) - 1)])
    return tuple(found), np.concatenate(numbers)


def _attributes(meshes: Sequence[EvaluatedMesh], numbers: Ints) -> Iterable[MeshAttribute]:
    """The attributes of all meshes; where one lacks some, they are 0, as renders have it."""
    known = {one.name: one for mesh in meshes for one in mesh.attributes if one.name != _INDEX}
    for name, kind in known.items():
        values = []
        for mesh in meshes:
            own = next((one for one in mesh.attributes if one.name == name), None)
            values.append(_nothing(mesh, kind) if own is None else own.values)
        yield replace(kind, values=np.concatenate(values))
    yield MeshAttribute(_INDEX, "FACE", "INT", numbers[:, None])


def _nothing(mesh: EvaluatedMesh, kind: MeshAttribute) -> npt.NDArray[Any]:
    count = len(mesh.position) if kind.domain == "POINT" else len(mesh.triangles)
    found = np.zeros((count, *kind.values.shape[1:]), dtype=kind.values.dtype)
    if kind.data_type in {"FLOAT_COLOR", "BYTE_COLOR"}:
        found[..., 3] = 1
    return found


def set_visibility(item: bpy.types.Object, seen_by: frozenset[str]) -> None:
    """Let these kinds of RAYS alone see an object."""
    for ray in RAYS:
        setattr(cast(Any, item), f"visible_{ray}", ray in seen_by)
