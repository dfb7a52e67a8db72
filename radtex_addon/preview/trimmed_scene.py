# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A copy of the user's scene that holds only what it shows, for the preview's file.

Left out are objects that neither renders nor viewports show, unless a shown one needs them (as a parent, a
boolean's cutter, an instanced collection), the sequencer, and what tools and add-ons point to.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any, cast

import bpy

from ..scene.objects import animates_visibility, is_linked
from ..scene.scratch import remove_scene

_FLAGS = ("exclude", "holdout", "indirect_only", "hide_viewport")  # of layer collections


@dataclass(frozen=True, eq=False)
class Trimmed:
    """The copied `scene`, and the data-blocks that its objects and worlds use."""

    scene: bpy.types.Scene
    used: frozenset[bpy.types.ID]


@contextmanager
def trimmed_scene(
    scene: bpy.types.Scene, shown: Sequence[bpy.types.Object], hidden: Collection[bpy.types.Object] = ()
) -> Iterator[Trimmed]:
    """Within the context, a trimmed copy of the scene stands in its place for all users, by its name.

    The objects `shown` stay in any case, and the first is active; those in `hidden` go unless others need
    them. At exit the session is as it was.
    """
    used = _used_by(_shown_objects(scene, hidden) | {*shown, *_settings_of(scene)})
    clip = scene.active_clip
    if clip is not None and any(_follows_clip(item) for item in used):
        used |= _used_by({clip})
    with ExitStack() as session:
        copy = cast("bpy.types.Scene", scene.copy())
        session.callback(remove_scene, copy)
        session.enter_context(replaced(scene, copy))
        _remove_references(copy, scene, used)
        session.enter_context(_only(copy, used))
        session.enter_context(_sets_last(copy))
        for layer in copy.view_layers:
            if any(item == shown[0] for item in layer.objects):
                layer.objects.active = shown[0]
        yield Trimmed(copy, frozenset(used))


@contextmanager
def replaced(original: bpy.types.ID, copy: bpy.types.ID) -> Iterator[None]:
    """Within the context, the copy replaces the original for all its users, by its name."""
    name = original.name
    original.name = f"{name} (original)"
    copy.name = name
    try:
        original.user_remap(copy)
        yield
    finally:
        copy.user_remap(original)
        copy.name = f"{name} (copy)"
        original.name = name


def _shown_objects(scene: bpy.types.Scene, hidden: Collection[bpy.types.Object]) -> set[bpy.types.ID]:
    """The objects that a view layer of the scene renders or shows in a viewport, at any time."""
    found: set[bpy.types.ID] = set()
    for layer in scene.view_layers:
        for home, renders, is_seen in _homes(layer.layer_collection):
            for item in home.objects:
                in_view = is_seen and not item.hide_viewport and not item.hide_get(view_layer=layer)
                if in_view or (renders and not item.hide_render) or animates_visibility(item):
                    found.add(item)
    return found.difference(hidden)


def _homes(
    home: bpy.types.LayerCollection, renders: bool = True, is_seen: bool = True
) -> Iterator[tuple[bpy.types.Collection, bool, bool]]:
    """A view layer's collections: whether renders, and whether viewports, show what is in them."""
    collection = home.collection
    renders = renders and not collection.hide_render
    is_seen = is_seen and not home.hide_viewport and not collection.hide_viewport
    if not home.exclude:
        yield collection, renders, is_seen
    for child in home.children:
        yield from _homes(child, renders, is_seen)


def _settings_of(scene: bpy.types.Scene) -> Iterator[bpy.types.ID]:
    """What the scene itself shows besides its objects."""
    found: list[bpy.types.ID | None] = [scene.camera, scene.world]
    found += [marker.camera for marker in scene.timeline_markers]
    for layer in scene.view_layers:
        found += [layer.material_override, cast(Any, layer).world_override]
    yield from (block for block in found if block is not None)


def _used_by(blocks: Iterable[bpy.types.ID]) -> set[bpy.types.ID]:
    """The data-blocks, and all that they use, except for what only another scene uses."""
    uses = defaultdict(list)
    for block, users in cast(Any, bpy.data.user_map()).items():
        for user in users:
            uses[user].append(block)
    found: set[bpy.types.ID] = set()
    waiting = list(blocks)
    while waiting:
        block = waiting.pop()
        if block not in found and not isinstance(block, bpy.types.Scene):
            found.add(block)
            waiting += uses[block]
    return found


def _follows_clip(block: bpy.types.ID) -> bool:
    """Whether an object's place follows from the scene's active clip, such as a camera's that was solved."""
    constraints = block.constraints if isinstance(block, bpy.types.Object) else ()
    return any(getattr(each, "use_active_clip", False) for each in constraints)


def _remove_references(copy: Any, scene: bpy.types.Scene, used: Collection[bpy.types.ID]) -> None:
    """Clear what a scene refers to without showing it: strips, clips, paint tools, pointers of add-ons."""
    copy.sequence_editor_clear()
    if copy.active_clip not in used:
        copy.active_clip = None
    if _composites_others(copy, scene):
        if hasattr(copy, "compositing_node_group"):  # Blender 5
            copy.compositing_node_group = None
        else:
            copy.use_nodes = False
            copy.node_tree.nodes.clear()
    tools = copy.tool_settings
    _clear_pointers(tools)
    for tool in tools.bl_rna.properties:
        value = getattr(tools, tool.identifier) if tool.type == "POINTER" else None
        if isinstance(value, bpy.types.Paint):
            _clear_pointers(value)
    _delete_pointers(copy)
    if hasattr(copy, "bl_system_properties_get"):  # Blender 5: what add-ons registered
        _delete_pointers(copy.bl_system_properties_get() or {})


def _composites_others(copy: Any, scene: bpy.types.Scene) -> bool:
    """Whether the compositor shows another scene, which would come into the file with it."""
    tree = copy.compositing_node_group if hasattr(copy, "compositing_node_group") else copy.node_tree
    waiting, seen = [tree], set()
    while waiting:
        tree = waiting.pop()
        if tree is None or tree in seen:
            continue
        seen.add(tree)
        if any(getattr(node, "scene", None) not in (None, scene, copy) for node in tree.nodes):
            return True
        waiting += [getattr(node, "node_tree", None) for node in tree.nodes]
    return False


def _clear_pointers(settings: Any) -> None:
    """Clear a group of settings' pointers to data-blocks."""
    for each in settings.bl_rna.properties:
        is_set = each.type == "POINTER" and not each.is_readonly
        if is_set and isinstance(getattr(settings, each.identifier), bpy.types.ID):
            setattr(settings, each.identifier, None)


def _delete_pointers(group: Any) -> None:
    """Delete the custom properties that point to data-blocks, also in groups and lists of groups."""
    for key, value in list(group.items()):
        if isinstance(value, bpy.types.ID):
            del group[key]
        elif isinstance(value, list):
            for each in value:
                if hasattr(each, "items"):
                    _delete_pointers(each)
        elif hasattr(value, "items"):
            _delete_pointers(value)


@contextmanager
def _sets_last(scene: bpy.types.Scene) -> Iterator[None]:
    """Give background scenes names after the scene's: Blender opens the first scene of such a file."""
    names: dict[bpy.types.Scene, str] = {}
    found = scene.background_set
    while found is not None and found not in names:
        names[found] = found.name
        found = found.background_set
    try:
        for item, name in names.items():
            if name < scene.name and not is_linked(item):
                item.name = f"{scene.name}, {name}"
        yield
    finally:
        for item, name in names.items():
            if item.name != name:
                item.name = name


@contextmanager
def _only(scene: bpy.types.Scene, used: Collection[bpy.types.ID]) -> Iterator[None]:
    """Within the context, a copied scene has only the objects in `used`, in copies of its collections."""
    if all(item in used for item in scene.collection.all_objects):
        yield
        return
    states = [_LayerState.of(layer) for layer in scene.view_layers]
    copies: dict[bpy.types.Collection, bpy.types.Collection] = {}
    names: dict[bpy.types.Collection, str] = {}
    try:
        _take_out(scene.collection, used, copies)
        for home, copy in copies.items():
            names[home] = home.name
            home.name = f"{home.name} (original)"
            copy.name = names[home]
        for state in states:
            state.restore()
        yield
    finally:
        for copy in copies.values():
            bpy.data.collections.remove(copy)
        for home, name in names.items():
            home.name = name


def _take_out(
    home: bpy.types.Collection,
    used: Collection[bpy.types.ID],
    copies: dict[bpy.types.Collection, bpy.types.Collection],
) -> None:
    """Unlink from a copied collection whatever is not in `used`; its changed children become `copies`."""
    for item in list(home.objects):
        if item not in used:
            home.objects.unlink(item)
    children = list(home.children)
    kept = [copy for copy in (_child_with(child, used, copies) for child in children) if copy is not None]
    if kept != children:
        for child in children:
            home.children.unlink(child)
        for child in kept:  # in their order
            home.children.link(child)


def _child_with(
    child: bpy.types.Collection,
    used: Collection[bpy.types.ID],
    copies: dict[bpy.types.Collection, bpy.types.Collection],
) -> bpy.types.Collection | None:
    """A child collection without unused objects: itself, a copy, or None where nothing would be left."""
    items = list(child.all_objects)
    if all(item in used for item in items):
        return child
    if not any(item in used for item in items):
        return None
    if is_linked(child) or child.override_library is not None:
        return child  # its contents are the library's
    if child not in copies:
        copies[child] = cast("bpy.types.Collection", child.copy())
        _take_out(copies[child], used, copies)
    return copies[child]


@dataclass(frozen=True, eq=False)
class _LayerState:
    """How a view layer shows collections and objects, which Blender forgets when they are linked anew."""

    layer: bpy.types.ViewLayer
    collections: dict[tuple[str, ...], dict[str, bool]]  # by the names of the collection and its parents
    hidden: frozenset[bpy.types.Object]
    selected: frozenset[bpy.types.Object]

    @classmethod
    def of(cls, layer: bpy.types.ViewLayer) -> _LayerState:
        collections = {
            path: {flag: bool(getattr(found, flag)) for flag in _FLAGS}
            for path, found in _paths(layer.layer_collection)
        }
        objects = list(layer.objects)
        return cls(
            layer,
            collections,
            frozenset(item for item in objects if item.hide_get(view_layer=layer)),
            frozenset(item for item in objects if item.select_get(view_layer=layer)),
        )

    def restore(self) -> None:
        self.layer.update()
        for path, found in _paths(self.layer.layer_collection):
            for flag, value in self.collections.get(path, {}).items():
                if getattr(found, flag) != value:
                    setattr(found, flag, value)
        self.layer.update()
        for item in self.layer.objects:
            if item in self.hidden:
                item.hide_set(True, view_layer=self.layer)
            elif item in self.selected:
                item.select_set(True, view_layer=self.layer)


def _paths(
    home: bpy.types.LayerCollection, above: tuple[str, ...] = ()
) -> Iterator[tuple[tuple[str, ...], bpy.types.LayerCollection]]:
    path = (*above, home.name)
    yield path, home
    for child in home.children:
        yield from _paths(child, path)
