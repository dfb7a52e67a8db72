# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces that let through what is behind them, captured alone: their alpha, and light multiplied by it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import pytest

from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats
from radtex_addon.core.hemisphere import square_to_direction
from radtex_addon.cycles.path_ends import Body
from radtex_addon.cycles.sampling import capture_samples
from radtex_addon.forms.layered.capture.material_maps import capture_maps
from radtex_addon.forms.layered.capture.opacity import find_alpha_map
from radtex_addon.forms.layered.capture.surface_alone import surface_alone
from radtex_addon.scene.mesh.copy import baked_mesh
from radtex_addon.scene.mesh.evaluated import evaluate
from radtex_addon.scene.mesh.panes import Panes, find_panes
from radtex_addon.scene.scratch import scene_copied, scratch_scene
from tests.bench.fidelity.scenes.meshes import made as last_made
from tests.blender.stage import material, plan_of, world

pytestmark = pytest.mark.one_blender
_COLOUR = (0.8, 0.4, 0.2)
_CELLS = 8


def _half_clear() -> bpy.types.Material:
    """Principled, of alpha 0.5, within a node group."""
    made = material("Half", "ShaderNodeBsdfDiffuse")
    group = cast(Any, bpy.data.node_groups.new("Cloth", "ShaderNodeTree"))
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    inner = group.nodes.new("ShaderNodeBsdfPrincipled")
    for name, value in (("Base Color", (*_COLOUR, 1)), ("Specular IOR Level", 0.0), ("Alpha", 0.5)):
        inner.inputs[name].default_value = value
    group.links.new(inner.outputs[0], group.nodes.new("NodeGroupOutput").inputs[0])
    tree: Any = made.node_tree
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    tree.links.new(node.outputs[0], tree.get_output_node("CYCLES").inputs["Surface"])
    return made


def _mixed(name: str, clear: tuple[float, float, float], edge: float | None) -> bpy.types.Material:
    """Diffuse beyond `edge` along u, Transparent of a colour before it; half of each everywhere if None."""
    made = material(name, "ShaderNodeBsdfDiffuse", Color=(*_COLOUR, 1))
    tree: Any = made.node_tree
    output = tree.get_output_node("CYCLES").inputs["Surface"]
    diffuse = output.links[0].from_socket
    transparent, mix = tree.nodes.new("ShaderNodeBsdfTransparent"), tree.nodes.new("ShaderNodeMixShader")
    transparent.inputs["Color"].default_value = (*clear, 1)
    if edge is None:
        mix.inputs[0].default_value = 0.5
    else:
        above = tree.nodes.new("ShaderNodeMath")
        above.operation = "GREATER_THAN"
        above.inputs[1].default_value = edge
        place = tree.nodes.new("ShaderNodeSeparateXYZ")
        tree.links.new(tree.nodes.new("ShaderNodeTexCoord").outputs["UV"], place.inputs[0])
        tree.links.new(place.outputs[0], above.inputs[0])
        tree.links.new(above.outputs[0], mix.inputs[0])
    tree.links.new(transparent.outputs[0], mix.inputs[1])
    tree.links.new(diffuse, mix.inputs[2])
    tree.links.new(mix.outputs[0], output)
    return made


@pytest.fixture
def quads() -> bpy.types.Object:
    """Quads side by side in a white world, a bright card behind them: one of them is cut out in half."""
    bpy.context.scene.render.engine = "CYCLES"
    world()
    mesh = bpy.data.meshes.new("Quads")
    edges = [0.0, 1, 3, 4, 5]
    place = [(x, y, 0.0) for x in edges for y in (0.0, 1.0)]
    mesh.from_pydata(place, [], [(2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1) for k in range(4)])
    layer: Any = mesh.uv_layers.new(name="UVMap")
    corners = np.array([place[loop.vertex_index] for loop in mesh.loops])
    layer.data.foreach_set("uv", (corners[:, :2] / (5, 1)).ravel())
    for made in (
        _half_clear(),
        _mixed("Cut out", (1, 1, 1), edge=0.4),
        _mixed("Tinted", (1, 0.5, 0.3), edge=None),
        material("Opaque", "ShaderNodeBsdfDiffuse", Color=(*_COLOUR, 1)),
    ):
        mesh.materials.append(made)
    mesh.polygons.foreach_set("material_index", np.arange(4, dtype=np.int32))
    item = bpy.data.objects.new("Quads", mesh)
    bpy.context.scene.collection.objects.link(item)
    bpy.ops.mesh.primitive_plane_add(size=20, location=(0, 0, -1))
    bpy.context.object.data.materials.append(
        material("Glow", "ShaderNodeEmission", Color=(1, 0, 1, 1), Strength=20)
    )
    return item


