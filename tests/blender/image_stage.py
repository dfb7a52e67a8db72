# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A box whose material is a texture set of small images, as importers of glTF make them, and its bake."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.sampler import Filter
from radtex_addon.job import bake_object
from radtex_addon.settings.spec import BakeSpec, Layout
from tests.blender import stage

context: Any = bpy.context  # to the stubs, every pointer may be None

NAME, SIDE, UVS, SCENE = "Crate", 64, "Painted", "scene.blend"
SPEC = BakeSpec(layout=Layout.LAYERED, texels=16, samples=2)


def image(name: str, pixels: Floats, colour: bool = False) -> bpy.types.Image:
    """A packed PNG of pixels (H, W, 3) as they are stored, row 0 at the bottom."""
    height, width = pixels.shape[:2]
    made: Any = bpy.data.images.new(name, width, height, alpha=False)
    made.colorspace_settings.name = "sRGB" if colour else "Non-Color"
    made.pixels.foreach_set(np.dstack([pixels, np.ones((height, width))]).astype(np.float32).ravel())
    made.file_format = "PNG"
    made.pack()
    return cast(bpy.types.Image, made)


def squares(low: tuple[float, ...], high: tuple[float, ...], cells: int = 8) -> Floats:
    """A chequer of two colours, finer than the bake's texels."""
    row, column = np.indices((SIDE, SIDE)) * cells // SIDE
    return np.where(((row + column) % 2 == 0)[..., None], low, high).astype(np.float32)


def texture_set(name: str = "Painted", shift: float = 0.0) -> bpy.types.Material:
    """A material of colour, metal and roughness in one, and normal images."""
    made: Any = bpy.data.materials.new(name)
    if made.node_tree is None:
        made.use_nodes = True
    tree = made.node_tree
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    bump = squares((0.5, 0.5, 1.0), (0.62, 0.44, 0.97), 4)
    pictures = {
        "colour": image(f"{name} colour", squares((0.75, 0.45, 0.35 + shift), (0.4, 0.5, 0.7)), colour=True),
        "metal": image(f"{name} metal", squares((1.0, 0.4, 0.0), (1.0, 0.4, 1.0), 2)),
        "normal": image(f"{name} normal", bump),
    }
    nodes = {}
    for key, picture in pictures.items():
        nodes[key] = tree.nodes.new("ShaderNodeTexImage")
        nodes[key].name, nodes[key].image = key, picture
    parts, normal = tree.nodes.new("ShaderNodeSeparateColor"), tree.nodes.new("ShaderNodeNormalMap")
    tree.links.new(nodes["colour"].outputs["Color"], shader.inputs["Base Color"])
    tree.links.new(nodes["metal"].outputs["Color"], parts.inputs["Color"])
    tree.links.new(parts.outputs["Blue"], shader.inputs["Metallic"])
    tree.links.new(parts.outputs["Green"], shader.inputs["Roughness"])
    tree.links.new(nodes["normal"].outputs["Color"], normal.inputs["Color"])
    tree.links.new(normal.outputs["Normal"], shader.inputs["Normal"])
    return cast(bpy.types.Material, made)


def crate(*materials: bpy.types.Material) -> Any:
    """A box on a UV layer of its own, one side of it of the second material, if there are two.

    The object has a scale, which its normal map must not show.
    """
    bpy.ops.mesh.primitive_cube_add(size=0.5, location=(0.3, -0.2, 0.5), rotation=(0.1, 0.2, 0.4))
    box = context.object
    box.scale = (4.0, 4.0, 4.0)
    box.name = NAME
    box.data.uv_layers[0].name = UVS
    for material in materials:
        box.data.materials.append(material)
    if len(materials) > 1:
        box.data.polygons[0].material_index = 1
    return box


def bake_sheet(folder: Path) -> None:
    """Bake a sheet that is seen from both sides, and save the scene beside."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    stage.hdri(stage.world())
    bpy.ops.mesh.primitive_plane_add(size=2, rotation=(0.9, 0.3, 0.2))
    sheet = context.object
    sheet.name = NAME
    sheet.data.uv_layers[0].name = UVS
    sheet.data.materials.append(texture_set())
    bake_object(context.scene, NAME, SPEC, folder, preview=Filter.QUADRILINEAR)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / SCENE))


def bake_pair(folder: Path) -> None:
    """Bake two boxes, each of images on a UV layer of its own name, in one atlas."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    stage.hdri(stage.world())
    names = []
    for number, place in enumerate([(0, 0, 0), (2.2, 0.3, 0)]):
        bpy.ops.mesh.primitive_cube_add(size=2, location=place)
        box = context.object
        box.name = f"{NAME} {number}"
        box.data.uv_layers[0].name = f"{UVS} {number}"
        box.data.materials.append(texture_set(f"Set {number}", 0.2 * number))
        names.append(box.name)
    spec = replace(SPEC, objects=tuple(names), texels=32)
    bake_object(context.scene, NAME, spec, folder, preview=Filter.QUADRILINEAR)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / SCENE))


def bake_behind_pane(folder: Path) -> None:
    """Bake a box between two half clear panes, which are one object, each of images, in one atlas.

    The middle of both panes is further from the cameras than the box's.
    """
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    stage.hdri(stage.world())
    crate(texture_set())
    bpy.ops.mesh.primitive_plane_add(size=3, location=(1.2, -1.6, 1.6), rotation=(1.0, 0, 0.6))
    front = context.object
    bpy.ops.mesh.primitive_plane_add(size=0.5, location=(-3, 9, 0.5), rotation=(1.0, 0, 0.6))
    front.select_set(True)
    bpy.ops.object.join()
    pane = context.object
    pane.name = "A Pane"
    pane.data.uv_layers[0].name = UVS
    clear: Any = texture_set("Clear")
    nodes = clear.node_tree.nodes
    colour = nodes["colour"].image
    values = np.empty(4 * SIDE * SIDE, np.float32)
    colour.pixels.foreach_get(values)
    values[3::4] = 0.5
    nodes["colour"].image = bpy.data.images.new("Clear colour", SIDE, SIDE, alpha=True)
    nodes["colour"].image.pixels.foreach_set(values)
    nodes["colour"].image.pack()
    shader = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    clear.node_tree.links.new(nodes["colour"].outputs["Alpha"], shader.inputs["Alpha"])
    pane.data.materials.append(clear)
    spec = replace(SPEC, objects=("A Pane", NAME), texels=32)
    bake_object(context.scene, "Both", spec, folder, preview=Filter.QUADRILINEAR)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / SCENE))


def bake_crate(folder: Path, mixed: bool = False) -> None:
    """Bake it and save the scene beside; `mixed` gives a side a material that is no texture set."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    stage.hdri(stage.world())
    plain = stage.material("Plain", "ShaderNodeBsdfDiffuse", Color=(0.3, 0.6, 0.2, 1))
    crate(*([texture_set(), plain] if mixed else [texture_set()]))
    bake_object(context.scene, NAME, SPEC, folder, preview=Filter.QUADRILINEAR)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / SCENE))
