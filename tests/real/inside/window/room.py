# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""In the Blender under test: the scene that is baked, what else a user does, and what has changed since."""

from __future__ import annotations

from typing import Any

import bpy

from tests.blender.fingerprint import differences, fingerprint

# What Blender finds out anew at some later time, and after an undo.
_DERIVED = ("is_runtime_data", "node_tree.users", "particle_edit.object", "preview.icon_id")
_DISTANCE = 8.0  # of the viewer
_remembered: dict[str, dict[str, object]] = {}
_context: Any = bpy.context  # of which the stubs know no window without `None`


def build(path: str) -> None:
    """A golden Suzanne over a floor, saved as `path`."""
    bpy.ops.object.delete()
    bpy.ops.mesh.primitive_plane_add(size=8, location=(0, 0, -1))
    bpy.ops.mesh.primitive_monkey_add(size=2)
    bpy.ops.object.shade_smooth()
    gold: Any = bpy.data.materials.new("Gold")
    inputs = gold.node_tree.nodes["Principled BSDF"].inputs
    inputs["Base Color"].default_value = 1, 0.6, 0.2, 1
    inputs["Metallic"].default_value, inputs["Roughness"].default_value = 1, 0.25
    _context.object.data.materials.append(gold)
    _view().spaces.active.region_3d.view_distance = _DISTANCE
    step("Scene")
    bpy.ops.wm.save_as_mainfile(filepath=path)


def build_lamp(path: str) -> None:
    """A desk lamp of three materials, bevelled, subdivided, and unwrapped by its maker; saved."""
    bpy.ops.object.delete()
    bpy.ops.mesh.primitive_cylinder_add(vertices=24, radius=0.8, depth=0.2)
    lamp: Any = _context.object
    lamp.name = "Lamp"
    for vertices, radius, depth, height in ((12, 0.1, 1.6, 0.8), (24, 0.6, 0.5, 1.7)):
        bpy.ops.mesh.primitive_cylinder_add(
            vertices=vertices, radius=radius, depth=depth, location=(0, 0, height)
        )
        lamp.select_set(True)
        _context.view_layer.objects.active = lamp
        bpy.ops.object.join()
    looks = {
        "Enamel": ((0.7, 0.05, 0.04), 0, 0.3),
        "Brass": ((0.9, 0.7, 0.3), 1, 0.2),
        "Rubber": ((0.03,) * 3, 0, 0.6),
    }
    for name, (colour, metallic, roughness) in looks.items():
        material: Any = bpy.data.materials.new(name)
        inputs = material.node_tree.nodes["Principled BSDF"].inputs
        inputs["Base Color"].default_value = *colour, 1
        inputs["Metallic"].default_value, inputs["Roughness"].default_value = metallic, roughness
        lamp.data.materials.append(material)
    for face in lamp.data.polygons:
        face.material_index = 2 if face.center.z < 0.15 else 1 if face.center.z < 1.4 else 0
    for kind, settings in (("BEVEL", {"width": 0.03, "segments": 2}), ("SUBSURF", {"levels": 1})):
        modifier: Any = lamp.modifiers.new(kind, kind)
        for name, value in settings.items():
            setattr(modifier, name, value)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.smart_project(island_margin=0.02)
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.ops.mesh.primitive_plane_add(size=8, location=(0, 0, -0.1))
    select("Lamp")
    bpy.ops.wm.save_as_mainfile(filepath=path)


def step(message: str) -> None:
    """What was done till now is one step to undo."""
    bpy.ops.ed.undo_push(message=message)


def undo(*, again: bool = False) -> None:
    """Undo or redo as a script does."""
    with _context.temp_override(window=_window(), area=_view()):
        (bpy.ops.ed.redo if again else bpy.ops.ed.undo)()


def select(*names: str) -> None:
    """Select these objects alone; the last becomes the active one."""
    for item in bpy.data.objects:
        item.select_set(item.name in names)
    _context.view_layer.objects.active = bpy.data.objects[names[-1]]
    step("Select")


def seen() -> list[str]:
    """Names of the meshes that are seen."""
    return sorted(item.name for item in _context.visible_objects if item.type == "MESH")


def shade(engine: str, shading: str) -> None:
    """How the 3D view is drawn."""
    _context.scene.render.engine, _view().spaces.active.shading.type = engine, shading


def close_other_windows() -> None:
    """Leave the first window alone."""
    for window in _context.window_manager.windows[1:]:
        with _context.temp_override(window=window):
            bpy.ops.wm.window_close()


def remember(name: str) -> None:
    """Keep what is there now."""
    _remembered[name] = _digest()


def changes(name: str) -> list[str]:
    """What is not as it was when that was remembered."""
    return sorted(map(str, differences(_remembered[name], _digest()).items()))


def _digest() -> dict[str, object]:
    found = fingerprint()
    return {path: value for path, value in found.items() if not any(word in path for word in _DERIVED)}


def _window() -> Any:
    return _context.window_manager.windows[0]


def _view() -> Any:
    return next(area for area in _window().screen.areas if area.type == "VIEW_3D")
