# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that touch are one asset: find such groups among those to be baked, and name their atlases.

Most of what a part mirrors are the other parts, whose light is in their texels: one atlas of all has them.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TypeAlias

import bpy

from ..core.errors import InputError
from ..preview.swap import copy_of, is_on, original_of
from ..scene.mesh.asset_parts import asset_groups
from ..scene.mesh.touching import Surface, surfaces_in_render, surfaces_shown
from ..scene.objects import is_rendered
from ..scene.scratch import at_frame, find_view_layer, scratch_scene
from ..scene.surfaces import may_have_faces
from ..settings.spec import BakeSpec
from ..store.bake_folder import BakeFolder, FolderState
from .about_texels import with_about_texels, with_texels_of_several
from .bake_request import BakeRequest
from .layout_choice import OpenLayout, choose_layout
from .variants import named_in

Read: TypeAlias = Callable[[Sequence[bpy.types.Object]], list[Surface | None]]

_LEVEL = re.compile(r".+_LOD0*[1-9]\d*", re.IGNORECASE | re.DOTALL)  # a lower level of detail
_DEFAULT = re.compile(r"Collection( \d+|\.\d+)?")  # Blender's own name, which says nothing
_NAMED = 4  # most names in a line
_SUFFIX = "_asset"  # of a name that is made of an object's


@dataclass(frozen=True)
class Asset:
    """Two or more `objects`, by name, that are baked into one atlas of that `name`."""

    name: str
    objects: tuple[str, ...]

    @property
    def told(self) -> str:
        """The objects in words, such as "'Seat', 'Back' and 4 more"."""
        *first, last = (f"'{name}'" for name in self.objects)
        more = len(first) + 1 - _NAMED
        if more > 0:
            return f"{', '.join(first[:_NAMED])} and {more} more"
        return f"{', '.join(first)} and {last}"


def find_assets(
    scene: bpy.types.Scene,
    names: Sequence[str],
    spec: BakeSpec,
    wish: OpenLayout | None,
    folder: Path | None,
    read: Read,
) -> tuple[Asset, ...]:
    """The groups of the objects `names` that touch and gain from one atlas, in the order of their first ones.

    `spec`, `wish` and `folder` are as in `choose_layout`; `read` tells the surfaces of objects. What is not
    there, or is a lower level of detail by its name, belongs to none. To accumulate, a group must have been
    baked as one. Raises what `read` raises.
    """
    if not may_gain(spec, wish):
        return ()
    layer = find_view_layer(scene, None)
    there = [scene.objects[name] for name in dict.fromkeys(names) if name in scene.objects]
    items = [item for item in there if may_belong(item, layer)]
    if len(items) < 2:
        return ()
    known = {item: one for item, one in zip(items, read(items), strict=True) if one is not None}
    unfit: set[bpy.types.Object] = set()
    while True:
        some = [item for item in known if item not in unfit]
        groups = [[some[index] for index in group] for group in asset_groups([known[item] for item in some])]
        checked = [item for group in groups for item in group]
        others = {item for item in checked if not is_layered(scene, item.name, spec, wish)}
        if not others:
            break
        unfit |= others
    taken = {item.name for item in scene.objects if may_have_faces(item)}
    found = []
    for group in groups:
        asset = Asset(name_for(scene, group, known, taken, _SUFFIX), tuple(item.name for item in group))
        taken.add(asset.name)
        whole = with_about_texels(scene, asset.name, spec_of_asset(scene, spec, asset))
        if is_layered(scene, asset.name, whole, wish) and goes_on(scene, asset.name, whole, folder):
            found.append(asset)
    return tuple(found)


def asset_requests(scene: bpy.types.Scene, request: BakeRequest) -> tuple[BakeRequest, ...]:
    """A request for each group of objects that touch, and one for the others, if `request` asks for that.

    Raises as `read_rendered` does.
    """
    if not request.assets:
        return (request,)
    found = rendered_assets(scene, request)
    inside = {name for asset in found for name in asset.objects}
    alone = tuple(name for name in request.objects if name not in inside)
    requests = [replace(request, objects=each.objects, shared=each.name, assets=False) for each in found]
    if alone or not requests:
        requests.append(replace(request, objects=alone, assets=False))
    return tuple(requests)


def rendered_assets(scene: bpy.types.Scene, request: BakeRequest) -> tuple[Asset, ...]:
    """The groups of the request's objects that touch in renders, at its first frame. Raises as above."""
    frame = request.frames[0] if request.frames else request.spec.frame
    read = read_rendered(scene, frame)
    return find_assets(scene, request.objects, request.spec, request.open_layout, request.folder, read)


