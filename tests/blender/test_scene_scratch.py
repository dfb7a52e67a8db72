# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The user's file is afterwards what it was."""

from __future__ import annotations

import weakref
from collections.abc import Generator
from contextlib import suppress
from pathlib import Path
from typing import Any, cast

import bpy
import pytest

from radtex_addon.core.errors import InputError
from radtex_addon.scene.mesh.copy import baked_mesh, copy_object, surface_mesh
from radtex_addon.scene.mesh.evaluated import evaluate
from radtex_addon.scene.scratch import scene_copied, scratch_scene
from radtex_addon.settings.spec import Unwrap
from tests.blender import stage
from tests.blender.conftest import PlannedError
from tests.blender.fingerprint import differences, fingerprint
from tests.blender.lived_in import lived_in_scene

context: Any = bpy.context  # to the stubs, every pointer may be None


def work_through(scratch: Any, head: Any, folder: Path) -> None:
    """All that a bake does to Blender: evaluate, unwrap, copy, add planes and images, render."""
    evaluated = evaluate(scratch, head)
    uv = stage.unwrapped(evaluated, 64).uv
    stage.unwrapped(evaluated, 64, method=Unwrap.BLENDER)
    mesh = baked_mesh(evaluated, uv)
    surface_mesh(evaluated, mesh)
    scratch.collection.objects.link(copy_object(head, mesh))
    image = bpy.data.images.new("portals", 4, 4, float_buffer=True)
    material = stage.material("portal", "ShaderNodeEmission")
    material.node_tree.nodes.new("ShaderNodeTexImage").image = image
    mesh.materials.append(material)
    bpy.data.node_groups.new("sampler", "ShaderNodeTree")
    scratch.render.engine = "CYCLES"
    scratch.render.resolution_x = scratch.render.resolution_y = 4
    scratch.render.resolution_percentage = 100
    scratch.cycles.samples = 1
    scratch.render.filepath = str(folder / "tile.exr")
    bpy.ops.render.render(scene=scratch.name, write_still=True)


@pytest.mark.parametrize("ends", ["done", "failed", pytest.param("dropped", marks=pytest.mark.one_blender)])
def test_a_bake_leaves_no_trace_however_it_ends(ends: str, tmp_path: Path) -> None:
    head = lived_in_scene()
    before = fingerprint()
    assert len(before) > 3000

    def job() -> Generator[None]:
        with scratch_scene(context.scene, "ViewLayer") as scratch:
            work_through(scratch, head, tmp_path)
            assert differences(before, fingerprint())
            yield
            if ends == "failed":
                raise PlannedError

    running = job()
    next(running)
    if ends == "dropped":
        running.close()
    with suppress(PlannedError, StopIteration):
        next(running)
    assert differences(before, fingerprint()) == {}


def test_work_goes_on_in_edit_mode(tmp_path: Path) -> None:
    """A mesh under edit is baked as it is then, and stays under edit."""
    head = lived_in_scene()
    bpy.ops.object.mode_set(mode="EDIT")
    before = fingerprint()
    with scratch_scene(context.scene) as scratch:
        work_through(scratch, head, tmp_path)
    assert head.mode == "EDIT"
    assert differences(before, fingerprint()) == {}


def test_what_is_kept_stays_with_all_that_it_uses() -> None:
    bpy.ops.mesh.primitive_cube_add()
    cube = context.object
    keep: list[bpy.types.ID] = []
    with scratch_scene(context.scene, keep=keep) as scratch:
        evaluated = evaluate(scratch, cube)
        mesh = baked_mesh(evaluated, stage.unwrapped(evaluated, 32, method=Unwrap.BLENDER).uv)
        copy = copy_object(cube, mesh)
        image = bpy.data.images.new("atlas", 4, 4)
        material = stage.material("preview", "ShaderNodeEmission")
        material.node_tree.nodes.new("ShaderNodeTexImage").image = image
        mesh.materials.append(material)
        stage.material("portal", "ShaderNodeEmission")
        keep.append(copy)
    assert copy.data == mesh
    assert mesh.materials[0] == material
    assert [item.name for item in bpy.data.materials] == ["preview"]
    assert [item.name for item in bpy.data.images] == ["atlas"]
    assert len(bpy.data.scenes) == 1


