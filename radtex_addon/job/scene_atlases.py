# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The atlases of a whole scene: which objects share one, what it is called, and how many texels it has.

Either all atlases have a texel density, or the scene has as many texels as its objects would have by
themselves, a dozen at most. Of these small things get more per area than large ones, and glossy ones more
than matt ones.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import count
from math import ceil, sqrt
from typing import Any

import bpy
import numpy as np

from ..core.arrays import Floats
from ..core.messages import Message
from ..forms.layered.capture.enclosed import is_clear
from ..scene.checks.see_through import Groups, materials_of, source_of, value_at
from ..scene.mesh.about_area import about_islands
from ..scene.mesh.scene_groups import SceneGroup, scene_groups
from ..scene.mesh.touching import Surface
from ..scene.scratch import find_view_layer
from ..scene.surfaces import may_have_faces
from ..scene.units import metres_per_unit
from ..settings.spec import BakeSpec, Unwrap
from ..settings.texel_density import (
    MOST_SHARED,
    about_side,
    capped_warning,
    density_of_side,
    side_for_islands,
    told_density,
)
from .about_texels import with_about_texels
from .assets import (
    Asset,
    Read,
    goes_on,
    is_layered,
    may_belong,
    may_gain,
    name_for,
    read_rendered,
)
from .bake_request import BakeRequest

_OBJECTS = 12  # the most whose texels a scene has, where each would have had an atlas
_STEP = 16  # texels: sides are multiples of it
_ISLANDS, _ISLAND = 6, 5  # islands of an object in a new unwrap, and texels along the side of a small one
_BY_AREA = 0.5  # power of the area by which texels grow: what is 16 times as large has 4 times as many
_GLOSSY = 2.5  # times as many texels has a mirror as a matt thing …
_MATT = 0.6  # … whose roughness is this, or more
_USUAL = 0.4  # a roughness that is not known
_SHELL, _GROUP = "_shell", "_group"  # of names


@dataclass(frozen=True)
class SceneAtlas:
    """An atlas of a scene, of one object or several, by name.

    It has about `texels` a side, and `density` texels per metre of its surface, in the mean. If
    `wanted` is not 0, so many a side would be needed for the density that was asked for.
    """

    name: str
    objects: tuple[str, ...]
    texels: int
    density: float
    wanted: int = 0

    @property
    def told(self) -> str:
        """What it has, in a line."""
        size = f"{self.texels} x {self.texels} texels, about {told_density(float(f'{self.density:.2g}'))}"
        if len(self.objects) == 1:
            return f"'{self.name}': {size}"
        return f"'{self.name}' has {Asset(self.name, self.objects).told}: {size}"

    def capped(self, density: float) -> Message | None:
        """The warning that its density is lower than the one asked for; None if it is not."""
        if not self.wanted:
            return None
        return capped_warning(f"'{self.name}'", density, self.wanted, self.texels, self.density)


def rendered_atlases(scene: bpy.types.Scene, request: BakeRequest) -> tuple[SceneAtlas, ...]:
    """The atlases of the request's objects as they are in renders, at its first frame.

    Raises as `read_rendered` does.
    """
    frame = request.frames[0] if request.frames else request.spec.frame
    return find_scene_atlases(scene, request, read_rendered(scene, frame))


def requests_of(request: BakeRequest, atlases: Sequence[SceneAtlas]) -> tuple[BakeRequest, ...]:
    """A request for each atlas, and one for the request's other objects, if there are any."""
    found = []
    for atlas in atlases:
        density = None if atlas.wanted else request.spec.density
        found.append(
            replace(
                request,
                objects=atlas.objects,
                shared=atlas.name if len(atlas.objects) > 1 else None,
                spec=replace(request.spec, texels=atlas.texels, density=density),
                open_texels=False,
                as_scene=False,
            )
        )
    inside = {name for atlas in atlases for name in atlas.objects}
    if alone := tuple(name for name in request.objects if name not in inside):
        found.append(replace(request, objects=alone, as_scene=False))
    return tuple(found)


