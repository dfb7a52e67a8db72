# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene renders, as digests by objects, and from these the fingerprint of a bake.

The scene is evaluated once for all its bakes. Digests are of values to the last bit, but for what Blender
rounds otherwise each time, and of animated and driven values as they are at the frame. They do not depend on
the names of data-blocks, except where a material shows an object's random number, which Blender makes of its
name.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import bpy
import numpy as np

from ..bake.spec import BakeSpec, View
from ..bake.spec_facts import fingerprint_texts
from ..core.errors import InputError
from ..core.near_digest import NearDigest, joined
from ..formats.fingerprint import Fingerprint
from .block_digests import block_settings, digest_of
from .camera_place import place_of_camera
from .digests import light_paths_digest, materials_of, object_settings
from .geometry_digests import Geometry
from .lights.lamps import WORLD, find_lamps
from .mesh.evaluated import render_with
from .working_space import working_space

_RENDERED = frozenset(("CURVE", "CURVES", "FONT", "LIGHT", "MESH", "META", "POINTCLOUD", "SURFACE", "VOLUME"))
_RANDOM = "ShaderNodeObjectInfo"  # the node that shows an object's random number


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
    """Digests of all that a scene renders at a frame.

    `rendering` is of how light travels, `camera` of the camera's place, empty without one.
    """

    objects: tuple[ObjectDigests, ...]
    world: str
    rendering: str
    camera: str

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
        return Fingerprint(
            mesh=str(joined(digest_of(each.mesh.exact for each in found), (each.mesh for each in found))),
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


def read_scene(scratch: bpy.types.Scene) -> SceneDigests:
    """Digest all that a render of the scratch scene shows. Changes nothing."""
    found: list[SceneDigests] = []
    camera = scratch.camera  # the render that evaluates the scene has another
    render_with(scratch, lambda depsgraph: found.append(_read(depsgraph, scratch, camera)))
    return found[0]


def _read(
    depsgraph: bpy.types.Depsgraph, scratch: bpy.types.Scene, camera: bpy.types.Object | None
) -> SceneDigests:
    shading = _Shading(depsgraph)
    geometry = Geometry()
    objects = []
    for instance in depsgraph.object_instances:
        item = instance.object
        assert item is not None  # every instance has an object
        if item.type in _RENDERED and (instance.is_instance or instance.show_self):
            objects.append(_of_instance(instance, item, geometry, shading))
    evaluated = cast("bpy.types.Scene", depsgraph.scene_eval)
    return SceneDigests(
        objects=tuple(objects),
        world=digest_of(block_settings(evaluated.world)),
        rendering=f"{light_paths_digest(scratch)} {working_space()}",
        camera=_place_of(camera, depsgraph),
    )


def _of_instance(
    instance: bpy.types.DepsgraphObjectInstance,
    item: bpy.types.Object,
    geometry: Geometry,
    shading: _Shading,
) -> ObjectDigests:
    maker = instance.parent if instance.is_instance and instance.parent is not None else item
    shown, random = shading.of(item)
    texts = (shown, object_settings(item), str(instance.random_id) if random else "")
    return ObjectDigests(
        of=maker.original.name,
        kind=item.type,
        is_instance=instance.is_instance,
        mesh=_with_layers(geometry.of(item), _active_layers(item.data)),
        transform=np.array(instance.matrix_world, dtype=np.float32).tobytes().hex(),
        materials=digest_of(texts),
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
        found = [self._block(each) for each in materials_of(item)]
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