def test_one_render_s_settings_and_data_are_none_of_the_next_s() -> None:
    with scratch_scene(context.scene) as scratch:
        samples = cast(Any, scratch).cycles.samples
        with suppress(PlannedError), scene_copied(scratch) as scene:
            cast(Any, scene).cycles.samples = samples + 7
            scene.collection.objects.link(bpy.data.objects.new("lamp", None))
            raise PlannedError
        with scene_copied(scratch) as scene:
            assert cast(Any, scene).cycles.samples == samples
            assert list(bpy.data.objects) == []
        assert set(bpy.data.scenes) == {context.scene, scratch}


def test_nothing_of_a_render_outlives_its_scene() -> None:
    """Not even persistent data: Blender would write to the scene that is gone, and crash."""
    kept: list[weakref.ref[object]] = []

    class Engine(bpy.types.RenderEngine):
        bl_idname = "RADTEX_TEST"
        bl_label = "RadTex test"

        def render(self, _: Any) -> None:  # type: ignore[override]  # the stubs' own render is another
            kept.append(weakref.ref(self))

    bpy.ops.object.camera_add()
    context.scene.camera = context.object
    bpy.utils.register_class(Engine)
    try:
        with scratch_scene(context.scene) as scratch:
            render: Any = scratch.render
            render.engine, render.use_persistent_data = "RADTEX_TEST", True
            render.resolution_x = render.resolution_y = 4
            bpy.ops.render.render(scene=scratch.name)
            assert kept[0]() is not None
        assert kept[0]() is None
    finally:
        bpy.utils.unregister_class(Engine)


def test_handlers_sleep_and_wake_in_order() -> None:
    calls: list[str] = []

    def first(*_: object) -> None:
        calls.append("first")

    def second(*_: object) -> None:
        calls.append("second")

    def ours(*_: object) -> None:
        calls.append("ours")

    handlers = bpy.app.handlers
    for name in ("render_pre", "frame_change_post", "render_complete"):
        getattr(handlers, name).extend([first, second])
    try:
        with suppress(PlannedError), scratch_scene(context.scene) as scratch:
            bpy.ops.mesh.primitive_cube_add()
            evaluate_nothing(scratch)
            handlers.render_pre.append(ours)
            evaluate_nothing(scratch)
            raise PlannedError
        assert calls == ["ours"]
        for name in ("render_pre", "frame_change_post", "render_complete"):
            assert getattr(handlers, name)[-2:] == [first, second]
    finally:
        for name in ("render_pre", "frame_change_post", "render_complete"):
            for function in (first, second):
                getattr(handlers, name).remove(function)


def evaluate_nothing(scratch: Any) -> None:
    """Render a scene of ours, handlers and all."""
    scratch.render.engine, scratch.render.resolution_x, scratch.render.resolution_y = "CYCLES", 4, 4
    scratch.cycles.samples = 1
    if scratch.camera is None:
        scratch.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        scratch.collection.objects.link(scratch.camera)
    bpy.ops.render.render(scene=scratch.name)


def test_only_the_chosen_view_layer_renders(caplog: pytest.LogCaptureFixture) -> None:
    lived_in_scene()
    scene = context.scene
    scene.view_layers["second"].material_override = bpy.data.materials["gold"]
    with scratch_scene(scene, "second") as scratch:
        assert [layer.name for layer in scratch.view_layers if layer.use] == ["second"]
        assert scratch.view_layers["second"].samples == 0
        assert scratch.view_layers["second"].material_override is None
        assert scratch.animation_data is None
        assert len(scratch.timeline_markers) == 0
        render = scratch.render
        assert not any([render.use_border, render.use_compositing, render.use_motion_blur])
        assert scratch.frame_current_final == scene.frame_current_final
    assert "overrides all materials with 'gold'" in caplog.text


def test_an_unknown_view_layer_is_refused_before_anything_happens() -> None:
    before = fingerprint()
    with (
        pytest.raises(InputError, match=r"scene 'Scene' has no view layer 'front': it has 'ViewLayer'"),
        scratch_scene(context.scene, "front"),
    ):
        pass
    assert differences(before, fingerprint()) == {}


def test_the_first_view_layer_that_renders_is_taken() -> None:
    scene = context.scene
    scene.view_layers.new("second")
    scene.view_layers[0].use = False
    with scratch_scene(scene) as scratch:
        assert [layer.name for layer in scratch.view_layers if layer.use] == ["second"]
