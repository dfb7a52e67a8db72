# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Show a finished bake in the user's own scene: the baked copy in the object's place, the object hidden.

Each of the two stores a pointer to the other, which survives renaming, duplicating, saving and undo; and the
object's visibility before, so that it can be restored even if the other was deleted.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ..core.errors import InputError, RadTexError
from ..formats.sidecar import called_in
from ..formats.sidecar_file import AnySidecar, SidecarFile, opened
from ..scene.mesh.copy import MATRIX, SHOWN, copy_object
from ..scene.objects import animates_visibility
from ..scene.surfaces import may_have_faces
from .hidden_objects import (
    RECORD,
    Flags,
    hidden_by,
    hide_originals,
    objects_to_hide,
    restore_visibility,
)
from .light_linking import link_alike
from .lit_material import follow_sun
from .load import load_baked_meshes, remove_unused
from .moved_preview import follow_preview, following, transform_record
from .save import images_of
from .variant import check_layer, keep_variant, show_layer

ORIGINAL = "radtex_original"  # custom property of a copy: the object, and its visibility before
_TRANSFORM = "transform"  # in that property: the transform that the copy began with
_FLAGS = ("hide_render", "hide_viewport")
_MOVED = 1e-4  # tolerance, relative to a matrix's largest value


@dataclass(frozen=True, eq=False)
class Preview:
    """A preview that is on: `copy` in the place of `original`, which may have `moved` since the bake."""

    original: bpy.types.Object
    copy: bpy.types.Object
    moved: bool


def is_on(item: bpy.types.Object) -> bool:
    """Whether the object's preview is on; also True if the object is a preview."""
    return _pair(item) is not None


def shows_any_of(item: bpy.types.Object, files: Iterable[Path]) -> bool:
    """Whether the object's preview is on, and shows one of these image files."""
    copy = copy_of(item)
    materials = [] if copy is None else [slot.material for slot in copy.material_slots]
    trees = [material.node_tree for material in materials if material is not None]
    shown = {_plain(bpy.path.abspath(image.filepath)) for tree in trees for image in images_of(tree)}
    return not shown.isdisjoint(map(_plain, files))


def original_of(item: bpy.types.Object) -> bpy.types.Object | None:
    """The object that a preview replaces, None if it was deleted; any other object is returned as it is."""
    pair = _pair(item)
    return item if pair is None else pair[0]


def copy_of(item: bpy.types.Object) -> bpy.types.Object | None:
    """The preview that replaces an object; None if no preview is on, or if it was deleted."""
    pair = _pair(item)
    return None if pair is None else pair[1]


def switch_on(original: bpy.types.Object, sidecar: AnySidecar, layer: str | None = None) -> Preview:
    """Show the bake with this sidecar in the place of one object: see `switch_all_on`."""
    return switch_all_on([original], sidecar, layer)[0]


def switch_all_on(
    originals: Sequence[bpy.types.Object], sidecar: AnySidecar, layer: str | None = None
) -> list[Preview]:
    """Show the bake with this sidecar, from the saved preview beside it, in the place of its objects.

    Copies with the bake's meshes and materials are linked to the objects' collections; they have the objects'
    parents, transforms, animation and visibility, and take over their selection. The objects are hidden, as
    are those whose light the bake shows (`source`); nothing else changes. A `layer` is shown instead of the
    whole. A preview that is on already is replaced. Raises InputError for an object that cannot be replaced
    or is not in the bake, an unknown layer, and missing files, FormatError for files that cannot be read;
    then nothing has changed.
    """
    for original in originals:
        _check(original)
    sidecar = opened(sidecar)
    if layer is not None:
        check_layer(sidecar, layer)
    meshes = load_baked_meshes(sidecar, [original.name for original in originals])
    if layer is not None:
        _show_layer(meshes, sidecar, layer)
    made = [_show(original, mesh, sidecar) for original, mesh in zip(originals, meshes, strict=True)]
    remove_unused()
    return made


def _show_layer(meshes: Sequence[bpy.types.Mesh], sidecar: SidecarFile, layer: str) -> None:
    try:
        show_layer(meshes, sidecar, layer)
    except RadTexError:
        bpy.data.batch_remove(meshes)
        remove_unused()
        raise


