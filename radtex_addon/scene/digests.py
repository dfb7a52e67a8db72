# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Digests of what a scene renders, in named parts, and which of the parts count for each who asks.

An unfinished bake asks whether the scene is still the one that its pieces are of, a finished one whether
something that it shows has changed since, a farm whether a copy looks the same, and at each frame.

| part | unfinished bake: `scene_digests` | finished: `read_scene` | farm: `looks_of` |
|---|---|---|---|
| objects | all but cameras | what renders | all but cameras and empties |
| names | yes | no: people rename things | yes: messages name objects |
| random numbers | by the names | where materials show them | yes |
| places | yes | yes | yes, but for the sign of zero |
| geometry | yes | yes, and which layers are active | yes, whatever makes it |
| what rays see | yes | yes | no: it is copied |
| materials, lamps, world | as the file has them | as animated at the frame | no: they are held |
| light paths, colour space | yes | yes | no: they are the capture's |
| frame | its number | no | no |
| camera | no | its place, for bakes seen from it | no |

Digests are of values to the last bit, but for geometry that Blender rounds otherwise each time. Not noticed
are changes between the slices that are read of image and volume files beyond 64 MB, in later frames of image
sequences, and in caches of gas simulations.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias, cast

import bpy
import numpy as np

from ..core.arrays import Floats
from ..core.errors import InputError
from ..core.near_digest import NearDigest, joined
from ..formats.fingerprint import Fingerprint
from ..settings.spec import BakeSpec, View, fingerprint_texts
from .block_digests import block_settings, digest_of, setting
from .camera_place import place_of_camera
from .geometry_digests import Geometry
from .lights.lamps import WORLD, find_lamps
from .mesh.evaluated import render_with
from .mesh.painted_weights import weights_digest
from .render_settings import KEPT_OF_RENDER, LIGHT_PATHS
from .surfaces import is_own_mesh
from .working_space import working_space

Looks: TypeAlias = dict[str, NearDigest]  # a digest for each object, by its name

_SHOWN = sorted(KEPT_OF_RENDER - {"engine", "threads", "threads_mode"})
_LIGHT = sorted(LIGHT_PATHS | {"dicing_rate", "feature_set", "max_subdivisions", "shading_system"})
_CURVES = ("shape", "subdivisions")
_OBJECT = ("is_holdout", "is_shadow_catcher", "pass_index", "color", "instance_type", "hide_render")
_RAYS = ("camera", "diffuse", "glossy", "transmission", "volume_scatter", "shadow")
_RENDERED = frozenset(("CURVE", "CURVES", "FONT", "LIGHT", "MESH", "META", "POINTCLOUD", "SURFACE", "VOLUME"))
_RANDOM = "ShaderNodeObjectInfo"  # the node that shows an object's random number


def scene_digests(scratch: bpy.types.Scene) -> dict[str, str]:
    """Digests of all that an unfinished bake goes on with but its own meshes, by names for messages."""
    frame = scratch.frame_current + scratch.frame_subframe
    return {
        **render_with(scratch, _by_kinds),
        "world": digest_of(block_settings(scratch.world)),
        "light paths": _light_paths(scratch),
        "working colour space": working_space(),
        "frame": f"{frame:g}",
    }


def _by_kinds(depsgraph: bpy.types.Depsgraph) -> dict[str, str]:
    """Digests of objects (with their geometry), of lights and of materials."""
    objects: list[tuple[str, NearDigest]] = []
    lights: list[str] = []
    materials: dict[str, bpy.types.Material] = {}
    geometry = Geometry()
    for each in _shown(depsgraph):
        item = each.item
        if item.type == "CAMERA":  # the bake has cameras of its own
            continue
        said = f"{item.name_full} {each.kind_and_place()} {_object_settings(item)}"
        if item.type == "LIGHT":
            lights.append(" ".join((said, *block_settings(item.data))))
            continue
        objects.append((said, geometry.of(item)))
        materials |= {material.name_full: material for material in _materials_of(item)}
    return {
        "objects": str(_joined(objects)),
        "lights": digest_of(sorted(lights)),
        "materials": digest_of(
            text for name in sorted(materials) for text in (name, *block_settings(materials[name]))
        ),
    }


