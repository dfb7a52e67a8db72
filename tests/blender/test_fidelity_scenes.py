# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The fidelity bench's scenes: what they hold, and what their references depend on."""

from __future__ import annotations

import hashlib
from typing import Any, cast

import bpy
import numpy as np
import pytest

from tests.bench.fidelity import cache, scenes
from tests.bench.fidelity.lottery import lottery

pytestmark = pytest.mark.one_blender


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
