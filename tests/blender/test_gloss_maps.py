# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Roughness as it is evaluated: through textures, groups, reroutes and mixes of shaders."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import pytest

from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats
from radtex_addon.cycles.path_ends import Body
from radtex_addon.forms.layered.capture.gloss_maps import (
    capture_gloss,
    capture_tangents,
    is_brushed,
    may_vary,
    sharpest_width,
    widest_blur,
    width_of,
)
from radtex_addon.forms.layered.capture.panoramas import share_for
from radtex_addon.forms.layered.fit.fitting import fit_layered
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas
from radtex_addon.report.gbuffer import BakedSurface
from radtex_addon.scene.nodes import NodeBuilder
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec, Layout
from tests.bench.fidelity.layered.staged import capture_staged
from tests.bench.fidelity.methods.layered import baked_of
from tests.bench.fidelity.metrics import compare
from tests.bench.fidelity.references import view_of
from tests.bench.fidelity.scenes.materials import assign, principled, shader
from tests.bench.fidelity.scenes.meshes import as_subject
from tests.bench.fidelity.scenes.meshes import made as last_made
from tests.bench.fidelity.scenes.stage import Stage, finish, start
from tests.blender.stage import material, plan_of, world
from tests.blender.surroundings import sample_sky_coarsely

_STEPS = np.array([0.0, 0.05, 0.2, 0.35, 0.5, 0.7, 0.9, 1.0], dtype=np.float32)


def _image() -> bpy.types.Image:
    """Roughness in steps along u."""
    image = bpy.data.images.new("Roughness", len(_STEPS), 1, float_buffer=True, is_data=True)
    cast(Any, image).pixels.foreach_set(np.stack([_STEPS] * 4, axis=1).ravel())
    return image


def _textured(tree: Any, kind: str) -> Any:
    """A shader whose roughness is the image's, through a reroute."""
    shader, texture = tree.nodes.new(kind), tree.nodes.new("ShaderNodeTexImage")
    texture.image, texture.interpolation = _image(), "Closest"
    reroute = tree.nodes.new("NodeReroute")
    tree.links.new(texture.outputs[0], reroute.inputs[0])
    tree.links.new(reroute.outputs[0], shader.inputs["Roughness"])
    return shader.outputs[0]


def _output(made: bpy.types.Material) -> Any:
    return cast(Any, made.node_tree).get_output_node("CYCLES").inputs["Surface"]


def _plain(kind: str) -> bpy.types.Material:
    made = material(kind, "ShaderNodeBsdfDiffuse")
    made.node_tree.links.new(_textured(made.node_tree, kind), _output(made))
    return made


def _grouped() -> bpy.types.Material:
    """The same in a group, whose light, and a diffuse shader's, are each the half."""
    made = material("Grouped", "ShaderNodeBsdfDiffuse")
    group = cast(Any, bpy.data.node_groups.new("Gloss", "ShaderNodeTree"))
    group.interface.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    group.links.new(
        _textured(group, "ShaderNodeBsdfPrincipled"), group.nodes.new("NodeGroupOutput").inputs[0]
    )
    tree: Any = made.node_tree
    diffuse = _output(made).links[0].from_socket
    node, mix = tree.nodes.new("ShaderNodeGroup"), tree.nodes.new("ShaderNodeMixShader")
    node.node_tree = group
    tree.links.new(diffuse, mix.inputs[1])
    tree.links.new(node.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], _output(made))
    return made


def _mixed() -> bpy.types.Material:
    """A quarter of a sharp and three of a rough glossy shader, beside a light of its own."""
    made = material("Mixed", "ShaderNodeEmission", Strength=3.0)
    tree: Any = made.node_tree
    shine = _output(made).links[0].from_socket
    mix, add = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeAddShader")
    mix.inputs[0].default_value = 0.75
    for place, roughness in ((1, 0.1), (2, 0.4)):
        glossy = tree.nodes.new("ShaderNodeBsdfGlossy")
        glossy.inputs["Roughness"].default_value = roughness
        tree.links.new(glossy.outputs[0], mix.inputs[place])
    tree.links.new(mix.outputs[0], add.inputs[0])
    tree.links.new(shine, add.inputs[1])
    tree.links.new(add.outputs[0], _output(made))
    return made


def _brushed(kind: str, turn: float = 0.0, **inputs: float) -> bpy.types.Material:
    """Anisotropic metal whose tangents are along x, turned by a share of a whole turn."""
    names = ("Anisotropic", "Anisotropic Rotation") if "Principled" in kind else ("Anisotropy", "Rotation")
    made = material(kind, kind, Roughness=0.3, **inputs)
    tree: Any = made.node_tree
    shader = _output(made).links[0].from_node
    for name, value in zip(names, (0.7, turn), strict=True):
        shader.inputs[name].default_value = value
    along = tree.nodes.new("ShaderNodeCombineXYZ")
    along.inputs[0].default_value = 1.0
    tree.links.new(along.outputs[0], shader.inputs["Tangent"])
    return made


