# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is noticed of a scene that is not what it was, and what of it is of no consequence."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.scene import block_digests
from radtex_addon.scene.block_digests import file_digest
from radtex_addon.scene.digests import scene_digests
from radtex_addon.scene.scratch import scratch_scene
from tests.blender import stage

context: Any = bpy.context  # to the stubs, every pointer may be None


@pytest.fixture(autouse=True)
def scene(empty_file: None, tmp_path: Path) -> None:
    """A grid with a picture on it, seen by Eevee and Cycles alike, a curve and a text."""
    stage.world()
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=4, y_subdivisions=4)
    context.object.name = "Grid"
    material = stage.material("painted", "ShaderNodeBsdfDiffuse")
    nodes = material.node_tree.nodes
    picture = bpy.data.images.new("picture", 4, 4)
    picture.filepath_raw, picture.file_format = (
        str(tmp_path / "picture.bmp"),
        "BMP",
    )  # of the same size always
    picture.save()
    nodes.new("ShaderNodeTexImage").image = picture
    script = nodes.new("ShaderNodeScript")
    script.script = bpy.data.texts.new("glow.osl")
    outside = nodes.new("ShaderNodeScript")
    (tmp_path / "mist.osl").write_text("shader mist() {}")
    outside.mode, outside.filepath = "EXTERNAL", str(tmp_path / "mist.osl")
    context.object.data.materials.append(material)
    bpy.ops.curve.primitive_bezier_circle_add()
    context.object.name, context.object.data.bevel_depth = "Wire", 0.1
    bpy.ops.object.text_add()
    context.object.name, context.object.data.extrude = "Sign", 0.1


def digests() -> dict[str, str]:
    with scratch_scene(context.scene, None, []) as scratch:
        return scene_digests(scratch)


def grid() -> Any:
    return context.scene.objects["Grid"]


def an_inner_vertex() -> None:
    grid().data.vertices[12].co.x += 1e-3


def a_uv() -> None:
    grid().data.uv_layers[0].uv[7].vector.x += 1e-3


def a_face() -> None:
    grid().data.flip_normals()


def a_modifier_that_the_viewport_lacks() -> None:
    wave = grid().modifiers.new("wave", "WAVE")
    wave.show_viewport = False


def a_curve() -> None:
    context.scene.objects["Wire"].data.bevel_resolution += 1


def a_text() -> None:
    context.scene.objects["Sign"].data.body = "Tixt"


def what_the_viewport_hides() -> None:
    grid().hide_viewport = True
    a = grid().data.vertices[0].co
    a.z += 1


def a_pixel() -> None:
    a_painted_pixel()
    bpy.data.images["picture"].save()


def a_painted_pixel() -> None:
    picture: Any = bpy.data.images["picture"]
    picture.pixels[5] = 1.0


def a_packed_pixel() -> None:
    a_pixel()
    bpy.data.images["picture"].pack()


def a_script() -> None:
    bpy.data.texts["glow.osl"].write("shader glow() {}")


def a_script_outside() -> None:
    node = bpy.data.materials["painted"].node_tree.nodes[-1]
    Path(node.filepath).write_text("shader mist() { }")


@pytest.mark.parametrize(
    ("change", "noticed"),
    [
        (an_inner_vertex, "objects"),
        (a_uv, "objects"),
        (a_face, "objects"),
        (a_modifier_that_the_viewport_lacks, "objects"),
        (a_curve, "objects"),
        (a_text, "objects"),
        (what_the_viewport_hides, "objects"),
        (a_pixel, "materials"),
        (a_painted_pixel, "materials"),
        (a_packed_pixel, "materials"),
        (a_script, "materials"),
        (a_script_outside, "materials"),
    ],
)
def test_a_change_is_noticed(change: Callable[[], None], noticed: str) -> None:
    before = digests()
    assert digests() == before
    change()
    after = digests()
    assert [name for name in before if before[name] != after[name]] == [noticed]
    assert digests() == after


def test_what_does_not_matter_is_not_noticed() -> None:
    before = digests()
    for name in ("vertices", "edges", "polygons"):
        for one in getattr(grid().data, name):
            one.select = not one.select
    grid().select_set(not grid().select_get())
    bpy.ops.object.camera_add()
    bpy.data.materials["painted"].node_tree.nodes[0].location.x += 100
    assert digests() == before


@pytest.mark.one_blender
def test_a_large_file_is_read_in_part(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(block_digests, "_WHOLE", 64 * 10)
    path = tmp_path / "large"
    content = np.random.default_rng(1).bytes(5000)
    path.write_bytes(content)
    before = file_digest(path)
    for changed in (b"??" + content[2:], content[:-2] + b"??", content[:-1]):
        path.write_bytes(changed)
        assert file_digest(path) != before
    assert file_digest(tmp_path / "none") == ""
