# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The fidelity bench's scenes: what they hold, and what their references depend on."""

from __future__ import annotations

import hashlib
from pkgutil import iter_modules
from typing import Any, cast

import bpy
import numpy as np
import pytest

from radtex_addon.report.gbuffer import Rays
from radtex_addon.report.metrics import Picture
from tests.bench.fidelity import cache, scenes
from tests.bench.fidelity.lottery import lottery
from tests.bench.fidelity.metrics import Figures
from tests.bench.fidelity.references import View
from tests.bench.fidelity.report import Result, Seen, distribution_table
from tests.bench.fidelity.scenes import SCENES, Stage

pytestmark = pytest.mark.one_blender
HELPERS = {"stage", "meshes", "materials", "case_maps"}


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


def test_a_draw_of_the_lottery_is_the_same_at_every_call() -> None:
    first, again, other = (_state_of(number) for number in (3, 3, 4))
    assert first == again
    assert first != other


def _state_of(number: int) -> str:
    assert lottery(2, number).name == f"lottery-2-{number}"
    return state()


@pytest.mark.parametrize("name", SCENES)
def test_scenes_are_named_as_listed_and_have_cameras_of_both_sorts(name: str) -> None:
    stage = SCENES[name]()
    assert isinstance(stage, Stage)
    assert stage.name == name
    assert len(stage.tuning) == len(stage.held_out) == 2
    low, high = (np.array(cast(Any, stage.subject).bound_box)[corner] for corner in (0, 6))
    assert (high > low).all()


def test_every_module_of_scenes_is_listed() -> None:
    modules = {module.name for module in iter_modules(scenes.__path__)} - HELPERS
    assert modules == {build.__module__.rpartition(".")[2] for build in SCENES.values()}


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


def test_the_distribution_shows_the_worst_scene_first() -> None:
    black: Picture = np.zeros((2, 2, 3))
    inside = np.ones((2, 2), dtype=bool)
    view = View(
        "held out 1", True, black, None, Rays(2, 1, black[0, 0], black.reshape(-1, 3)), inside.ravel() * 9.0
    )

    def result(psnr: float, flip: float) -> list[Result]:
        figures = Figures(psnr, psnr, flip, 1.0, 0.0)
        return [Result("default", 0, 0.0, 0, (Seen(view, black, inside, inside, figures),))]

    table = distribution_table({"a": result(30, 0.1), "b": result(20, 0.4), "c": result(25, 0.3)})
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines()[2:]]
    found = dict(rows)
    assert [name for name, _ in rows[-3:]] == ["b", "c", "a"]
    assert found["**worst**"] == "20.00 / 0.400"
    assert found["**median**"] == "25.00 / 0.300"
    assert found["**mean**"] == "25.00 / 0.267"
    assert found["**best**"] == "30.00 / 0.100"


def test_pictures_of_other_renderings_are_other_files() -> None:
    paths = {cache.picture_path("coat", "held out 1", rendering) for rendering in (1, 2)}
    assert len(paths) == 2
    assert len({cache.scene_key(name) for name in ("coat", "lottery-1-0", "metal_05")}) == 3