def _joined(objects: list[tuple[str, NearDigest]]) -> NearDigest:
    """One digest of what is said of each object, and of its geometry's, in no order."""
    objects = sorted(objects, key=lambda each: (each[0], each[1].of))
    exact = digest_of(sorted(f"{said} {shape.exact}" for said, shape in objects))
    return joined(exact, (shape for _, shape in objects), (said for said, _ in objects))


@dataclass(frozen=True)
class ObjectDigests:
    """Digests of one object, or an instance of one: its geometry, its matrix, and how it is shaded.

    `of` is the object's name, or for an instance that of the object that makes it; `kind` is its type.
    """

    of: str
    kind: str
    is_instance: bool
    mesh: NearDigest
    transform: str
    materials: str

    @property
    def whole(self) -> str:
        """All of it as text, without the name; of the geometry what is exact."""
        return f"{self.kind} {self.mesh.exact} {self.transform} {self.materials}"

    @property
    def but_mesh(self) -> str:
        """The same without the geometry."""
        return f"{self.kind} {self.transform} {self.materials}"


@dataclass(frozen=True, eq=False)
class SceneDigests:
    """Digests of all that a scene renders at a frame, for the fingerprints of its bakes.

    `rendering` is of how light travels, `camera` of the camera's place, empty without one.
    """

    objects: tuple[ObjectDigests, ...]
    world: str
    rendering: str
    camera: str

    @property
    def whole(self) -> str:
        """A digest of all that is rendered, whatever sees it."""
        objects = sorted(f"{each.of} {each.whole}" for each in self.objects)
        return digest_of((*objects, self.world, self.rendering))

    def of_bake(self, name: str, spec: BakeSpec, layer: bpy.types.ViewLayer) -> Fingerprint:
        """The fingerprint of a bake called `name`; lamps are those of the view layer.

        Raises InputError for objects and lamps that do not render.
        """
        baked = (*(spec.objects or (name,)), *(each for each in (spec.source, spec.cage) if each is not None))
        own = {each.of: each for each in self.objects if not each.is_instance and each.of in baked}
        found = [own[each] for each in baked if each in own]
        for each in baked:
            if each not in own and each != spec.cage:
                raise InputError(f"object '{each}' is hidden from render: nothing shows it there")
        others = [each for each in self.objects if each.is_instance or each.of not in own]
        if spec.alone:
            lamps = [each for each in others if each.kind == "LIGHT" and not each.is_instance]
            others = [*lamps, *(each for each in others if each.of in own)]
        painted = _painted(baked, spec, layer)
        exact = digest_of((*(each.mesh.exact for each in found), *painted))
        return Fingerprint(
            mesh=str(joined(exact, (each.mesh for each in found), painted)),
            transform=digest_of(each.transform for each in found),
            materials=digest_of(each.materials for each in found),
            settings=digest_of((*fingerprint_texts(spec), self.rendering)),
            surroundings=str(self._surroundings(others, spec, layer)),
        )

    def _surroundings(
        self, others: Sequence[ObjectDigests], spec: BakeSpec, layer: bpy.types.ViewLayer
    ) -> NearDigest:
        """Digest of the other objects, and of the light that the bake is lit by."""
        lit = None if not spec.lights else {lamp.name for lamp in find_lamps(layer, spec.lights)}
        world = self.world if lit is None or WORLD in spec.lights else ""
        seen = [each for each in others if each.kind != "LIGHT" or _is_lit(each, lit, spec.lights)]
        camera = self.camera if spec.view is View.CAMERA else ""
        exact = digest_of((*sorted(each.whole for each in seen), world, camera))
        seen.sort(key=lambda each: (each.but_mesh, each.mesh.of or each.mesh.exact))
        beside = (*(each.but_mesh for each in seen), world, camera)
        return joined(exact, (each.mesh for each in seen), beside)


