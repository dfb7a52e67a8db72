# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials with a light of their own, which follows the scene's first sun; and those of `shadow` and `ao`.

Drivers copy the sun's direction, colour and strength to two of its nodes, so that the light follows the sun,
in Eevee and Cycles. Blender evaluates drivers this simple without Python, so that the file need not be
trusted to run scripts. Without a sun the two nodes hold a default light, which can be edited by hand.
"""

from __future__ import annotations

from math import pi
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ..core.atlas import AtlasLayout
from ..core.sampler import Filter
from ..core.shadow import unpack_bits
from ..formats.containers.png import encode_png
from ..formats.disk.temporary import temporary_folder
from ..formats.shadow_files import read_shadow_of
from ..scene.nodes import NodeBuilder, Socket, open_material
from ..scene.objects import is_rendered
from ..scene.scratch import find_view_layer
from .material import build_frame_group, load_atlas
from .node_group import build_sample_group, check_previewable

DIRECTION, IRRADIANCE = "RadTex light direction", "RadTex light irradiance"  # names of nodes
_FROM_LEFT = (-0.45, -0.55, 0.7)
_SUNNY = (3.0, 3.0, 3.0)


def own_light(build: NodeBuilder) -> tuple[Socket, Socket]:
    """The vector towards the light, and its irradiance: two nodes that `follow_sun` finds by their names."""
    made = []
    for values, label in ((_FROM_LEFT, DIRECTION), (_SUNNY, IRRADIANCE)):
        made.append(build.combine(*values))
        made[-1].node.name = made[-1].node.label = label
    return made[0], made[1]


def first_sun(scene: bpy.types.Scene) -> bpy.types.Object | None:
    """The scene's first sun by name that renders, if there is one."""
    layer = find_view_layer(scene, None)
    suns = (item for item in layer.objects if item.type == "LIGHT" and item.data.type == "SUN")
    return min((sun for sun in suns if is_rendered(sun, layer)), key=lambda sun: sun.name, default=None)


def follow_sun(material: bpy.types.Material | None, scene: bpy.types.Scene) -> None:
    """Make a material with a light of its own follow the scene's first sun.

    Other materials are left alone.
    """
    if material is not None and material.node_tree is not None:
        follow_sun_in(material.node_tree, scene)


def follow_sun_in(tree: bpy.types.NodeTree, scene: bpy.types.Scene) -> None:
    """`follow_sun` for the node tree of such a material, or a group with its nodes."""
    sun = first_sun(scene)
    if not _forget_sun_in(tree) or sun is None:
        return
    nodes = cast(Any, tree).nodes
    lamp = cast(bpy.types.Light, sun.data)
    exposed = hasattr(lamp, "exposure")  # since Blender 4.5
    for axis in range(3):
        towards = _driver(nodes[DIRECTION].inputs[axis], "z")
        _variable(towards, "z", "OBJECT", sun, f"matrix_world[2][{axis}]")  # column 2: the sun's z axis
        strength = _driver(nodes[IRRADIANCE].inputs[axis], "energy * tint" + " * pow(2, stops)" * exposed)
        _variable(strength, "energy", "LIGHT", lamp, "energy")
        _variable(strength, "tint", "LIGHT", lamp, f"color[{axis}]")
        if exposed:
            _variable(strength, "stops", "LIGHT", lamp, "exposure")


def forget_sun(material: bpy.types.Material) -> bool:
    """Remove a material's drivers of the sun. Returns False for a material without a light of its own."""
    return material.node_tree is not None and _forget_sun_in(material.node_tree)


def _forget_sun_in(tree: bpy.types.NodeTree) -> bool:
    if DIRECTION not in tree.nodes or IRRADIANCE not in tree.nodes:
        return False
    for name in (DIRECTION, IRRADIANCE):
        for socket in tree.nodes[name].inputs:
            socket.driver_remove("default_value")
    return True


def _driver(socket: Any, expression: str) -> bpy.types.Driver:
    driver = socket.driver_add("default_value").driver
    driver.type, driver.expression = "SCRIPTED", expression
    return cast(bpy.types.Driver, driver)


def _variable(driver: bpy.types.Driver, name: str, kind: str, owner: bpy.types.ID, path: str) -> None:
    variable = cast(Any, driver.variables.new())
    variable.name, variable.type = name, "SINGLE_PROP"
    target = variable.targets[0]
    target.id_type, target.id, target.data_path = kind, owner, path


def preview_shadow_material(
    name: str, sidecar: Path, uv_layer: str, scene: bpy.types.Scene, kind: Filter
) -> bpy.types.Material:
    """A white material lit by `scene`'s first sun, with the shadows of the bake `sidecar`.

    The light has one direction: the node DIRECTION holds the vector towards it, and a driver makes it follow
    the sun, if there is one. Raises FormatError for files that cannot be read, InputError for a bake that,
    at one pixel per cell, is larger than a GPU takes.
    """
    image, layout = _spread_out(name, sidecar)
    sampler = build_sample_group(image, layout, kind)
    material, build = open_material(name)
    cast(Any, material).cycles.emission_sampling = "NONE"  # rays see it, but Cycles does not sample it
    uv, frame = build.uv_map(uv_layer), build.group(build_frame_group())
    light, irradiance = own_light(build)
    seen, _ = build.group(sampler, uv, *frame, light)
    upright, towards = build.vector("NORMALIZE", frame[0]), build.vector("NORMALIZE", light)
    cosine = build.math("MAXIMUM", build.vector("DOT_PRODUCT", upright, towards), 0.0)
    arriving = build.vector("SCALE", irradiance, build.math("MULTIPLY", cosine, 1 / pi))
    emission = build.node("ShaderNodeEmission", build.vector("MULTIPLY", seen, arriving))
    build.node("ShaderNodeOutputMaterial", emission.outputs[0])
    build.arrange()
    follow_sun(material, scene)
    return material


def preview_ambient_material(
    name: str, atlas: Path, layout: AtlasLayout, uv_layer: str, half: bool = True
) -> bpy.types.Material:
    """A material whose grey is the ambient visibility in the file `atlas`. Raises as `load_atlas` does."""
    sampler = build_sample_group(load_atlas(atlas, half, data=True), layout, Filter.QUADRILINEAR)
    material, build = open_material(name)
    cast(Any, material).cycles.emission_sampling = "NONE"
    uv, frame = build.uv_map(uv_layer), build.group(build_frame_group())
    _, ambient = build.group(sampler, uv, *frame)
    emission = build.node("ShaderNodeEmission", build.combine(ambient, ambient, ambient))
    build.node("ShaderNodeOutputMaterial", emission.outputs[0])
    build.arrange()
    return material


def _spread_out(name: str, sidecar: Path) -> tuple[bpy.types.Image, AtlasLayout]:
    """Unpack the shadow bits to an image packed in the .blend: one pixel per cell, white if unoccluded."""
    words, facts = read_shadow_of(sidecar)
    layout = AtlasLayout(facts.width, facts.height, facts.bucket)
    check_previewable(layout)
    open_cells = (~unpack_bits(words, facts.bucket)).astype(np.float32)[..., None]
    picture = np.broadcast_to(layout.from_buckets(open_cells), (layout.pixel_height, layout.pixel_width, 3))
    with temporary_folder() as folder:
        path = folder / f"{sidecar.stem}.png"
        path.write_bytes(encode_png(picture[::-1]))
        image = load_atlas(path, data=True)
        image.name = f"{name} shadow"
        image.pack()
        image.filepath_raw = ""  # the temporary file will be gone
    return image, layout
