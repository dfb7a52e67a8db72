# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials that ask where the camera is, and volumes around the object, are named before a bake."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import bpy
import pytest

from radtex_addon.job.checks import check_request
from radtex_addon.scene.checks.camera_checks import camera_materials
from radtex_addon.scene.checks.see_through import volumes_around
from radtex_addon.settings.spec import BakeSpec, Kind
from tests.blender import stage
from tests.blender.stage import material, world


@pytest.fixture
def item() -> bpy.types.Object:
    """A cube whose colour is the distance from the camera, by a node in a group."""
    bpy.context.scene.render.engine = "CYCLES"
    world()
    bpy.ops.mesh.primitive_cube_add()
    cube = cast(bpy.types.Object, bpy.context.object)
    made = material("Fades", "ShaderNodeBsdfDiffuse")
    cast(Any, cube.data).materials.append(made)
    group = cast(Any, bpy.data.node_groups.new("Far", "ShaderNodeTree"))
    group.interface.new_socket("Far", in_out="OUTPUT", socket_type="NodeSocketFloat")
    camera = group.nodes.new("ShaderNodeCameraData")
    group.links.new(camera.outputs["View Distance"], group.nodes.new("NodeGroupOutput").inputs[0])
    tree: Any = made.node_tree
    inside, facing = tree.nodes.new("ShaderNodeGroup"), tree.nodes.new("ShaderNodeLayerWeight")
    inside.node_tree = group
    shader = next(node for node in tree.nodes if node.type == "BSDF_DIFFUSE")
    tree.links.new(inside.outputs[0], shader.inputs["Color"])
    tree.links.new(facing.outputs["Facing"], shader.inputs["Roughness"])
    return cube


def test_a_node_that_feeds_a_material_is_named(item: bpy.types.Object) -> None:
    (line,) = camera_materials(item)
    assert line == (
        f"material 'Fades' of object '{item.name}' takes 'View Distance' of its node 'Camera Data', and a "
        "bake has a camera of its own: feed a fixed value instead"
    )


def test_a_node_that_feeds_nothing_is_not(item: bpy.types.Object) -> None:
    tree: Any = item.material_slots[0].material.node_tree
    inside = next(node for node in tree.nodes if node.type == "GROUP")
    inside.mute = True
    assert camera_materials(item) == []
    inside.mute = False
    tree.links.remove(inside.outputs[0].links[0])
    assert camera_materials(item) == []


def test_bakes_of_what_is_seen_warn(item: bpy.types.Object, tmp_path: Path) -> None:
    def warned(kind: Kind) -> bool:
        spec = BakeSpec(texels=4, bucket=2, samples=1, kind=kind)
        lines = check_request(
            cast(bpy.types.Scene, bpy.context.scene), item.name, spec, tmp_path, False, False
        )
        return any("'View Distance'" in str(line) for line in lines)

    assert warned(Kind.RADIANCE)
    assert not warned(Kind.INCIDENT)


def cube(size: float, place: tuple[float, float, float], volume: bool) -> bpy.types.Object:
    bpy.ops.mesh.primitive_cube_add(size=size, location=place)
    item = bpy.context.object
    assert item is not None
    made = stage.material("m", "ShaderNodeBsdfDiffuse")
    if volume:
        tree = made.node_tree
        output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
        tree.links.new(tree.nodes.new("ShaderNodeVolumePrincipled").outputs[0], output.inputs["Volume"])
    item.data.materials.append(made)
    return item


def test_only_rendered_volumes_that_reach_the_object_are_named() -> None:
    baked = cube(1, (0, 0, 0), volume=True)  # its own volume begins behind its surface
    cube(4, (0.5, 0, 0), volume=True).name = "Fog"
    cube(1, (5, 0, 0), volume=True).name = "Far"
    cube(4, (0, 0, 0), volume=False).name = "Solid"
    hidden = cube(4, (0, 0, 0), volume=True)
    hidden.hide_render = True
    layer = bpy.context.view_layer
    assert layer is not None
    layer.update()
    assert volumes_around(layer, baked) == ["Fog"]