def _show(original: bpy.types.Object, mesh: bpy.types.Mesh, sidecar: SidecarFile) -> Preview:
    for material in mesh.materials:
        if material is not None:
            follow_sun(material, original.users_scene[0])
    _take_away(original)
    copy = stand_in(original, mesh)
    copy.name = f"{shown_name(original, sidecar)} (baked)"
    stances = _layer_states(original)
    link_alike(copy, original, homes(original))
    _hide(original, copy)
    keep_variant(copy, sidecar)
    hide_originals((original, copy), objects_to_hide(sidecar, original.users_scene[0]), _others(copy))
    _take(copy, stances)
    _join_local_views(original, copy)
    return Preview(original, copy, has_moved(original.matrix_world, mesh))


def switch_off(item: bpy.types.Object) -> None:
    """Remove the preview of the object `item`, or the preview `item` itself; show the object as it was.

    The object takes over the preview's selection and its visibility in view layers, and what the user has
    changed of its transform and parent. Data that was loaded with
    the preview is removed, unless something else uses it by now. Does nothing if no preview is on.
    """
    if _take_away(item):
        remove_unused()


@contextmanager
def originals_rendered(originals: Sequence[bpy.types.Object]) -> Iterator[None]:
    """Within the context, render the objects, or those whose light the bakes show, instead of the previews.

    They stand where the previews do. Objects whose previews are off are left alone.
    """
    pairs = [pair for pair in map(_pair, originals) if pair is not None]
    shown: dict[bpy.types.Object, bool] = {}
    for original, copy in pairs:
        instead = hidden_by((original, copy))
        shown |= {item: flags["hide_render"] for item, flags in instead.items()}
        if original is not None and not instead:
            shown[original] = _flags_of(original, copy)["hide_render"]
        if copy is not None:
            shown[copy] = True
    before = {item: item.hide_render for item in shown}
    try:
        for item, hidden in shown.items():
            item.hide_render = hidden
        with following(_followed(pairs)):
            yield
    finally:
        for item, hidden in before.items():
            item.hide_render = hidden


@contextmanager
def previews_off(scene: bpy.types.Scene) -> Iterator[None]:
    """Within the context, the scene shows the objects whose previews are on, and hides these previews.

    The objects stand where the previews do. The objects do not point to their previews meanwhile.
    """
    pairs = _pairs_in(scene)
    shown, followed = _flags_without_previews(pairs), _followed(pairs)
    records: list[tuple[Any, str, Any]] = []
    for original, _ in pairs:
        if original is not None:
            owner = cast(Any, original)
            records += [(owner, key, owner[key].to_dict()) for key in (SHOWN, RECORD) if key in owner]
    before = {item: {flag: bool(getattr(item, flag)) for flag in _FLAGS} for item in shown}
    try:
        for owner, key, _ in records:
            if key in owner:
                del owner[key]
        _set_flags(shown)
        with following(followed):
            yield
    finally:
        for owner, key, value in records:
            owner[key] = value
        _set_flags(before)


@contextmanager
def previews_not_rendered(scene: bpy.types.Scene) -> Iterator[None]:
    """Within the context, renders of the scene show the objects whose previews are on, and no previews.

    The objects stand where the previews do.
    """
    pairs = _pairs_in(scene)
    shown = _flags_without_previews(pairs)
    before = {item: {"hide_render": item.hide_render} for item in shown}
    try:
        _set_flags({item: {"hide_render": flags["hide_render"]} for item, flags in shown.items()})
        with following(_followed(pairs)):
            yield
    finally:
        _set_flags(before)


def _pairs_in(scene: bpy.types.Scene) -> list[_Pair]:
    """The objects of a scene whose previews are on, with these."""
    return [pair for pair in map(_pair, scene.objects) if pair is not None]


def _flags_without_previews(pairs: Iterable[_Pair]) -> dict[bpy.types.Object, Flags]:
    """What would be hidden if these previews were off: of the objects, of those they hide, and of them."""
    shown: dict[bpy.types.Object, Flags] = {}
    for original, copy in pairs:
        shown |= hidden_by((original, copy))
        if original is not None:
            shown[original] = _flags_of(original, copy)
        if copy is not None:
            shown[copy] = dict.fromkeys(_FLAGS, True)
    return shown


def _plain(path: Path | str) -> str:
    """A path as others spell it, too; the file system is not asked."""
    return os.path.normcase(os.path.normpath(Path(path).absolute()))


def _set_flags(wanted: Mapping[bpy.types.Object, Flags]) -> None:
    for item, flags in wanted.items():
        for flag, value in flags.items():
            setattr(item, flag, value)


