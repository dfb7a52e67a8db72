# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A picture of texels in the viewport, before anything is baked: a checker whose squares are texels.

The squares are as large as the texels of the scene's atlases will be in the mean. The islands of these are
not known yet, so the squares follow each object's own axes.
"""

from __future__ import annotations

import colorsys
from dataclasses import dataclass
from math import log2
from typing import TYPE_CHECKING, Any

import bpy
import numpy as np

from ..panel.labels import iface_, remark
from ..panel.redraw import redraw_views
from .bake_operator import can_bake, shown

if TYPE_CHECKING:
    from collections.abc import Sequence

    from bpy.stub_internal.rna_enums import OperatorReturnItems

    from ...job.scene_atlases import SceneAtlas

_OCTAVES = 2.0  # of the density around the mean one, from blue to red
_VERTEX = """
void main()
{
    vec4 at = whole * vec4(pos, 1.0);
    at.z -= 1e-4 * at.w;  // before the surface that it lies on
    gl_Position = at;
    inPlace = place;
    facing = normal;
}
"""
_FRAGMENT = """
float checker(vec2 at)
{
    vec2 wide = fwidth(at);
    float sharp = 1.0 - smoothstep(0.25, 0.75, max(wide.x, wide.y));
    return mix(0.5, mod(floor(at.x) + floor(at.y), 2.0), sharp);
}

void main()
{
    vec3 steep = abs(facing);
    vec2 at = steep.z >= max(steep.x, steep.y) ? inPlace.xy : steep.y >= steep.x ? inPlace.xz : inPlace.yz;
    float light = 0.45 + 0.4 * checker(at / size) + 0.15 * checker(at / (8.0 * size));
    fragColor = vec4(tint * light, 0.8);
}
"""


@dataclass(frozen=True)
class Squares:
    """The squares on one object, by name: their `size` in Blender's units, and their colour."""

    name: str
    size: float
    tint: tuple[float, float, float]


class _Shown:
    """What is drawn in all viewports, while it is on."""

    handler: Any = None
    batches: tuple[tuple[Squares, Any], ...] = ()
    shader: Any = None


def is_on() -> bool:
    """Whether the squares are drawn."""
    return _Shown.handler is not None


def squares_of(atlases: Sequence[SceneAtlas], metres: float) -> list[Squares]:
    """The squares of each object of the atlases, where one of Blender's units is so many `metres`."""
    if not atlases:
        return []
    mean = float(np.mean([log2(atlas.density) for atlas in atlases]))
    found = []
    for atlas in atlases:
        above = min(max((log2(atlas.density) - mean) / _OCTAVES, -1.0), 1.0)
        red, green, blue = colorsys.hsv_to_rgb((1.0 - above) / 3.0, 0.75, 1.0)  # from blue to red
        size = 1.0 / (atlas.density * metres)
        found += [Squares(name, size, (red, green, blue)) for name in atlas.objects]
    return found


class RADTEX_OT_show_texels(bpy.types.Operator):
    """Show how large the texels of Bake the Scene will be: a square is a texel, and red has more of them"""

    bl_idname = "radtex.show_texels"
    bl_label = "Show Texels"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context | None) -> bool:
        if bpy.app.background:
            cls.poll_message_set("There is no viewport to show them in")
            return False
        return is_on() or can_bake(cls, context)

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import RadTexError
        from ...scene.units import metres_per_unit

        if is_on():
            hide()
            return {"FINISHED"}
        scene, layer = shown(context)
        try:
            atlases = atlases_of_scene(scene, layer)
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        if not atlases:
            self.report({"ERROR"}, iface_("There is no object whose texels are known before it is baked"))
            return {"CANCELLED"}
        _show(layer, squares_of(atlases, metres_per_unit(scene)))
        densities = [atlas.density for atlas in atlases]
        few, many = f"{min(densities):.3g}", f"{max(densities):.3g}"
        told = iface_("A square is a texel: {} to {} of them per metre")
        if few == many:
            told = iface_("A square is a texel: {} of them per metre")
        self.report({"INFO"}, told.format(few, many))
        return {"FINISHED"}


