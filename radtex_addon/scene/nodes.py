# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Node trees written like formulas.

    build = NodeBuilder(material.node_tree)
    x, y, z = build.separate(build.vector("NORMALIZE", build.geometry("Incoming")))
    r = build.math("SQRT", build.math("ADD", z, 1.0))

Every method makes one node and returns its output sockets; an operand is a socket, a number or a tuple.
"""

from __future__ import annotations

from typing import Any, TypeAlias, cast

import bpy

Socket: TypeAlias = bpy.types.NodeSocket
Operand: TypeAlias = Socket | float | tuple[float, ...]

_SCALARS = frozenset({"DOT_PRODUCT", "LENGTH", "DISTANCE"})  # vector operations whose result is a number
_SOCKET_TYPES = {"VALUE": "NodeSocketFloat", "VECTOR": "NodeSocketVector", "RGBA": "NodeSocketColor"}


class NodeBuilder:
    """Adds nodes to a shader tree; at the end `arrange` lays them out."""

    def __init__(self, tree: bpy.types.NodeTree) -> None:
        self.tree = tree

    def node(self, kind: str, *operands: Operand, label: str = "", **properties: object) -> bpy.types.Node:
        """A node of the type `kind` with `properties` set and `operands` fed to its first inputs."""
        node = self.tree.nodes.new(kind)
        node.label = label
        for name, value in properties.items():
            setattr(node, name, value)
        for socket, operand in zip(node.inputs, operands, strict=False):
            self.feed(socket, operand)
        return node

    def feed(self, socket: Socket, operand: Operand) -> None:
        """Link a socket, or write a constant, to an input; a number fed to a vector fills it."""
        if isinstance(operand, bpy.types.NodeSocket):
            self.tree.links.new(operand, socket)
            return
        if socket.type == "VECTOR" and not isinstance(operand, tuple):
            operand = (operand, operand, operand)
        socket.default_value = operand  # type: ignore[attr-defined]  # every socket that takes operands has one

    def math(self, operation: str, *operands: Operand, label: str = "") -> Socket:
        """A number by a Math node: ADD, MULTIPLY_ADD, SQRT, FLOOR, LESS_THAN and so on."""
        return self.node("ShaderNodeMath", *operands, operation=operation, label=label).outputs[0]

    def vector(self, operation: str, *operands: Operand, label: str = "") -> Socket:
        """A vector by a Vector Math node (SCALE: vector, factor); a number by DOT_PRODUCT and LENGTH."""
        node = self.node("ShaderNodeVectorMath", operation=operation, label=label)
        inputs = [node.inputs["Vector"], node.inputs["Scale"]] if operation == "SCALE" else list(node.inputs)
        for socket, operand in zip(inputs, operands, strict=False):
            self.feed(socket, operand)
        return node.outputs["Value" if operation in _SCALARS else "Vector"]

    def value(self, number: float, label: str = "") -> Socket:
        """A Value node: a number that may be changed or animated later."""
        found = self.node("ShaderNodeValue", label=label).outputs[0]
        found.default_value = number  # type: ignore[attr-defined]  # this node's has one
        return found

    def combine(self, x: Operand, y: Operand, z: Operand = 0.0) -> Socket:
        """Three numbers to a vector."""
        return self.node("ShaderNodeCombineXYZ", x, y, z).outputs[0]

    def separate(self, vector: Operand) -> tuple[Socket, Socket, Socket]:
        """A vector's components."""
        x, y, z = self.node("ShaderNodeSeparateXYZ", vector).outputs
        return x, y, z

    def mix(
        self, factor: Operand, at_zero: Operand, at_one: Operand, kind: str = "VECTOR", blend: str = "MIX"
    ) -> Socket:
        """Mix of two vectors, or of another `kind` (RGBA, FLOAT); a factor of 0 or 1 selects one of them.

        For colours there are other `blend` types: LIGHTEN is the larger of the two.
        """
        node = self.node("ShaderNodeMix", data_type=kind, clamp_factor=False, blend_type=blend)
        sockets = [socket for socket in node.inputs if socket.enabled]
        for socket, operand in zip(sockets, (factor, at_zero, at_one), strict=True):
            self.feed(socket, operand)
        return next(socket for socket in node.outputs if socket.enabled)

    def image(
        self, image: bpy.types.Image, uv: Operand, interpolation: str = "Closest", label: str = ""
    ) -> tuple[Socket, Socket]:
        """Colour and alpha of an image at `uv`, its edge texels repeated outside."""
        node = self.node(
            "ShaderNodeTexImage",
            uv,
            image=image,
            interpolation=interpolation,
            extension="EXTEND",
            label=label,
        )
        return node.outputs["Color"], node.outputs["Alpha"]

    def uv_map(self, name: str = "") -> Socket:
        """A UV layer by name; the active render layer if the name is empty."""
        return self.node("ShaderNodeUVMap", uv_map=name).outputs["UV"]

    def geometry(self, output: str) -> Socket:
        """Geometry node: Position, Normal, Incoming … in world space."""
        return self.node("ShaderNodeNewGeometry").outputs[output]

    def attribute(self, name: str, output: str = "Vector") -> Socket:
        """A mesh attribute's `Vector`, `Color`, `Fac` or `Alpha`."""
        return self.node("ShaderNodeAttribute", attribute_type="GEOMETRY", attribute_name=name).outputs[
            output
        ]

    def transform(self, vector: Operand, kind: str, source: str = "OBJECT", target: str = "WORLD") -> Socket:
        """A vector of `kind` POINT, VECTOR or NORMAL, from WORLD, OBJECT or CAMERA space to another."""
        node = self.node(
            "ShaderNodeVectorTransform", vector, vector_type=kind, convert_from=source, convert_to=target
        )
        return node.outputs[0]

    def group(self, tree: bpy.types.NodeTree, *operands: Operand, label: str = "") -> tuple[Socket, ...]:
        """A node group's outputs; operands in the order of its inputs, the rest keep their defaults."""
        return tuple(self.node("ShaderNodeGroup", *operands, node_tree=tree, label=label).outputs)

    def arrange(self, column: float = 180.0, row: float = 170.0) -> None:
        """Lay the nodes out by depth, sources on the left, so that the tree can be read."""
        rows: dict[int, int] = {}
        for node, depth in self._depths().items():
            node.location = (depth * column, -rows.get(depth, 0) * row)
            rows[depth] = rows.get(depth, 0) + 1

    def _depths(self) -> dict[bpy.types.Node, int]:
        """Length of the longest chain of links to each node; nodes must be made after their sources."""
        depths = dict.fromkeys(self.tree.nodes, 0)
        sources: dict[bpy.types.Node, list[bpy.types.Node]] = {node: [] for node in depths}
        for link in self.tree.links:
            if link.from_node and link.to_node:
                sources[link.to_node].append(link.from_node)
        for node in depths:
            depths[node] = max((depths[source] + 1 for source in sources[node]), default=0)
        return depths