def _others(copy: bpy.types.Object | None) -> list[bpy.types.Object]:
    """All previews that are on, except `copy`."""
    return [item for item in bpy.data.objects if ORIGINAL in cast(Any, item) and item != copy and is_on(item)]


_Pair = tuple[bpy.types.Object | None, bpy.types.Object | None]


def _take_away(item: bpy.types.Object) -> bool:
    """Remove the copy and show the object; `item` is either. Returns False if there is no preview."""
    pair = _pair(item)
    if pair is None:
        return False
    original, copy = pair
    flags = _flags_of(original, copy)
    stances: list[_LayerState] = []
    restore_visibility(pair, _others(copy))
    moved = False
    if original is not None and copy is not None:
        moved = follow_preview(original, copy, _transform_of(copy))
    if copy is not None:
        stances, named = _layer_states(copy), cast(Any, copy)[ORIGINAL].get("original")
        bpy.data.objects.remove(copy)
        if original is None and named is not None and not named.users:
            bpy.data.objects.remove(named)  # it was deleted, and only the copy still used it
    if original is not None:
        for flag, value in flags.items():
            setattr(original, flag, value)
        if SHOWN in cast(Any, original):
            del cast(Any, original)[SHOWN]
        _take(original, stances)
        if moved:
            _update(original)
    return True


def _update(item: bpy.types.Object) -> None:
    """Bring the matrix of an object up to date."""
    for layer in (layer for scene in item.users_scene for layer in scene.view_layers):
        if is_in(layer, item):
            layer.update()


def _followed(pairs: Iterable[_Pair]) -> list[tuple[bpy.types.Object, bpy.types.Object, Any]]:
    """The pairs of which nothing was deleted, each once, with the transform that its preview began with."""
    whole = {original: copy for original, copy in pairs if original is not None and copy is not None}
    return [(original, copy, _transform_of(copy)) for original, copy in whole.items()]


def _transform_of(copy: Any) -> Any:
    """The transform that a preview began with; None if an earlier version has made it."""
    return copy[ORIGINAL].get(_TRANSFORM)


def _pair(item: Any) -> _Pair | None:
    """An object and its preview; `item` is either. None if it has no preview.

    One of the two is None if it was deleted. A duplicate of either points to the other, which does not point
    back: it counts as an object without preview.
    """
    if ORIGINAL in item:
        original = _living(item[ORIGINAL].get("original"))
        if original is None or _named_copy(original) == item:
            return original, item
        return None
    copy = _named_copy(item)
    if copy is not None and copy[ORIGINAL].get("original") != item:
        return None
    return (item, copy) if copy is not None or SHOWN in item else None


def _named_copy(original: Any) -> Any:
    """The preview that an object points to.

    Files do not keep the pointer of a library override: its preview is the one that points to it.
    """
    if SHOWN in original:
        copy = original[SHOWN].get("copy")
        return copy if copy is not None and ORIGINAL in copy else None
    if original.override_library is None:
        return None
    named = (copy for copy in bpy.data.objects if ORIGINAL in cast(Any, copy))
    return next((copy for copy in named if cast(Any, copy)[ORIGINAL].get("original") == original), None)


def _living(item: bpy.types.Object | None) -> bpy.types.Object | None:
    """The object, or None if it was deleted and only our pointer still uses it."""
    return item if item is not None and item.users_collection else None


def _flags_of(original: Any, copy: Any) -> dict[str, bool]:
    """An object's visibility before its preview was shown, as stored on either of the two."""
    record = original[SHOWN] if original is not None and SHOWN in original else copy[ORIGINAL]
    return {flag: bool(record[flag]) for flag in _FLAGS}


def _check(original: bpy.types.Object) -> None:
    name = original.name
    if not may_have_faces(original):
        raise InputError(f"object '{name}' is no mesh: only a baked mesh has a preview")
    if original.library is not None:
        raise InputError(
            f"object '{name}' is linked from {original.library.name}, where nothing can be hidden: "
            "make a library override of it (Object > Library Override > Make), or make it local"
        )
    if not original.users_scene:
        raise InputError(f"object '{name}' is in no scene: link it to a collection")
    if original.mode != "OBJECT":
        raise InputError(f"object '{name}' is being edited: go back to Object Mode")
    if animates_visibility(original):
        raise InputError(
            f"object '{name}' has animated visibility, which would show it again: mute that animation"
        )