def atlases_of_scene(scene: bpy.types.Scene, layer: bpy.types.ViewLayer) -> tuple[SceneAtlas, ...]:
    """The atlases that Bake the Scene would make of all meshes. Raises RadTexError."""
    from ...preview.collection_meshes import meshes_of
    from ...preview.swap import original_of
    from ..panel.request_checks import sort_out
    from .scene_operator import PATIENCE, requests_and_atlases

    names = sorted({(original_of(item) or item).name for item in meshes_of(scene.collection, layer)})
    kept = sort_out(scene, names, patience=PATIENCE).kept
    return requests_and_atlases(scene, kept, again=True)[1]


def _show(layer: bpy.types.ViewLayer, squares: Sequence[Squares]) -> None:
    import gpu

    types: Any = gpu.types  # the 4.5 stubs know no arguments
    create = types.GPUShaderCreateInfo()
    between = types.GPUStageInterfaceInfo("radtex_texels")
    for kind, name in (("VEC3", "inPlace"), ("VEC3", "facing")):
        between.smooth(kind, name)
    for kind, name in (("MAT4", "whole"), ("VEC3", "tint"), ("FLOAT", "size")):
        create.push_constant(kind, name)
    for number, name in enumerate(("pos", "place", "normal")):
        create.vertex_in(number, "VEC3", name)
    create.vertex_out(between)
    create.fragment_out(0, "VEC4", "fragColor")
    create.vertex_source(_VERTEX)
    create.fragment_source(_FRAGMENT)
    _Shown.shader = gpu.shader.create_from_info(create)
    drawn = ((one, _batch_of(layer, one.name)) for one in squares if one.name in layer.objects)
    _Shown.batches = tuple((one, batch) for one, batch in drawn if batch is not None)
    views: Any = bpy.types.SpaceView3D
    _Shown.handler = views.draw_handler_add(_draw, (), "WINDOW", "POST_VIEW")
    redraw_views()


def _batch_of(layer: bpy.types.ViewLayer, name: str) -> Any:
    """An object's triangles as the viewport has them, with their places in its own axes, scaled as it is.

    None for a metaball whose faces are another one's.
    """
    from gpu_extras.batch import batch_for_shader

    from ...scene.mesh.attribute_arrays import bulk
    from ...scene.surfaces import shown_mesh

    item: Any = layer.objects[name]
    evaluated = item.evaluated_get(layer.depsgraph)
    with shown_mesh(evaluated) as mesh:
        if mesh is None:
            return None
        mesh.calc_loop_triangles()
        position = bulk(mesh.vertices, "co", 3, np.float32).reshape(-1, 3)
        corners = bulk(mesh.loop_triangles, "vertices", 3, np.int32).reshape(-1, 3)
    scale = np.array(evaluated.matrix_world.to_scale(), dtype=np.float32)
    flat = position[corners]
    place = flat * scale
    normal = np.cross(place[:, 1] - place[:, 0], place[:, 2] - place[:, 0])
    values = {"pos": flat, "place": place, "normal": np.repeat(normal[:, None], 3, axis=1)}
    columns: Any = {name: value.reshape(-1, 3).astype(np.float32) for name, value in values.items()}
    return batch_for_shader(_Shown.shader, "TRIS", columns)


def _draw() -> None:
    import gpu

    state: Any = gpu.state
    state.depth_test_set("LESS_EQUAL")
    state.blend_set("ALPHA")
    seen = gpu.matrix.get_projection_matrix() @ gpu.matrix.get_model_view_matrix()
    for squares, batch in _Shown.batches:
        item = bpy.data.objects.get(squares.name)
        if item is None or not item.visible_get():
            continue
        _Shown.shader.uniform_float("whole", seen @ item.matrix_world)
        _Shown.shader.uniform_float("tint", squares.tint)
        _Shown.shader.uniform_float("size", squares.size)
        batch.draw(_Shown.shader)
    state.blend_set("NONE")
    state.depth_test_set("NONE")


def hide() -> None:
    """Take the squares away, if they are drawn."""
    if not is_on():
        return
    views: Any = bpy.types.SpaceView3D
    views.draw_handler_remove(_Shown.handler, "WINDOW")
    _Shown.handler, _Shown.batches, _Shown.shader = None, (), None
    redraw_views()