def _captured(
    materials: list[bpy.types.Material],
    folder: Path,
    shifts: tuple[float, ...] = (0.0,),
    tangents: bool = False,
) -> Floats | None:
    """What is found in the middles of the steps, on a row of quads: (materials, steps), or tangents, x 3."""
    bpy.context.scene.render.engine = "CYCLES"
    bpy.context.scene.cycles.sample_clamp_direct = 0.1  # of the user's, which may not cut what is coded
    world()
    mesh = bpy.data.meshes.new("Quads")
    count = len(materials)
    place = [(x, y + side, 0.0) for y in range(count) for x, side in ((0, 0), (1, 0), (1, 1), (0, 1))]
    mesh.from_pydata(place, [], np.arange(4 * count).reshape(-1, 4).tolist())
    layer: Any = mesh.uv_layers.new(name="UVMap")
    layer.data.foreach_set("uv", np.tile([0.0, 0, 1, 0, 1, 1, 0, 1], count))
    for made in materials:
        mesh.materials.append(made)
    mesh.polygons.foreach_set("material_index", np.arange(count, dtype=np.int32))
    item = bpy.data.objects.new("Quads", mesh)
    bpy.context.scene.collection.objects.link(item)
    along = (np.arange(len(_STEPS)) + 0.5) / len(_STEPS)
    points = np.array([(x, y + 0.5, 0.0) for y in range(count) for x in along])
    plan = plan_of(points, np.tile([0.0, 0, 1], (len(points), 1)), 1)
    plans = [plan.moved_to(points + np.array([shift / len(_STEPS), 0, 0])) for shift in shifts]
    bodies = [Body(item, mesh.copy(), np.eye(4))]
    with scratch_scene(cast(bpy.types.Scene, bpy.context.scene)) as scratch:
        if tangents:
            found = capture_tangents(scratch, bodies, plan, 1, folder)
        else:
            found = capture_gloss(scratch, bodies, plans, 1, folder)
    return None if found is None else found.reshape(count, -1, *((3,) if tangents else ()))


def test_the_roughness_of_every_kind_of_graph_is_the_textures(tmp_path: Path) -> None:
    kinds = ("ShaderNodeBsdfPrincipled", "ShaderNodeBsdfGlossy", "ShaderNodeBsdfGlass")
    hair = _plain("ShaderNodeBsdfHairPrincipled")
    plastic = material("Plastic", "ShaderNodeBsdfPrincipled", Roughness=0.35)
    matt = material("Matt", "ShaderNodeBsdfDiffuse")
    made = [*map(_plain, kinds), _grouped(), _mixed(), plastic, matt, hair]
    before = [[node.name for node in one.node_tree.nodes] for one in made]
    found = _captured(made, tmp_path)
    assert found is not None
    exact = np.log2(width_of(_STEPS))
    for number in range(4):
        np.testing.assert_allclose(found[number], exact, atol=2e-3, err_msg=made[number].name)
    np.testing.assert_allclose(2 ** found[0, 1:4] / (2 * _STEPS[1:4] ** 4), 1, atol=0.08)  # GGX's own
    sharp, rough = np.log2(width_of(np.array([0.1, 0.4])))
    np.testing.assert_allclose(found[4], 0.25 * sharp + 0.75 * rough, atol=2e-3)
    np.testing.assert_allclose(found[5], exact[3], atol=2e-3)
    assert np.isnan(found[6:]).all()
    assert [[node.name for node in one.node_tree.nodes] for one in made] == before


def test_no_rays_are_spent_where_roughness_cannot_vary(tmp_path: Path) -> None:
    even = [material("Even", "ShaderNodeBsdfPrincipled"), material("Matt", "ShaderNodeBsdfDiffuse")]
    assert not any(map(may_vary, even))
    assert _captured(even, tmp_path / "absent") is None