def read_shown(scene: bpy.types.Scene) -> Read:
    """Reads surfaces as the viewport shows them: quick, and changes nothing.

    Where a bake is shown in an object's place, it has the object's surface.
    """
    layer = find_view_layer(scene, None)
    if bpy.app.background:
        layer.update()  # without a window nothing else brings it up to date
    return lambda items: surfaces_shown(layer, [copy_of(item) or item for item in items])


def read_rendered(scene: bpy.types.Scene, frame: int | None) -> Read:
    """Reads surfaces as a render at a frame, or the current one, has them.

    Raises BakeError where Blender does not render, InputError as `scratch_scene` does.
    """

    def read(items: Sequence[bpy.types.Object]) -> list[Surface | None]:
        with at_frame(scene, frame), scratch_scene(scene) as scratch:
            return surfaces_in_render(scratch, items)

    return read


def spec_of_asset(scene: bpy.types.Scene, spec: BakeSpec, asset: Asset) -> BakeSpec:
    """The specification of an asset's bake, where `spec` is that of each object by itself."""
    return with_texels_of_several(scene, replace(spec, objects=asset.objects))


def may_gain(spec: BakeSpec, wish: OpenLayout | None) -> bool:
    """Whether bakes by that specification may gain from one atlas, and can have one."""
    kind = spec.kind.traits
    apart = spec.source is not None or spec.split is not None or spec.uv_layer is not None
    if apart or spec.refresh or spec.where is not None:
        return False
    return kind.looks_at_surface and kind.shared_atlas and (wish is not None or spec.form.by_paths)


def may_belong(item: bpy.types.Object, layer: bpy.types.ViewLayer) -> bool:
    """Whether an object has faces and renders, or whose bake is shown, and no lower level of detail."""
    is_there = is_on(item) or is_rendered(item, layer)
    return may_have_faces(item) and is_there and not _LEVEL.fullmatch(item.name)


def is_layered(scene: bpy.types.Scene, name: str, spec: BakeSpec, wish: OpenLayout | None) -> bool:
    """Whether the layout is one whose texels mirror one another."""
    try:
        return choose_layout(scene, (name, spec), wish, None).spec.form.by_paths
    except InputError:
        return False


def goes_on(scene: bpy.types.Scene, name: str, spec: BakeSpec, folder: Path | None) -> bool:
    """Whether there is what the bake adds to, if it does."""
    if not spec.accumulate or folder is None:
        return not spec.accumulate
    return BakeFolder(name, named_in(scene, spec), folder).state is not FolderState.NOTHING


def name_for(
    scene: bpy.types.Scene,
    group: Sequence[bpy.types.Object],
    surfaces: Mapping[bpy.types.Object, Surface],
    taken: Collection[str],
    suffix: str,
) -> str:
    """A name for a group that is not `taken`: that of a parent or a collection of it alone.

    Else the largest object's with the `suffix`.
    """
    for name in (*_parents_of(group), *_collections_of(scene, group)):
        if name not in taken:
            return name
    largest = max(group, key=lambda item: float(surfaces[item].areas.sum()))
    name = f"{largest.name}{suffix}"
    while name in taken:
        name += suffix
    return name


def _parents_of(group: Sequence[bpy.types.Object]) -> Iterator[str]:
    """Names of the parents that all of them have, the nearest one first, but of those with other meshes."""
    parent, inside = group[0].parent, set(group)
    while parent is not None:
        below = _meshes_among(parent.children_recursive)
        if inside <= below:
            if below <= inside and not may_have_faces(parent):
                yield parent.name
            else:
                return
        parent = parent.parent


def _collections_of(scene: bpy.types.Scene, group: Sequence[bpy.types.Object]) -> Iterator[str]:
    """Names of the scene's collections of these meshes alone, the smallest first."""
    found = [
        (len(collection.children_recursive), collection.name)
        for collection in scene.collection.children_recursive
        if _meshes_among(collection.all_objects) == set(group) and not _DEFAULT.fullmatch(collection.name)
    ]
    yield from (name for _, name in sorted(found))


def _meshes_among(items: Iterable[bpy.types.Object]) -> set[bpy.types.Object]:
    """The meshes that render, with objects in the place of their previews."""
    return {original_of(item) or item for item in items if may_have_faces(item) and not item.hide_render}
