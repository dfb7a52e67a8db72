# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex.osl as a Script node in Cycles against the reference sampler."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import pytest

from radtex_addon.core.errors import InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.preview import osl
from radtex_addon.scene.nodes import NodeBuilder, Socket
from tests.blender.lookup_stage import Inputs, LookupStage, Shader, write_exr
from tests.lookups import LAYOUT, random_atlas, random_lookups, worst_error


def osl_shader(atlas: Path, kind: Filter) -> Shader:
    def shader(build: NodeBuilder, inputs: Inputs) -> tuple[Socket, ...]:
        node = osl.add_osl_node(build.tree, atlas, LAYOUT, kind)
        for name, source in zip(("UV", "Normal", "Tangent", "Sign", "Incoming"), inputs, strict=True):
            build.feed(node.inputs[name], source)
        return node.outputs["Color"], node.outputs["Alpha"]

    return shader


def test_the_script_node_agrees_with_the_reference(tmp_path: Path) -> None:
    atlas, lookups = random_atlas(), random_lookups()
    path = write_exr(tmp_path / "random.exr", atlas)
    stage = LookupStage(cast(bpy.types.Scene, bpy.context.scene), "CYCLES")
    cast(Any, stage.scene).cycles.shading_system = True
    for kind in Filter:
        stage.add(lookups, osl_shader(path, kind))
    for kind, result in zip(Filter, stage.render(tmp_path / "answers.exr"), strict=True):
        worst, across = worst_error(result, atlas, lookups, kind)
        print(f"OSL {kind}: worst error {worst:.1e}, across an edge {across:.2%}")
        assert worst <= 2e-3
        assert across <= 2e-3


def test_unlinked_vectors_are_the_shaded_point_s_own(tmp_path: Path) -> None:
    """Seen from straight above, every lookup is the pole of its bucket, the mean of four central cells."""
    atlas, lookups = random_atlas(), random_lookups()
    path = write_exr(tmp_path / "random.exr", atlas)
    stage = LookupStage(cast(bpy.types.Scene, bpy.context.scene), "CYCLES")
    cast(Any, stage.scene).cycles.shading_system = True

    def shader(build: NodeBuilder, inputs: Inputs) -> tuple[Socket, ...]:
        node = osl.add_osl_node(build.tree, path, LAYOUT, Filter.LINEAR)
        build.feed(node.inputs["UV"], inputs[0])
        return node.outputs["Color"], node.outputs["Alpha"]

    stage.add(lookups, shader)
    (result,) = stage.render(tmp_path / "answers.exr")
    up = np.tile(np.array([0, 0, 1], np.float32), (len(lookups.uv), 1))
    assert worst_error(result, atlas, replace(lookups, normal=up, viewer=up), Filter.LINEAR)[0] <= 2e-3


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


def test_a_blender_without_osl_is_told_what_to_do(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "oslquery", None)
    with pytest.raises(InputError, match="official build, or the node group"):
        osl.add_osl_node(empty_tree(), tmp_path / "a.exr", LAYOUT, Filter.NEAREST)


def empty_tree() -> bpy.types.NodeTree:
    return cast(bpy.types.NodeTree, bpy.data.node_groups.new("tree", "ShaderNodeTree"))
