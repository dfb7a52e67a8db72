# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Odd materials and stages for the fidelity bench, and how near a bake of them comes to Cycles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.report.gbuffer import BakedSurface, CameraRays
from radtex_addon.report.metrics import Picture
from radtex_addon.settings.spec import BakeSpec, Layout, Unwrap
from tests.bench.fidelity.composite import seen_light
from tests.bench.fidelity.method import Baked
from tests.bench.fidelity.methods.layered import Layered
from tests.bench.fidelity.references import blockers, distances
from tests.bench.fidelity.rendering import Behind, Rendering, render
from tests.bench.fidelity.scenes import Stage
from tests.bench.fidelity.scenes.meshes import as_subject, made, mesh_object
from tests.bench.fidelity.scenes.stage import checkered_floor, floor_height, with_cameras

PIXELS, _REFERENCE, _SAMPLES = 96, 64, 4
_VIEW = ((28.0, 24.0),)

Shader = Callable[[Any], Any]  # from a node tree to the socket of a shader in it


def material(name: str, shader: Shader | None, volume: Shader | None = None) -> bpy.types.Material:
    """A material of what the shader makes, or of none."""
    found = bpy.data.materials.new(name)
    if found.node_tree is None:
        found.use_nodes = True
    tree: Any = found.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    for kind, socket in (("Surface", shader), ("Volume", volume)):
        if socket is not None:
            tree.links.new(socket(tree), output.inputs[kind])
    return found


def node(kind: str, **inputs: object) -> Shader:
    """One node; inputs by name, blanks as underscores, or by number; what functions make is linked."""

    def make_node(tree: Any) -> Any:
        new = tree.nodes.new(f"ShaderNode{kind}")
        for key, value in inputs.items():
            socket = new.inputs[int(key[1:])] if key[0] == "_" else new.inputs[key.replace("_", " ")]
            if callable(value):
                tree.links.new(value(tree), socket)
            else:
                socket.default_value = value
        return new.outputs[0]

    return make_node


def output(kind: str, name: str) -> Shader:
    """An output of a node without inputs of interest."""
    return lambda tree: tree.nodes.new(f"ShaderNode{kind}").outputs[name]


def mixed(share: Shader | float, first: Shader, second: Shader) -> Shader:
    """A mix of two shaders."""
    return node("MixShader", _0=share, _1=first, _2=second)


def balls(materials: Sequence[bpy.types.Material | None]) -> bpy.types.Object:
    """The subject: balls in up to two rows, one above the other, each of one of the materials."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=0.45)
    first = made()
    mesh = cast(bpy.types.Mesh, first.data)
    place = np.array([vertex.co for vertex in mesh.vertices])
    faces = sorted(
        tuple(map(int, cast(Any, face).vertices)) for face in mesh.polygons
    )  # Blender's order varies
    bpy.data.objects.remove(first)
    wide = -(-len(materials) // 2) if len(materials) > 3 else len(materials)
    steps = [np.array([k % wide - (wide - 1) / 2, 0, -(k // wide)]) for k in range(len(materials))]
    rows = [place + step for step in steps]
    count = len(place)
    all_faces = [tuple(k * count + v for v in face) for k in range(len(materials)) for face in faces]
    item = as_subject(mesh_object("Row", [tuple(p) for p in np.concatenate(rows)], all_faces, smooth=True))
    built = cast(bpy.types.Mesh, item.data)
    for one in materials:
        cast(Any, built.materials).append(one)
    numbers = np.repeat(np.arange(len(materials), dtype=np.int32), len(faces))
    built.polygons.foreach_set("material_index", numbers)
    return item


def stage_of(
    subject: bpy.types.Object, see_through: bool = False, floor: bool = True, view: Any = _VIEW
) -> Stage:
    """The subject over a floor, and one camera."""
    if floor:
        checkered_floor(floor_height(subject))
    return with_cameras(subject.name, subject, view, (), see_through)


@dataclass(frozen=True, eq=False)
class Seen:
    """A bake and a path-traced picture of the same rays: display values (N, 3), inside the subject's edge.

    `material` (N,): the slot that is met; `light` and `expected` (N, 3) before they are clipped.
    """

    light: Picture
    expected: Picture
    material: Any
    baked: Baked
    picture: Picture
    reference: Picture

    def psnr(self, slot: int | None = None) -> float:
        some = slice(None) if slot is None else self.material == slot
        shown, expected = (np.clip(values[some], 0, 1) ** (1 / 2.2) for values in (self.light, self.expected))
        return float(-10 * np.log10(max(((shown - expected) ** 2).mean(), 1e-9)))

    def energy(self, slot: int | None = None) -> float:
        """Of clipped values, over the reference's."""
        some = slice(None) if slot is None else self.material == slot
        shown, expected = (np.clip(values[some], 0, 1).mean() for values in (self.light, self.expected))
        return float((shown + 1e-3) / (expected + 1e-3))


def looked_at(stage: Stage, folder: Path, texels: int, method: Any = None) -> Seen:
    """Bake a stage, and compare it to Cycles in its only view.

    Blender unwraps it: that takes a tenth of the time of the unwrap that bakes choose by themselves.
    """
    spec = BakeSpec(layout=Layout.LAYERED, texels=texels, samples=_SAMPLES, unwrap=Unwrap.BLENDER)
    baked = (method or Layered(spec)).bake(stage, folder)
    camera = stage.tuning[0]
    data = cast(bpy.types.Camera, camera.data)
    turn = np.array(cast(Any, camera).rotation_euler.to_matrix())
    half = data.sensor_width / 2 / data.lens
    rays = CameraRays.of_camera(np.array(cast(Any, camera.location)), turn, half, PIXELS, 1)
    blocked = distances(blockers(stage), rays)
    surface = BakedSurface(baked.mesh, baked.matrix_world, baked.uv_layer)
    first = surface.gbuffer(rays, blocked)
    behind = None
    if stage.see_through:
        behind = render(stage, camera, Behind(_REFERENCE, 1, pixels=PIXELS))[..., :3]
    values = seen_light(baked, surface, rays, blocked, first, behind)
    reference = render(stage, camera, Rendering(_REFERENCE, 1, alone=False, pixels=PIXELS))[..., :3]
    picture = first.resolve(values)
    slots = np.empty(len(baked.mesh.polygons), dtype=np.int32)
    cast(Any, baked.mesh.polygons).foreach_get("material_index", slots)
    inside = first.eroded
    met = slots[np.maximum(first.triangle, 0)].reshape(PIXELS, PIXELS)
    shown = np.where(first.inside[..., None], picture, reference)
    return Seen(picture[inside], reference[inside], met[inside], baked, shown, reference)