def shown_name(original: bpy.types.Object, sidecar: SidecarFile) -> str:
    """What a copy that shows a bake is called after: the object, or the bake's own name."""
    called = called_in(sidecar.facts)
    if not called:
        return original.name
    return f"{original.name}, {called}" if "objects" in sidecar.facts.values else called


def stand_in(original: bpy.types.Object, mesh: bpy.types.Mesh) -> bpy.types.Object:
    """A copy of the object that shows the mesh, linked to no collection."""
    copy = copy_object(original, mesh)
    for collection in copy.users_collection:  # Blender 5 adds a rigid body's copy to its world
        collection.objects.unlink(copy)
    if copy.override_library is not None:
        copy = cast("bpy.types.Object", copy.make_local())
    copy.name = f"{original.name} (baked)"
    for key in (SHOWN, RECORD):  # copied with an original whose preview is on, or a duplicate of one
        if key in cast(Any, copy):
            del cast(Any, copy)[key]
    return copy


def _hide(original: Any, copy: Any) -> None:
    """Hide an object; store on it and on its copy a pointer to the other and the object's visibility."""
    stale = original.get(SHOWN)  # the original is a duplicate of a hidden object, whose visibility counts
    flags = {flag: bool(stale[flag] if stale else getattr(original, flag)) for flag in _FLAGS}
    original[SHOWN] = {"copy": copy, **flags}
    copy[ORIGINAL] = {"original": original, **flags, _TRANSFORM: transform_record(copy)}
    for flag in _FLAGS:
        setattr(copy, flag, flags[flag])
        setattr(original, flag, True)


def homes(original: bpy.types.Object) -> list[bpy.types.Collection]:
    """The collections to link the copy to: the object's, or its scenes' if none of those can be changed."""
    worlds = [scene.rigidbody_world for scene in bpy.data.scenes if scene.rigidbody_world is not None]
    bodies = {part for world in worlds for part in (world.collection, world.constraints)}
    found = [home for home in original.users_collection if home not in bodies and not is_foreign(home)]
    return found or [scene.collection for scene in original.users_scene if not is_foreign(scene)]


def is_foreign(block: Any) -> bool:
    """Whether the contents of a collection or scene come from a library."""
    return block.library is not None or block.override_library is not None


@dataclass(frozen=True)
class _LayerState:
    """An object's selection and visibility in a view layer, and whether it is the active object."""

    layer: bpy.types.ViewLayer
    selected: bool
    hidden: bool
    active: bool


def _layer_states(item: bpy.types.Object) -> list[_LayerState]:
    return [
        _LayerState(
            layer,
            item.select_get(view_layer=layer),
            item.hide_get(view_layer=layer),
            layer.objects.active == item,
        )
        for scene in item.users_scene
        for layer in scene.view_layers
        if is_in(layer, item)
    ]


def is_in(layer: bpy.types.ViewLayer, item: bpy.types.Object) -> bool:
    """Whether a view layer has the object, visible or not."""
    item.select_get(view_layer=layer)  # makes Blender update the layer's objects
    return any(other == item for other in layer.objects)


def _take(item: bpy.types.Object, stances: Sequence[_LayerState]) -> None:
    """Give an object the selection and visibility that another object had."""
    for stance in stances:
        layer = stance.layer
        if not is_in(layer, item):
            continue
        item.hide_set(stance.hidden, view_layer=layer)
        if stance.selected:
            layer.update()  # until then it cannot be selected
        item.select_set(stance.selected, view_layer=layer)
        if stance.active:
            layer.objects.active = item


def _join_local_views(original: bpy.types.Object, copy: bpy.types.Object) -> None:
    """Show the copy in every 3D view whose local view contains the original."""
    for screen in bpy.data.screens:
        for area in screen.areas:
            space = area.spaces.active
            if isinstance(space, bpy.types.SpaceView3D) and space.local_view is not None:
                copy.local_view_set(space, original.local_view_get(space))


def has_moved(matrix: Any, mesh: Any) -> bool:
    """Whether an object at `matrix`, in the world, has moved since the bake with this mesh."""
    if MATRIX not in mesh:
        return False
    baked = np.array(mesh[MATRIX]).reshape(4, 4)
    gap = np.abs(np.array(matrix) - baked).max()
    return bool(gap > _MOVED * np.abs(baked).max())
