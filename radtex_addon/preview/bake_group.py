# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished bake as a node group of its own, and the material around it, in the open file.

The group has no inputs: it reads the baked UV layer and the frame from the mesh, so that it goes into any
material of an object with the bake's mesh. Outputs: Shader, as the preview shows it; Color, the light
towards the viewer, premultiplied; and Alpha. A group that was made before is replaced wherever it is used,
and a material that was made before stays as it is, with the user's changes.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, TypeAlias, cast

import bpy

from ..formats.sidecar import part_in
from ..formats.sidecar_file import AnySidecar, SidecarFile, opened
from ..scene.kept_images import kept_number
from .lit_material import follow_sun_in
from .load import PREVIEW_TAG, load_baked_meshes, remove_unused
from .save import MATERIAL_PREFIX

_KEPT = ("name", "label", "location", "width")  # of what all nodes have
MADE = "radtex_bake"  # custom property of groups and materials made here: their name and the bake's sidecar
OSL_SUFFIX = " (OSL)"
_OUTPUTS = {"Shader": "NodeSocketShader", "Color": "NodeSocketColor", "Alpha": "NodeSocketFloat"}
_NUMBER = re.compile(r"\.\d{3,}$")  # what Blender adds to a name that is taken

ScriptNode: TypeAlias = Callable[[bpy.types.NodeTree], bpy.types.Node]


def load_with_groups(
    sidecar: AnySidecar, names: Sequence[str], scene: bpy.types.Scene, script: ScriptNode | None = None
) -> list[bpy.types.Mesh]:
    """Load the bake's meshes of the objects `names`, whose materials show it by node groups made here.

    `script` adds a Script node that looks the bake up in the place of native nodes. Light that follows the
    sun follows that of `scene`. Raises as `load_baked_meshes` and `script` do; then nothing has changed.
    """
    file = opened(sidecar)
    meshes = load_baked_meshes(file, names)
    try:
        worn: list[Any] = [material for mesh in meshes for material in mesh.materials]
        shown = [
            one for one in dict.fromkeys(worn) if one is not None and one.name.startswith(MATERIAL_PREFIX)
        ]
        titles = {material: _title(material, shown, file, script is not None) for material in shown}
        groups = {material: _group_of(material, scene, script) for material in shown}
    except BaseException:
        bpy.data.batch_remove(meshes)
        remove_unused()
        raise
    for material in shown:
        made = f"{titles[material]} of {file.path.absolute()}"
        group = _settled_group(groups[material], titles[material], made)
        settled = _settled_material(material, group, titles[material], made)
        for mesh in meshes:
            for index, other in enumerate(mesh.materials):
                if other == material:
                    mesh.materials[index] = settled
    for mesh in meshes:
        del cast(Any, mesh)[PREVIEW_TAG]  # the caller's from now on
    remove_unused()
    return meshes


def made_materials(meshes: Sequence[bpy.types.Mesh]) -> list[bpy.types.Material]:
    """The meshes' materials that were made here, each once."""
    worn = dict.fromkeys(material for mesh in meshes for material in cast(Any, mesh).materials)
    return [material for material in worn if material is not None and MADE in material]


def group_in(material: bpy.types.Material) -> bpy.types.NodeTree | None:
    """The bake's node group in a material; None if the user took it out."""
    nodes = () if material.node_tree is None else material.node_tree.nodes
    trees = (node.node_tree for node in nodes if isinstance(node, bpy.types.ShaderNodeGroup))
    return next((tree for tree in trees if tree is not None and MADE in cast(Any, tree)), None)


def _title(
    material: bpy.types.Material, loaded: Sequence[bpy.types.Material], file: SidecarFile, is_script: bool
) -> str:
    """The name of a bake's group and material: its file's, or for one of several parts the part's."""
    title = file.path.name.removesuffix(".json")
    if part_in(file.facts) is not None:
        plain = _NUMBER.sub("", material.name)
        taken: Any = bpy.data.materials.get(plain)
        name = material.name if taken is None or taken in loaded else plain
        title = f"{name.removeprefix(MATERIAL_PREFIX)}.{file.facts.text('kind')}"
    elif number := kept_number(material):
        title = f"{title}.{number}"
    return title + OSL_SUFFIX * is_script


def _group_of(
    material: bpy.types.Material, scene: bpy.types.Scene, script: ScriptNode | None
) -> bpy.types.ShaderNodeTree:
    """A new node group with the nodes of a preview's material."""
    group = cast(bpy.types.ShaderNodeTree, bpy.data.node_groups.new("RadTex Bake", "ShaderNodeTree"))
    cast(Any, group)[PREVIEW_TAG] = True
    for name, kind in _OUTPUTS.items():
        cast(Any, group.interface).new_socket(name, in_out="OUTPUT", socket_type=kind)
    source = cast(bpy.types.NodeTree, material.node_tree)
    nodes = list(source.nodes)
    final: Any = next(node for node in nodes if node.bl_idname == "ShaderNodeOutputMaterial")
    copies = copy_nodes([node for node in nodes if node != final], source, group)
    output: Any = group.nodes.new("NodeGroupOutput")
    output.location = final.location
    output.inputs["Alpha"].default_value = 1.0
    wanted = {"Shader": final.inputs["Surface"].links[0].from_socket, **_light_and_alpha(nodes)}
    for name, socket in wanted.items():
        group.links.new(same_socket(socket, copies), output.inputs[name])
    if script is not None:
        _look_up_by_script(group, script)
    follow_sun_in(group, scene)
    return group