def find_scene_atlases(scene: bpy.types.Scene, request: BakeRequest, read: Read) -> tuple[SceneAtlas, ...]:
    """The atlases of the request's objects, the shell's first. Raises as `read` does.

    `read` tells the objects' surfaces. Objects that the layered layout does not take are in none, nor are
    lower levels of detail. The same scene has the same atlases, with the same names.
    """
    spec, wish, folder = request.spec, request.open_layout, request.folder
    if not may_gain(spec, wish):
        return ()
    layer = find_view_layer(scene, None)
    there = [scene.objects[name] for name in dict.fromkeys(request.objects) if name in scene.objects]
    items = [item for item in there if may_belong(item, layer) and is_layered(scene, item.name, spec, wish)]
    pairs = zip(items, read(items), strict=True)
    known = {item: one for item, one in pairs if one is not None and one.areas.sum() > 0}
    items = list(known)
    needs = _needs(scene, items, known, spec)
    clear = np.array([is_clear(item) for item in items], dtype=bool)
    groups = scene_groups(list(known.values()), needs, MOST_SHARED**2, clear)
    taken = {item.name for item in scene.objects if may_have_faces(item)}
    found = []
    for group in groups:
        members = [items[index] for index in group.members]
        name = _named(scene, group, members, known, taken)
        objects = tuple(item.name for item in members)
        shared = objects if len(objects) > 1 else ()
        need = float(needs[list(group.members)].sum())
        atlas = _sized(scene, SceneAtlas(name, objects, 0, 0.0), members, known, need, spec)
        density = None if atlas.wanted else spec.density
        whole = replace(spec, objects=shared, texels=atlas.texels, density=density)
        whole = with_about_texels(scene, name, whole)
        if is_layered(scene, name, whole, wish) and goes_on(scene, name, whole, folder):
            taken.add(name)
            found.append(atlas)
    return tuple(found)


def _needs(
    scene: bpy.types.Scene,
    items: Sequence[bpy.types.Object],
    surfaces: Mapping[bpy.types.Object, Surface],
    spec: BakeSpec,
) -> Floats:
    """How many texels, squares of an atlas that are not covered included, each object wants: (N,)."""
    areas = np.array([float(surfaces[item].areas.sum()) for item in items])
    if spec.density is not None:
        density = spec.density * metres_per_unit(scene)
        return np.array([float(about_side(area, density)) ** 2 for area in areas])
    shares = areas**_BY_AREA * np.array([_times_for_gloss(item) for item in items])
    found: Floats = shares * (min(len(items), _OBJECTS) * spec.texels**2 / max(shares.sum(), 1e-30))
    return found


def _sized(
    scene: bpy.types.Scene,
    atlas: SceneAtlas,
    items: Sequence[bpy.types.Object],
    surfaces: Mapping[bpy.types.Object, Surface],
    need: float,
    spec: BakeSpec,
) -> SceneAtlas:
    """The atlas with its size, for objects that want `need` texels in all."""
    area = sum(float(surfaces[item].areas.sum()) for item in items)
    metres = metres_per_unit(scene)
    if spec.density is not None:
        wanted = about_side(area, spec.density * metres)
        if wanted <= MOST_SHARED:
            return replace(atlas, texels=wanted, density=spec.density)
        return replace(
            atlas, texels=MOST_SHARED, wanted=wanted, density=density_of_side(area, MOST_SHARED) / metres
        )
    kept = sum(about_islands(item) for item in items) if spec.unwrap is Unwrap.AUTO and len(items) > 1 else 0
    apart = (2 * spec.padding + _ISLAND) * sqrt(max(kept, _ISLANDS * len(items)))
    side = _STEP * ceil(max(sqrt(need), side_for_islands(kept, spec.texels), apart) / _STEP)
    side = min(side, MOST_SHARED, spec.most_texels)
    return replace(atlas, texels=side, density=density_of_side(area, side) / metres)


def _named(
    scene: bpy.types.Scene,
    group: SceneGroup,
    members: Sequence[bpy.types.Object],
    surfaces: Mapping[bpy.types.Object, Surface],
    taken: Collection[str],
) -> str:
    """A name that people understand: of one object its own, of the shell the scene's, else as of assets."""
    if len(members) == 1:
        return members[0].name
    if group.is_shell:
        first = f"{scene.name}{_SHELL}"
        names = (first if number == 1 else f"{first}_{number}" for number in count(1))
        return next(name for name in names if name not in taken)
    return name_for(scene, members, surfaces, taken, _GROUP)


def _times_for_gloss(item: bpy.types.Object) -> float:
    """How many times as many texels an object gets for the glossiest of its materials."""
    roughness = min(map(_roughness, materials_of(item)), default=_MATT)
    return _GLOSSY + (1 - _GLOSSY) * min(roughness / _MATT, 1.0)


def _roughness(material: bpy.types.Material) -> float:
    """The least roughness of a material's shaders; 0.4 where nodes compute it."""
    tree: Any = material.node_tree
    output = None if tree is None else tree.get_output_node("CYCLES")
    return 1.0 if output is None else _least_roughness(output.inputs["Surface"], ())


def _least_roughness(socket: Any, groups: Groups) -> float:
    found = source_of(socket, groups)
    if found is None:
        return 1.0
    node, _, groups = found
    if node.type == "MIX_SHADER":
        return min(_least_roughness(one, groups) for one in list(node.inputs)[1:])
    if node.type == "ADD_SHADER":
        return min(_least_roughness(one, groups) for one in node.inputs)
    if "Roughness" not in node.inputs or node.type == "BSDF_DIFFUSE":
        return 1.0
    known = value_at(node.inputs["Roughness"], groups)
    return _USUAL if known is None else known
