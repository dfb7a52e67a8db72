# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/*.osl as Script nodes in Cycles against the reference samplers."""

from __future__ import annotations

import runpy
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.formats.sidecar import Sidecar, write_sidecar
from radtex_addon.forms.sphere.preview import add_transfer_osl_node
from radtex_addon.preview import osl
from radtex_addon.scene.nodes import NodeBuilder, Socket
from tests.blender.lookup_stage import (
    Inputs,
    LookupStage,
    Shader,
    add_camera_above,
    render_exr,
    set_up_render,
    write_exr,
)
from tests.lookups import (
    COUNT,
    LAYOUT,
    SIDE,
    Lookups,
    hit_answers,
    random_atlas,
    random_lookups,
    relative_error,
    worst_error,
)
from tests.transfer_lookups import WORST, Question, Way, questions


def osl_shader(atlas: Path, kind: Filter) -> Shader:
    def shader(build: NodeBuilder, inputs: Inputs) -> tuple[Socket, ...]:
        node = osl.add_osl_node(build.tree, atlas, LAYOUT, kind)
        for name, source in zip(("UV", "Normal", "Tangent", "Sign", "Incoming"), inputs, strict=True):
            build.feed(node.inputs[name], source)
        return node.outputs["Color"], node.outputs["Alpha"]

    return shader


def osl_stage() -> LookupStage:
    stage = LookupStage(cast(bpy.types.Scene, bpy.context.scene), "CYCLES")
    cast(Any, stage.scene).cycles.shading_system = True
    return stage


def test_the_script_node_agrees_with_the_reference(tmp_path: Path) -> None:
    atlas, lookups = random_atlas(), random_lookups()
    path = write_exr(tmp_path / "random.exr", atlas)
    stage = osl_stage()
    for kind in Filter:
        stage.add(lookups, osl_shader(path, kind))
    for kind, result in zip(Filter, stage.render(tmp_path / "answers.exr"), strict=True):
        worst, across = worst_error(result, atlas, lookups, kind)
        print(f"OSL {kind}: worst error {worst:.1e}, across an edge {across:.2%}")
        assert worst <= 2e-3
        assert across <= 2e-3


@pytest.mark.one_blender
def test_a_ray_stands_in_for_the_viewer(tmp_path: Path) -> None:
    """The viewer stays linked, and must not matter."""
    atlas, lookups = random_atlas(), random_lookups()
    path = write_exr(tmp_path / "random.exr", atlas)

    def plain(build: NodeBuilder, inputs: Inputs) -> tuple[Socket, ...]:
        node = osl.add_osl_node(build.tree, path, LAYOUT, Filter.QUADRILINEAR)
        for name, source in zip(("UV", "Normal", "Tangent", "Sign", "Incoming"), inputs, strict=True):
            build.feed(node.inputs[name], inputs[0] if name == "Incoming" else source)
        build.feed(node.inputs["Ray"], build.vector("SCALE", inputs[4], -1.0))
        return node.outputs["Color"], node.outputs["Alpha"]

    stage = osl_stage()
    stage.add(lookups, plain)
    (result,) = stage.render(tmp_path / "answers.exr")
    error = relative_error(result, hit_answers(atlas, lookups))
    print(f"OSL rays: worst error {error.max():.1e}")
    assert error.max() <= 2e-3


@pytest.mark.one_blender
def test_unlinked_vectors_are_the_shaded_point_s_own(tmp_path: Path) -> None:
    """Seen from straight above: without a normal every lookup is the pole of its bucket."""
    atlas, lookups = random_atlas(), random_lookups()
    path = write_exr(tmp_path / "random.exr", atlas)
    stage = osl_stage()

    def shader_of(linked: tuple[str, ...]) -> Shader:
        def shader(build: NodeBuilder, inputs: Inputs) -> tuple[Socket, ...]:
            node = osl.add_osl_node(build.tree, path, LAYOUT, Filter.LINEAR)
            for name, source in zip(("UV", "Normal", "Tangent", "Sign"), inputs, strict=False):
                if name in linked:
                    build.feed(node.inputs[name], source)
            return node.outputs["Color"], node.outputs["Alpha"]

        return shader

    up = np.tile(np.array([0, 0, 1], np.float32), (len(lookups.uv), 1))
    normals = {("UV", "Tangent", "Sign"): up, ("UV", "Normal", "Tangent", "Sign"): lookups.normal}
    for linked in normals:
        stage.add(lookups, shader_of(linked))
    for (linked, normal), result in zip(normals.items(), stage.render(tmp_path / "answers.exr"), strict=True):
        seen = replace(lookups, normal=normal, viewer=up)
        assert worst_error(result, atlas, seen, Filter.LINEAR)[0] <= 2e-3, linked


def test_a_shader_that_does_not_compile_is_refused_and_leaves_nothing(tmp_path: Path) -> None:
    source = tmp_path / "broken.osl"
    source.write_text("surface broken( { this is no shader")
    before = list(sys.path)
    tree = empty_tree()
    with pytest.raises(InputError, match=r"broken\.osl: does not compile"):
        osl.add_osl_node(tree, tmp_path / "a.exr", LAYOUT, Filter.NEAREST, source)
    assert not tree.nodes
    assert not bpy.data.texts
    assert sys.path == before
    assert [path.name for path in tmp_path.iterdir()] == ["broken.osl"]


