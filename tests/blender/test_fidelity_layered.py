# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The layered layout, baked with Cycles and looked at; and what the bench's references depend on."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from math import radians
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import pytest

from radtex_addon.report.gbuffer import BakedSurface
from radtex_addon.settings.spec import BakeSpec, Layout, Unwrap
from tests.bench.fidelity import cache, scenes
from tests.bench.fidelity.lottery import draw, lottery
from tests.bench.fidelity.lottery.exposure import expose
from tests.bench.fidelity.methods.layered import Layered
from tests.bench.fidelity.rendering import Rendering, render
from tests.bench.fidelity.scenes import SCENES, Stage
from tests.bench.fidelity.scenes.materials import assign, connect, principled
from tests.bench.fidelity.scenes.meshes import as_subject, made, move_to, places
from tests.bench.fidelity.scenes.stage import finish, start
from tests.blender.objects_stage import PIXELS, looking
from tests.blender.surroundings import sample_sky_coarsely

pytestmark = pytest.mark.one_blender
_SPEC = BakeSpec(layout=Layout.LAYERED, texels=32, samples=4, unwrap=Unwrap.BLENDER)
_REFERENCE = 24  # samples


def two_sided_sheet() -> Stage:
    """A sheet that stands bent, red on its outside and green within."""
    start("sunset.exr", strength=0.6, turn=30)
    sample_sky_coarsely()
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=16, y_subdivisions=8, size=2)
    sheet = as_subject(made())
    x, y, _ = places(sheet).T
    turn = radians(110) * x
    move_to(sheet, np.stack([0.7 * np.sin(turn), 0.7 * np.cos(turn), 0.7 * y], axis=1))
    bpy.ops.object.shade_smooth()
    paper: Any = principled("Paper", (0.0, 0.0, 0.0), Roughness=0.7)
    tree = paper.node_tree
    mix = tree.nodes.new("ShaderNodeMix")
    mix.data_type = "RGBA"
    mix.inputs[6].default_value, mix.inputs[7].default_value = (0.7, 0.05, 0.05, 1), (0.05, 0.6, 0.05, 1)
    tree.links.new(tree.nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"], mix.inputs[0])
    connect(paper, "Base Color", mix.outputs[2])
    assign(sheet, paper)
    return finish("two-sided sheet", sheet)


def test_both_sides_of_a_sheet_look_as_cycles_sees_them(tmp_path: Path) -> None:
    stage = two_sided_sheet()
    baked = Layered(_SPEC).bake(stage, tmp_path)
    surface = BakedSurface(baked.mesh, baked.matrix_world, baked.uv_layer)
    green = []
    for camera in stage.tuning:
        seen = surface.gbuffer(looking(camera), np.full(PIXELS**2, 1e9))
        picture = seen.resolve(baked.radiance(seen))
        reference = render(stage, camera, Rendering(_REFERENCE, 1, alone=False, pixels=PIXELS))[..., :3]
        inside = seen.eroded
        shown, expected = (np.clip(image[inside], 0, 1) ** (1 / 2.2) for image in (picture, reference))
        assert -10 * np.log10(((shown - expected) ** 2).mean()) > 24
        side = expected[:, 1] > expected[:, 0]
        green.append(side.mean())
        assert ((shown[:, 1] > shown[:, 0]) == side).mean() > 0.97
    assert 0.2 < np.mean(green) < 0.8


def test_a_head_of_gold_looks_as_cycles_sees_it(tmp_path: Path) -> None:
    stage = SCENES["metal_20"]()
    sample_sky_coarsely()
    baked = Layered(replace(_SPEC, unwrap=Unwrap.AUTO)).bake(stage, tmp_path)
    camera = stage.tuning[0]
    rays = looking(camera, scenes.PIXELS)
    surface = BakedSurface(baked.mesh, baked.matrix_world, baked.uv_layer)
    seen = surface.gbuffer(rays, np.full(len(rays.away), 1e9))
    picture = seen.resolve(baked.radiance(seen))
    reference = render(stage, camera, Rendering(_REFERENCE, 1, alone=False))[..., :3]
    inside = seen.eroded
    shown, expected = (np.clip(image[inside], 0, 1) ** (1 / 2.2) for image in (picture, reference))
    error = -10 * np.log10(((shown - expected) ** 2).mean())
    assert error > 21
    assert abs(shown.mean() / expected.mean() - 1) < 0.04


def state() -> str:
    """A hash of where all objects and their vertices lie, of all light's strength and of all materials."""
    graph = bpy.context.evaluated_depsgraph_get()
    scene = cast(bpy.types.Scene, bpy.context.scene)
    facts: list[object] = [_inputs(scene.world.node_tree)]
    for item in scene.objects:
        facts += [item.name, *(tuple(row) for row in cast(Any, item.matrix_world))]
        if item.type == "MESH":
            mesh = cast(Any, item.evaluated_get(graph)).data
            place = np.empty(3 * len(mesh.vertices), dtype=np.float32)
            mesh.vertices.foreach_get("co", place)
            facts += [place.tobytes(), *(_inputs(material.node_tree) for material in mesh.materials)]
            facts.append([face.material_index for face in mesh.polygons])
        if item.type == "LIGHT":
            facts.append(cast(Any, item.data).energy)
    return hashlib.sha256(repr(facts).encode()).hexdigest()


def _inputs(tree: Any) -> list[object]:
    """The values of all inputs of a tree's nodes."""
    sockets = [s for node in tree.nodes for s in node.inputs if hasattr(s, "default_value")]
    return [np.array(socket.default_value).tolist() for socket in sockets]


def test_a_draw_of_the_lottery_is_the_same_at_every_call(monkeypatch: pytest.MonkeyPatch) -> None:
    def expose_by_a_coarse_sky(stage: Stage) -> bool:
        sample_sky_coarsely()
        return expose(stage)

    monkeypatch.setattr(draw, "expose", expose_by_a_coarse_sky)
    first, again, other = (_state_of(number) for number in (3, 3, 4))
    assert first == again
    assert first != other


def _state_of(number: int) -> str:
    assert lottery(2, number).name == f"lottery-2-{number}"
    return state()


def test_a_key_depends_on_the_scene_and_its_helpers_alone() -> None:
    package = scenes.__name__
    sources = dict(cache._SOURCES)

    def changed(module: str) -> set[str]:
        edited = sources | {f"{package}.{module}": sources[f"{package}.{module}"] + "\n"}
        keys = ((name, f"{package}.{name}") for name in ("asset", "coat", "seven"))
        return {name for name, m in keys if cache.source_key(m, edited) != cache.source_key(m, sources)}

    assert changed("coat") == {"coat"}
    assert changed("case_maps") == {"asset"}
    assert changed("meshes") == {"asset", "coat", "seven"}
    assert changed("plant") == set()