def _painted(baked: Sequence[str], spec: BakeSpec, layer: bpy.types.ViewLayer) -> list[str]:
    """Digests of the texel weights of the baked objects; none if the specification names no group."""
    if spec.texel_weights is None:
        return []
    items = [layer.objects[name] for name in baked if name in layer.objects]
    return [weights_digest(item, spec.texel_weights) for item in items]


def read_scene(scratch: bpy.types.Scene) -> SceneDigests:
    """Digest all that a render of the scratch scene shows, for fingerprints. Changes nothing."""
    camera = scratch.camera  # the render that evaluates the scene has another
    return render_with(scratch, lambda depsgraph: _read(depsgraph, scratch, camera))


def _read(
    depsgraph: bpy.types.Depsgraph, scratch: bpy.types.Scene, camera: bpy.types.Object | None
) -> SceneDigests:
    shading, geometry = _Shading(depsgraph), Geometry()
    objects = []
    for each in _shown(depsgraph):
        item = each.item
        if item.type not in _RENDERED or not each.itself:
            continue
        looks, random = shading.of(item)
        objects.append(
            ObjectDigests(
                of=each.maker,
                kind=item.type,
                is_instance=each.is_instance,
                mesh=_with_layers(geometry.of(item), _active_layers(item.data)),
                transform=_bits(each.matrix),
                materials=digest_of((looks, _object_settings(item), str(each.random) if random else "")),
            )
        )
    evaluated = cast("bpy.types.Scene", depsgraph.scene_eval)
    return SceneDigests(
        objects=tuple(objects),
        world=digest_of(block_settings(evaluated.world)),
        rendering=f"{_light_paths(scratch)} {working_space()}",
        camera=_place_of(camera, depsgraph),
    )


class _Shading:
    """Digests of objects' materials, or of lamps' settings; a material that several share is read once."""

    def __init__(self, depsgraph: bpy.types.Depsgraph) -> None:
        self._depsgraph = depsgraph
        self._known: dict[str, tuple[str, bool]] = {}

    def of(self, item: bpy.types.Object) -> tuple[str, bool]:
        """The digest, and whether the object's random number is shown."""
        if item.type == "LIGHT":
            return self._block(cast("bpy.types.ID", item.data))
        found = [self._block(each) for each in _materials_of(item)]
        return " ".join(digest for digest, _ in found), any(random for _, random in found)

    def _block(self, block: bpy.types.ID) -> tuple[str, bool]:
        original = cast("bpy.types.ID", block.original)
        key = f"{type(original).__name__} {original.name_full}"
        if key not in self._known:
            texts = list(block_settings(cast("bpy.types.ID", original.evaluated_get(self._depsgraph))))
            self._known[key] = digest_of(texts), _RANDOM in texts
        return self._known[key]


def _active_layers(data: Any) -> str:
    """The UV layers and the colours that a mesh's bake and materials take where they name none."""
    if not isinstance(data, bpy.types.Mesh):
        return ""
    layers, colours = data.uv_layers, data.color_attributes
    rendered = next((layer.name for layer in layers if layer.active_render), "")
    return repr((layers.active.name if layers.active else "", rendered, colours.default_color_name))


def _with_layers(shape: NearDigest, layers: str) -> NearDigest:
    of = f"{shape.of}-{layers}" if shape.of else ""
    return replace(shape, exact=f"{shape.exact} {layers}", of=of)


def _place_of(camera: bpy.types.Object | None, depsgraph: bpy.types.Depsgraph) -> str:
    if camera is None or camera.type != "CAMERA":
        return ""
    return repr(place_of_camera(cast("bpy.types.Object", camera.evaluated_get(depsgraph))))


