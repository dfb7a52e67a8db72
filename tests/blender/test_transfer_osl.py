# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/radtex_transfer.osl as a Script node in Cycles, against the reference."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.preview import osl
from radtex_addon.scene.nodes import NodeBuilder, Socket
from tests.blender.lookup_stage import Inputs, LookupStage, Shader, write_exr
from tests.lookups import COUNT, LAYOUT, SIDE, relative_error
from tests.transfer_lookups import WORST, Question, Way, questions


def shader_of(atlas: Path, question: Question) -> Shader:
    """The light stands in an image of its own."""
    lights: Any = bpy.data.images.new("lights", SIDE, SIDE, alpha=True, float_buffer=True, is_data=True)
    lights.use_half_precision, lights.alpha_mode = False, "CHANNEL_PACKED"
    lights.pixels.foreach_set(np.pad(question.light, ((0, 0), (0, 1)), constant_values=1).ravel())
    lights.update()

    def shader(build: NodeBuilder, inputs: Inputs) -> tuple[Socket, ...]:
        node = osl.add_transfer_osl_node(build.tree, atlas, LAYOUT, question.views)
        for name, source in zip(("UV", "Normal", "Tangent", "Sign", "Incoming"), inputs, strict=True):
            build.feed(node.inputs[name], source)
        place = build.vector("FRACTION", build.uv_map("places"))
        build.feed(node.inputs["Light"], build.image(lights, place)[0])
        return node.outputs["Color"], node.outputs["Alpha"]

    return shader


def test_the_script_node_agrees_with_the_reference(tmp_path: Path) -> None:
    stage = LookupStage(cast(bpy.types.Scene, bpy.context.scene), "CYCLES")
    cast(Any, stage.scene).cycles.shading_system = True
    asked = [question for question in questions() if question.way in (Way.LOOKUP, Way.AROUND)]
    for question in asked:
        path = write_exr(tmp_path / f"{question.way.name}.exr", question.atlas)
        stage.add(question.lookups, shader_of(path, question))
    for question, result in zip(asked, stage.render(tmp_path / "answers.exr"), strict=True):
        worst = float(relative_error(result, question.answers).max())
        print(f"OSL, {question.way.name}: worst error of {COUNT} lookups {worst:.1e}")
        assert worst <= WORST