def test_tangents_are_those_of_the_shaders_turned_as_they_say(tmp_path: Path) -> None:
    usual = "ShaderNodeBsdfPrincipled"
    made = [
        *(_brushed(kind) for kind in (usual, "ShaderNodeBsdfGlossy", "ShaderNodeBsdfMetallic")),
        _brushed(usual, turn=0.25),
        _brushed(usual, turn=1 / 12),
        _brushed(usual, Coat_Weight=0.5),
        material("Plastic", usual, Roughness=0.35),
    ]
    partly = _brushed(usual)
    tree: Any = partly.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image, texture.interpolation = _image(), "Closest"
    tree.links.new(texture.outputs[0], _output(partly).links[0].from_node.inputs["Anisotropic"])
    found = _captured([*made, partly], tmp_path, tangents=True)
    assert found is not None
    smooth = [[0, 0, 0]] + [[1, 0, 0]] * (len(_STEPS) - 1)
    np.testing.assert_allclose(np.abs(found[-1]), smooth, atol=2e-3, err_msg="its first step has no brush")
    for number in range(3):
        np.testing.assert_allclose(np.abs(found[number]), [[1, 0, 0]] * len(_STEPS), atol=2e-3)
    np.testing.assert_allclose(np.abs(found[3]), [[0, 1, 0]] * len(_STEPS), atol=2e-3)
    np.testing.assert_allclose(found[4], [[np.cos(np.pi / 6), 0.5, 0]] * len(_STEPS), atol=2e-3)
    assert not found[5:-1].any()
    assert [is_brushed(one) for one in made] == [True] * 5 + [False] * 2
    assert _captured(made[5:], tmp_path / "absent", tangents=True) is None


def _steel(brush: float) -> Stage:
    """A brushed cylinder, its tangents around its axis, before one bright small place of the world."""
    start("studio.exr", strength=0.7, turn=75)
    sample_sky_coarsely()
    bpy.ops.mesh.primitive_cylinder_add(vertices=48, radius=0.5, depth=1.6, end_fill_type="TRIFAN")
    can = as_subject(last_made())
    bpy.ops.object.shade_smooth_by_angle()
    steel = principled("Steel", (0.7, 0.7, 0.7), Metallic=1.0, Roughness=0.35, Anisotropic=brush)
    tree: Any = steel.node_tree
    tangent = tree.nodes.new("ShaderNodeTangent")
    tangent.direction_type, tangent.axis = "RADIAL", "Z"
    tree.links.new(tangent.outputs[0], shader(steel).inputs["Tangent"])
    assign(can, steel)
    return finish("can", can)


def test_a_small_brushed_can_looks_as_in_cycles(tmp_path: Path) -> None:
    """Round metal of the same roughness, beside it, keeps its maps and lamps."""
    spec = BakeSpec(layout=Layout.LAYERED, texels=32, samples=4)
    round_one = finished(fit_layered(capture_staged(_steel(0.0), spec, tmp_path).captured.capture))
    assert round_one.tangent is None
    assert round_one.materials[0].brush is None
    assert not round_one.around.lamps
    stage = _steel(0.8)
    staged = capture_staged(stage, spec, tmp_path)
    atlas = finished(fit_layered(staged.captured.capture))
    assert atlas.tangent is not None
    along, across = 2 * 0.35**4 / 0.28, 2 * 0.35**4 * 0.28
    assert atlas.materials[0].brush == pytest.approx((along, across), rel=0.3)
    assert all(lamp.behind for lamp in atlas.around.lamps)
    seen = view_of(stage, stage.held_out[0], 64, 2)
    surface = BakedSurface(staged.prepared.mesh, staged.matrix_world, staged.prepared.uv_layer)
    buffer = surface.gbuffer(seen.rays, seen.blocked)

    def psnr(one: LayeredAtlas) -> float:
        picture = buffer.resolve(baked_of(one, staged).radiance(buffer))
        return compare(picture, seen.reference, buffer.inside, buffer.eroded).psnr

    unbrushed = replace(atlas, tangent=None)
    print(f"brushed {psnr(atlas):.1f} dB, its lamps as round blurs {psnr(unbrushed):.1f} dB")
    assert psnr(atlas) > psnr(unbrushed) + 1


def _plastic(roughness: float, coat: float = 0.0) -> bpy.types.Material:
    return material("Plastic", "ShaderNodeBsdfPrincipled", Roughness=roughness, Coat_Weight=coat)


def _thing(*materials: bpy.types.Material) -> Body:
    """A triangle of each material, and a slot with polished plastic that no face has."""
    mesh = bpy.data.meshes.new("Thing")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)] * len(materials))
    for one in (*materials, _plastic(0.0)):
        mesh.materials.append(one)
    mesh.polygons.foreach_set("material_index", np.arange(len(materials), dtype=np.int32))
    return Body(bpy.data.objects.new("Thing", mesh), mesh, np.eye(4))


def test_lights_keep_their_shapes_where_something_is_sharp_enough_to_show_them() -> None:
    steel = _brushed("ShaderNodeBsdfPrincipled")
    usual = float(width_of(np.array(0.3)))
    assert widest_blur([_thing(steel)], None) == pytest.approx(usual)
    assert widest_blur([_thing(steel, _plastic(0.5))], None) == pytest.approx(usual)
    assert widest_blur([_thing(steel, _plastic(0.3))], None) == pytest.approx(usual / 4)
    assert widest_blur([_thing(steel, _plastic(0.03))], None) < 1e-5
    assert widest_blur([_thing(steel), _thing(_plastic(0.5, coat=1.0))], None) < 1e-3