def _light_and_alpha(nodes: Sequence[bpy.types.Node]) -> dict[str, Any]:
    """What the emission's colour comes from, and how opaque the surface is where it is not whole."""
    found: dict[str, Any] = {}
    for node in cast("Sequence[Any]", nodes):
        if node.bl_idname == "ShaderNodeEmission":
            found["Color"] = node.inputs["Color"].links[0].from_socket
        elif node.bl_idname == "ShaderNodeBsdfTransparent":
            clear = node.inputs["Color"].links[0].from_node  # 1 - alpha
            found["Alpha"] = clear.inputs[1].links[0].from_socket
    return found


def _look_up_by_script(group: bpy.types.NodeTree, script: ScriptNode) -> None:
    """Replace the group that samples the bake by a Script node with sockets of the same names."""
    groups = (node for node in group.nodes if isinstance(node, bpy.types.ShaderNodeGroup))
    sampler: Any = next(node for node in groups if {"Color", "Alpha"} <= set(node.outputs.keys()))
    node: Any = script(group)
    node.location, node.width = sampler.location, sampler.width
    node.script.use_fake_user = False
    node.script[PREVIEW_TAG] = True
    for socket in sampler.inputs:
        for link in list(socket.links):
            if socket.name in node.inputs:
                group.links.new(link.from_socket, node.inputs[socket.name])
    for socket in sampler.outputs:
        for link in list(socket.links):
            group.links.new(node.outputs[socket.name], link.to_socket)
    group.nodes.remove(sampler)


def _settled_group(group: bpy.types.ShaderNodeTree, title: str, made: str) -> bpy.types.ShaderNodeTree:
    """Give a new group its name; it replaces the one that was `made` of the same bake before."""
    earlier = _made_before(bpy.data.node_groups, made)
    if earlier is not None:
        _take_over_asset(earlier, group)
        earlier.user_remap(group)
        bpy.data.node_groups.remove(earlier)
    group.name, cast(Any, group)[MADE] = title, made
    return group


def _settled_material(
    material: bpy.types.Material, group: bpy.types.ShaderNodeTree, title: str, made: str
) -> bpy.types.Material:
    """The material that was `made` of the same bake before and shows the group, or else this one, as such."""
    earlier = _made_before(bpy.data.materials, made)
    if earlier is not None and group_in(earlier) == group:
        return cast(bpy.types.Material, earlier)
    tree = cast(bpy.types.NodeTree, material.node_tree)
    tree.nodes.clear()
    node: Any = tree.nodes.new("ShaderNodeGroup")
    node.node_tree, node.width, node.label = group, 240, title
    output: Any = tree.nodes.new("ShaderNodeOutputMaterial")
    output.location.x = 320
    tree.links.new(node.outputs["Shader"], output.inputs["Surface"])
    material.name, cast(Any, material)[MADE] = title, made
    return material


def _made_before(blocks: Any, made: str) -> Any:
    named: Iterator[Any] = (block for block in blocks if block.get(MADE) == made and block.library is None)
    return next(named, None)


def _take_over_asset(earlier: Any, group: Any) -> None:
    """Make a group an asset as the earlier one was, with its catalog, description and tags."""
    if earlier.asset_data is None:
        return
    group.asset_mark()
    for name in ("catalog_id", "description", "author"):
        setattr(group.asset_data, name, getattr(earlier.asset_data, name))
    for tag in earlier.asset_data.tags:
        group.asset_data.tags.new(tag.name, skip_if_exists=True)


def copy_nodes(
    nodes: Iterable[bpy.types.Node], source: bpy.types.NodeTree, target: bpy.types.NodeTree
) -> dict[bpy.types.Node, bpy.types.Node]:
    """Copy some nodes of `source`, and the links among them, into `target`. Returns the copies.

    Nodes whose sockets Blender makes only later, as Script nodes' are, are not for this.
    """
    copies = {node: _copy(node, target) for node in nodes}
    for link in cast("Iterable[Any]", source.links):
        if link.from_node in copies and link.to_node in copies:
            start = copies[link.from_node].outputs[_place(link.from_node.outputs, link.from_socket)]
            end = copies[link.to_node].inputs[_place(link.to_node.inputs, link.to_socket)]
            target.links.new(start, end)
    return copies


def same_socket(socket: Any, copies: dict[bpy.types.Node, bpy.types.Node]) -> bpy.types.NodeSocket:
    """The output of a copied node that an output of the original became."""
    return copies[socket.node].outputs[_place(socket.node.outputs, socket)]


def _place(sockets: Any, wanted: Any) -> int:
    return next(number for number, socket in enumerate(sockets) if socket == wanted)


def _copy(node: bpy.types.Node, target: bpy.types.NodeTree) -> bpy.types.Node:
    copy = target.nodes.new(node.bl_idname)
    common = set(bpy.types.Node.bl_rna.properties.keys())
    own = [each for each in node.bl_rna.properties if each.identifier not in common and not each.is_readonly]
    for name in (*_KEPT, *(each.identifier for each in own)):
        setattr(copy, name, getattr(node, name))
    for before, after in zip(cast(Any, node.inputs), cast(Any, copy.inputs), strict=True):
        if hasattr(before, "default_value"):
            after.default_value = before.default_value
    return copy