def operand_of(socket: Any) -> Operand:
    """What feeds an input: the socket linked to it, or its own value, a colour without its alpha."""
    if socket.is_linked:
        return cast(Socket, socket.links[0].from_socket)
    value = socket.default_value
    return float(value) if socket.type == "VALUE" else tuple(value)[:3]


def open_material(name: str) -> tuple[bpy.types.Material, NodeBuilder]:
    """A new material without nodes, and the builder that gives it some."""
    material = bpy.data.materials.new(name)
    return material, NodeBuilder(_emptied(material))


def open_world(name: str) -> tuple[bpy.types.World, NodeBuilder]:
    """A new world without nodes, and the builder that gives it some."""
    world = bpy.data.worlds.new(name)
    return world, NodeBuilder(_emptied(world))


def _emptied(owner: bpy.types.Material | bpy.types.World) -> bpy.types.NodeTree:
    if owner.node_tree is None:  # Blender 4.5; later versions always have a node tree
        owner.use_nodes = True
    tree = cast(bpy.types.NodeTree, owner.node_tree)
    tree.nodes.clear()
    return tree


def open_group(name: str, **inputs: str) -> tuple[NodeBuilder, list[Socket]]:
    """A new node group: its builder, and its inputs (name to Vector, Float or Color) as seen from inside."""
    tree = cast(bpy.types.NodeTree, bpy.data.node_groups.new(name, "ShaderNodeTree"))
    interface = cast(Any, tree.interface)  # the stubs lack socket types
    for socket, kind in inputs.items():
        interface.new_socket(socket, in_out="INPUT", socket_type=f"NodeSocket{kind}")
    build = NodeBuilder(tree)
    if not inputs:
        return build, []
    return build, list(build.node("NodeGroupInput").outputs)[: len(inputs)]


def close_group(build: NodeBuilder, **outputs: Socket) -> bpy.types.ShaderNodeTree:
    """Finish a group that `open_group` began: name its outputs and lay it out."""
    interface = cast(Any, build.tree.interface)
    for name, source in outputs.items():
        interface.new_socket(name, in_out="OUTPUT", socket_type=_SOCKET_TYPES[source.type])
    build.node("NodeGroupOutput", *outputs.values())
    build.arrange()
    return cast(bpy.types.ShaderNodeTree, build.tree)