def _plan(cells: int) -> CapturePlan:
    """In each quad's middle, but in both halves of the one that is cut out."""
    place = np.array([(x, 0.5, 0.0) for x in (0.5, 1.5, 2.5, 3.5, 4.5)])
    return plan_of(place, np.tile([0.0, 0, 1], (5, 1)), cells)


def _baked_copy(item: bpy.types.Object) -> bpy.types.Mesh:
    """A copy of the mesh that renders by a UV layer of its own, on which all lies at the origin."""
    mesh = cast(bpy.types.Mesh, cast(bpy.types.ID, item.data).copy())
    layer: Any = mesh.uv_layers.new(name="Baked", do_init=False)
    layer.active_render = True
    return mesh


def _captured(item: bpy.types.Object, folder: Path) -> tuple[Floats, Floats, Floats]:
    """The quads' alpha (5,), diffuse colour (5, 3), and mean light (5, 3)."""
    with scratch_scene(cast(bpy.types.Scene, bpy.context.scene)) as scratch, surface_alone([item]) as clear:
        flat, body = _plan(1), Body(item, _baked_copy(item), np.eye(4))
        alpha = find_alpha_map(scratch, [body], clear, flat, 1, folder)
        assert alpha is not None
        with scene_copied(scratch) as copy:
            colour = capture_maps(copy, flat, 1, folder)["diffuse"]
        with scene_copied(scratch) as copy:
            unseen = np.zeros((5, _CELLS, _CELLS), dtype=bool)
            light = finished(capture_samples(copy, _plan(_CELLS), unseen, 1, folder))
    shown = light.diffuse.astype(float) + light.mirrored + light.through
    return alpha.ravel(), colour.reshape(-1, 3), shown.mean(axis=1)


def test_a_surface_is_seen_alone_multiplied_by_its_alpha(quads: bpy.types.Object, tmp_path: Path) -> None:
    alpha, colour, light = _captured(quads, tmp_path)
    expected = np.array([0.5, 0.0, 1.0, 1 - 0.5 * (1 + 0.5 + 0.3) / 3, 1.0])
    assert alpha == pytest.approx(expected, abs=2e-3)
    own = np.array([0.5, 0.0, 1.0, 0.5, 1.0])[:, None] * _COLOUR
    assert colour == pytest.approx(own, rel=0.02, abs=2e-3)
    assert light == pytest.approx(own, rel=0.1, abs=4e-3)  # in a white world; nothing of what is behind


def test_the_object_has_its_own_materials_afterwards(quads: bpy.types.Object) -> None:
    before = [slot.material for slot in quads.material_slots]
    with surface_alone([quads]) as clear:
        during = [slot.material for slot in quads.material_slots]
        assert [a == b for a, b in zip(before, during, strict=True)] == [False, False, False, True]
        assert set(clear) == set(during[:3])
    assert [slot.material for slot in quads.material_slots] == before
    quads.material_slots[0].material = unknown = material("Unknown", "ShaderNodeHoldout")
    with surface_alone([quads]) as clear:
        assert quads.material_slots[0].material == unknown, "nobody knows its transparency"
        assert len(clear) == 2


def test_light_comes_through_to_others_as_before(quads: bpy.types.Object, tmp_path: Path) -> None:
    bpy.ops.mesh.primitive_plane_add(size=0.5, location=(0.5, 0.5, -0.02))
    bpy.context.object.data.materials.append(material("White", "ShaderNodeBsdfDiffuse", Color=(1, 1, 1, 1)))

    def shown() -> float:
        with scratch_scene(cast(bpy.types.Scene, bpy.context.scene)) as scratch:
            plan = plan_of(np.array([[0.5, 0.5, -0.02]]), np.array([[0.0, 0, 1]]), _CELLS)
            unseen = np.zeros((1, _CELLS, _CELLS), dtype=bool)
            return float(finished(capture_samples(scratch, plan, unseen, 1, tmp_path)).diffuse.mean())

    before = shown()
    with surface_alone([quads]):
        assert shown() == pytest.approx(before, rel=1e-3)
    quads.material_slots[0].material = quads.material_slots[3].material
    assert shown() < 0.8 * before


def _glass(roughness: float = 0.0, kind: str = "ShaderNodeBsdfPrincipled") -> bpy.types.Material:
    white = (1.0, 1.0, 1.0, 1.0)
    principled = {"Transmission_Weight": 1.0, "Base_Color": white}
    more: dict[str, Any] = principled if kind == "ShaderNodeBsdfPrincipled" else {"Color": white}
    return material("Glass", kind, IOR=1.5, Roughness=roughness, **more)