def _is_lit(lamp: ObjectDigests, lit: Collection[str] | None, lights: Sequence[str]) -> bool:
    """Whether a bake is lit by a lamp: by any if `lit` is None; instances of lamps are of WORLD."""
    if lit is None:
        return True
    return WORLD in lights if lamp.is_instance else lamp.of in lit


def looks_of(scene: bpy.types.Scene) -> Looks:
    """What each object of a scene's render looks like, with its instances: surfaces and their places.

    They are compared within a process, and not stored.
    """
    return render_with(scene, _looks)


def _looks(depsgraph: bpy.types.Depsgraph) -> Looks:
    found: dict[str, list[tuple[str, NearDigest]]] = {}
    geometry = Geometry(by_outcome=True)
    for each in _shown(depsgraph):
        if each.item.type in {"CAMERA", "EMPTY"}:
            continue
        unsigned = replace(each, matrix=each.matrix + np.float32(0))  # no zero is negative
        said = f"{each.item.name} {each.random} {unsigned.kind_and_place()}"
        found.setdefault(each.maker, []).append((said, geometry.of(each.item)))
    return {name: _joined(shown) for name, shown in found.items()}


def differing(one: Looks, other: Looks) -> list[str]:
    """Names of objects whose digests differ, or that are in one of the two only; sorted."""
    none = NearDigest("")
    return sorted(
        name for name in one.keys() | other.keys() if not one.get(name, none).is_like(other.get(name, none))
    )


@dataclass(frozen=True, eq=False)
class _Shown:
    """An object that a depsgraph shows, or an instance of one; the next one makes it invalid.

    `maker` is its own name, or for an instance that of the object that makes it; `itself` is False for an
    object of which only its instances are seen; `matrix` (4, 4) float32 is from object to world.
    """

    item: bpy.types.Object
    maker: str
    is_instance: bool
    itself: bool
    matrix: Floats
    random: int

    def kind_and_place(self) -> str:
        return f"{self.item.type} {self.is_instance} {_bits(self.matrix)}"


def _shown(depsgraph: bpy.types.Depsgraph) -> Iterator[_Shown]:
    for instance in depsgraph.object_instances:
        if is_own_mesh(instance):  # its object tells of it
            continue
        item = instance.object
        assert item is not None  # every instance has an object
        maker = instance.parent if instance.is_instance and instance.parent is not None else item
        matrix = np.array(instance.matrix_world, dtype=np.float32)
        itself = instance.is_instance or instance.show_self
        yield _Shown(item, maker.original.name, instance.is_instance, itself, matrix, instance.random_id)


def _bits(matrix: Floats) -> str:
    return matrix.tobytes().hex()


def _light_paths(scratch: bpy.types.Scene) -> str:
    """Digest of the scratch scene's settings of how light travels and what renders show."""
    cycles, render, curves = cast(Any, scratch).cycles, scratch.render, cast(Any, scratch).cycles_curves
    return digest_of(
        f"{name} {getattr(of, name, None)!r}"
        for of, names in ((cycles, _LIGHT), (render, _SHOWN), (curves, _CURVES))
        for name in names
    )


def _object_settings(item: bpy.types.Object) -> str:
    """What rays see of an object, its empty material slots, and settings that shaders know, as text."""
    rays = [getattr(item, f"visible_{ray}") for ray in _RAYS]
    settings = [repr(setting(getattr(item, name))) for name in _OBJECT]
    empty = [slot.material is None for slot in item.material_slots]  # `_materials_of` leaves these out
    return f"{rays} {settings} {empty}"


def _materials_of(item: bpy.types.Object) -> Iterator[bpy.types.Material]:
    """The original materials of an evaluated object, including those that its modifiers set."""
    slots = (slot.material for slot in item.material_slots)
    for material in (*slots, *getattr(item.data, "materials", ())):
        if material is not None:
            yield cast("bpy.types.Material", material.original)