@pytest.mark.one_blender
def test_a_blender_without_osl_is_told_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "oslquery", None)
    tree = empty_tree()
    with pytest.raises(InputError, match="official build, or the node group"):
        osl.add_osl_node(tree, tmp_path / "a.exr", LAYOUT, Filter.NEAREST)
    assert not tree.nodes
    assert not bpy.data.texts


EXAMPLE = osl.SOURCE.parent / "examples" / "script_node.py"
SLOPE = 1.5  # of the example's plane


@pytest.fixture
def example(monkeypatch: pytest.MonkeyPatch) -> Callable[[Path], Floats]:
    """What a square shows from above whose material the example made: SIDE x SIDE lookups, (K, 4).

    The square has the bake's UV layer and sign, and rises along u.
    """
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    python = Path(bpy.utils.resource_path("LOCAL"), "python", "lib")
    bundled = [str(python / version / "site-packages"), str(python / "site-packages")]

    def shown(sidecar: Path) -> Floats:
        scene = cast(Any, bpy.context.scene)
        set_up_render(scene, "CYCLES")
        mesh = bpy.data.meshes.new("square")
        corners = [(x, y) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
        mesh.from_pydata([(x, y, SLOPE * x) for x, y in corners], [], [(0, 1, 2, 3)])
        mesh.uv_layers.new(name="RadTex").uv.foreach_set("vector", np.ravel(corners))
        sign = cast(Any, mesh.attributes.new("radtex_sign", "FLOAT", "CORNER"))
        sign.data.foreach_set("value", np.ones(4, np.float32))
        square = bpy.data.objects.new("square", mesh)
        scene.collection.objects.link(square)
        bpy.context.view_layer.objects.active = square
        add_camera_above(scene, (0.5, 0.5), (1, 1), SIDE)
        # Blender's program has them on its path, its module has not.
        monkeypatch.setattr(sys, "path", [*sys.path, *bundled])
        monkeypatch.setattr(sys, "argv", ["blender", "--", str(sidecar)])
        runpy.run_path(str(EXAMPLE))
        return render_exr(scene, sidecar.with_name("shown.exr")).reshape(-1, 4)

    return shown


def seen_from_above() -> Lookups:
    """The square's lookups, row by row from the bottom."""
    middle = (np.arange(SIDE) + 0.5) / SIDE
    uv = np.stack(np.meshgrid(middle, middle), axis=-1).reshape(-1, 2)

    def everywhere(*vector: float) -> Floats:
        return np.tile(np.array(vector, np.float32), (COUNT, 1))

    normal, tangent = everywhere(-SLOPE, 0, 1), everywhere(1, 0, SLOPE)
    return Lookups(uv.astype(np.float32), normal, tangent, np.ones(COUNT, np.float32), everywhere(0, 0, 1))


def test_the_example_shows_an_atlas(example: Callable[[Path], Floats], tmp_path: Path) -> None:
    atlas, sidecar = random_atlas(), tmp_path / "Vase.radiance.json"
    facts = Sidecar("Vase", "radiance", 13, 7, 6, "RadTex", 16, 0, "portal", "RadTex 0.1.0", "5.2.3")
    write_exr(sidecar.with_suffix(".exr"), atlas)
    write_sidecar(sidecar, facts)
    result = example(sidecar)[:, :3]
    assert worst_error(result, atlas, seen_from_above(), Filter.QUADRILINEAR)[0] <= 2e-3


def empty_tree() -> bpy.types.NodeTree:
    return cast(bpy.types.NodeTree, bpy.data.node_groups.new("tree", "ShaderNodeTree"))


def shader_of(atlas: Path, question: Question) -> Shader:
    """The light stands in an image of its own."""
    lights: Any = bpy.data.images.new("lights", SIDE, SIDE, alpha=True, float_buffer=True, is_data=True)
    lights.use_half_precision, lights.alpha_mode = False, "CHANNEL_PACKED"
    lights.pixels.foreach_set(np.pad(question.light, ((0, 0), (0, 1)), constant_values=1).ravel())
    lights.update()

    def shader(build: NodeBuilder, inputs: Inputs) -> tuple[Socket, ...]:
        node = add_transfer_osl_node(build.tree, atlas, LAYOUT, question.views)
        for name, source in zip(("UV", "Normal", "Tangent", "Sign", "Incoming"), inputs, strict=True):
            build.feed(node.inputs[name], source)
        place = build.vector("FRACTION", build.uv_map("places"))
        build.feed(node.inputs["Light"], build.image(lights, place)[0])
        return node.outputs["Color"], node.outputs["Alpha"]

    return shader


@pytest.mark.one_blender
def test_the_script_node_of_a_transfer_agrees_with_the_reference(tmp_path: Path) -> None:
    stage = osl_stage()
    asked = [question for question in questions() if question.way in (Way.LOOKUP, Way.AROUND)]
    for question in asked:
        path = write_exr(tmp_path / f"{question.way.name}.exr", question.atlas)
        stage.add(question.lookups, shader_of(path, question))
    for question, result in zip(asked, stage.render(tmp_path / "answers.exr"), strict=True):
        worst = float(relative_error(result, question.answers).max())
        print(f"OSL, {question.way.name}: worst error of {COUNT} lookups {worst:.1e}")
        assert worst <= WORST