def _slab(made: bpy.types.Material, thick: float = 0.02, floor: bool = True) -> bpy.types.Object:
    """A slab of 2 x 1 at the origin; `floor`: large, black, and not far below; a ceiling above."""
    bpy.context.scene.render.engine = "CYCLES"
    world()
    black = material("Black", "ShaderNodeBsdfDiffuse", Color=(0, 0, 0, 1))
    for height in (-1, 2) if floor else ():
        bpy.ops.mesh.primitive_plane_add(size=40, location=(0, 0, height))
        last_made().data.materials.append(black)
        last_made().visible_glossy = False
    bpy.ops.mesh.primitive_cube_add(size=1, location=(0, 0, 0), scale=(2, 1, thick))
    slab = last_made()
    slab.data.materials.append(made)
    bpy.context.view_layer.update()
    return slab


def _panes_of(scratch: bpy.types.Scene, item: bpy.types.Object) -> tuple[Body, Panes]:
    """The object as a body, of triangles, and its panes."""
    mesh = evaluate(scratch, item)
    body = Body(item, baked_mesh(mesh, np.zeros((len(mesh.triangles), 3, 2), np.float32)), mesh.matrix_world)
    return body, find_panes(scratch, [item], [mesh])[0]


def _are_panes(item: bpy.types.Object) -> bool:
    with scratch_scene(cast(bpy.types.Scene, bpy.context.scene)) as scratch:
        found = _panes_of(scratch, item)[1]
    assert found <= {slot.material for slot in item.material_slots}
    return bool(found)


@pytest.mark.parametrize("kind", ["ShaderNodeBsdfPrincipled", "ShaderNodeBsdfGlass"])
def test_a_flat_slab_of_glass_above_a_floor_is_a_pane(kind: str) -> None:
    assert _are_panes(_slab(_glass(kind=kind)))


def test_what_bends_or_blurs_what_is_behind_is_no_pane() -> None:
    assert not _are_panes(_slab(_glass(roughness=0.3)))
    assert not _are_panes(_slab(_glass(), thick=0.5))
    assert not _are_panes(_slab(material("Plastic", "ShaderNodeBsdfPrincipled")))
    bpy.ops.mesh.primitive_uv_sphere_add(radius=1)
    bottle = last_made()
    bottle.data.materials.append(_glass())
    cast(Any, bottle.modifiers.new("Thin", "SOLIDIFY")).thickness = 0.01
    assert not _are_panes(bottle)


def test_a_window_before_the_open_is_no_pane() -> None:
    assert not _are_panes(_slab(_glass(), floor=False))


def test_a_pane_reflects_as_both_of_its_faces_do_and_lets_the_rest_through(tmp_path: Path) -> None:
    slab = _slab(_glass())
    with scratch_scene(cast(bpy.types.Scene, bpy.context.scene)) as scratch:
        body, panes = _panes_of(scratch, slab)
        flat = plan_of(
            np.array([[x, 0.1, 0.01] for x in (-0.6, -0.2, 0.2, 0.6)]), np.tile([0.0, 0, 1], (4, 1)), 1
        )
        with surface_alone([slab], [body.mesh], [panes]) as clear:
            alpha = find_alpha_map(scratch, [body], clear, flat, 1, tmp_path)
            plan = replace(flat, layout=replace(flat.layout, bucket=_CELLS))
            unseen = np.zeros((4, _CELLS, _CELLS), dtype=bool)
            with scene_copied(scratch) as copy:
                light = finished(capture_samples(copy, plan, unseen, 1, tmp_path))
    assert alpha is not None
    cosine = square_to_direction(light.square[:])[..., 2]
    expected = _slab_reflectance(cosine)
    mean = float((expected * cosine).sum() / cosine.sum())
    assert alpha.ravel() == pytest.approx(mean, rel=0.2)  # of nine rays
    assert not light.through[:].any()
    steep = cosine > 0.3
    seen = light.mirrored[:].astype(float)[steep]
    assert seen.mean(axis=1) == pytest.approx(expected[steep], rel=0.03)


def _slab_reflectance(cosine: Floats) -> Floats:
    """What a slab of an index of refraction of 1.5 reflects: Fresnel's equations, of both faces."""
    below = np.sqrt(1 - (1 - cosine**2) / 1.5**2)
    across = ((cosine - 1.5 * below) / (cosine + 1.5 * below)) ** 2
    along = ((1.5 * cosine - below) / (1.5 * cosine + below)) ** 2
    once = (across + along) / 2
    return cast(Floats, 2 * once / (1 + once))