def test_rough_things_need_no_sharp_pictures_of_a_room() -> None:
    def share(*materials: bpy.types.Material, evaluated: Floats | None = None) -> float:
        return share_for(sharpest_width([_thing(*materials)], evaluated))

    assert share(material("Matt", "ShaderNodeBsdfDiffuse")) == share(_plastic(0.6)) == 0.25
    assert share(_plastic(0.25)) == share(_plastic(0.6), _plastic(0.25)) == 0.5
    assert share(_plastic(0.1)) == 1.0
    assert share(_plastic(0.6, coat=0.2)) == 1.0  # of the coat's own roughness
    assert share(material("Hair", "ShaderNodeBsdfHairPrincipled")) == 1.0
    textured = _plain("ShaderNodeBsdfPrincipled")
    assert share(textured) == 1.0
    assert share(textured, evaluated=np.log2(width_of(np.array([0.6, np.nan])))) == 0.25


def test_the_points_of_a_texel_are_averaged(tmp_path: Path) -> None:
    found = _captured([_plain("ShaderNodeBsdfPrincipled")], tmp_path, shifts=(0, 1))
    assert found is not None
    exact = np.log2(width_of(_STEPS))
    np.testing.assert_allclose(found[0, :-1], (exact[:-1] + exact[1:]) / 2, atol=2e-3)
    np.testing.assert_allclose(found[0, -1], exact[-1], atol=2e-3)  # beyond the quad there is nothing


def _turned(name: str, low: float, high: float) -> bpy.types.Material:
    """Metal with a normal map, of one roughness on the left of the object and of another on its right."""
    made = material(name, "ShaderNodeBsdfPrincipled", Metallic=1.0)
    tree: Any = made.node_tree
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    build = NodeBuilder(tree)
    place = tree.nodes.new("ShaderNodeTexCoord").outputs["Object"]
    right = build.math("GREATER_THAN", build.separate(place)[0], 0.0)
    build.feed(shader.inputs["Roughness"], build.math("MULTIPLY_ADD", right, high - low, low))
    texture, mapped = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeNormalMap")
    texture.image = bpy.data.images.new("Normals", 32, 32, float_buffer=True, is_data=True)
    turned = np.ones((32, 32, 4), dtype=np.float32)
    turned[..., :2] += 0.3 * np.sin(np.arange(32) * np.pi / 8)[:, None]
    turned[..., :2] /= 2
    texture.image.pixels.foreach_set(turned.ravel())
    tree.links.new(texture.outputs[0], mapped.inputs["Color"])
    tree.links.new(mapped.outputs[0], shader.inputs["Normal"])
    return made


def _ball(materials: Sequence[Callable[[], bpy.types.Material]], folder: Path) -> LayeredAtlas:
    """A bake of a ball whose left side has the first material, and its right side the last one."""
    start("sunset.exr", strength=0.6, turn=30)
    sample_sky_coarsely()
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16)
    ball = as_subject(last_made())
    bpy.ops.object.shade_smooth()
    for one in [make() for make in materials]:
        assign(ball, one)
    faces = cast(bpy.types.Mesh, ball.data).polygons
    right = [(len(materials) - 1) * (face.center.x > 0) for face in faces]
    faces.foreach_set("material_index", right)
    spec = BakeSpec(layout=Layout.LAYERED, texels=32, samples=4)
    return finished(fit_layered(capture_staged(finish("ball", ball), spec, folder).captured.capture))


def _spread(atlas: LayeredAtlas, number: int) -> float:
    """log2 of a material's width² at N.V = 0.8, by the light of its lobes."""
    weight, variance, _ = atlas.materials[number].at(np.array([0.8]))
    share = weight[:, 1, 0] / weight[:, 1, 0].sum()
    return float((share * np.log2(variance[:, 0])).sum())


def test_a_ball_of_two_roughnesses_and_a_normal_map_has_the_lobes_of_two_materials(tmp_path: Path) -> None:
    one = _ball([lambda: _turned("Both", 0.1, 0.5)], tmp_path)
    two = _ball([lambda: _turned("Left", 0.1, 0.1), lambda: _turned("Right", 0.5, 0.5)], tmp_path)
    assert one.normal is not None
    assert one.width is not None
    assert two.width is None
    assert one.width.shape == (*one.colour.shape[:2], 1)
    left, right = np.quantile(one.width, [0.1, 0.9])
    for offset, number in ((left, 0), (right, 1)):
        assert abs(_spread(one, 0) + offset - _spread(two, number)) < 0.1  # octaves of width²: 4 % of width
