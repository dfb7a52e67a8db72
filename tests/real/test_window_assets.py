# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Several objects in Blender's window: those that touch are one asset, and texels are seen before a bake."""

from __future__ import annotations

from time import sleep

from tests.real.panel import choose, jobs, press, settle, wait_for_end
from tests.real.window import Window, changed

TEXELS = 49  # pixels from the sidebar's right edge to the button that shows texels
AWAY = 500, 600  # a place in the 3D view
SECONDS_TO_GLIDE = 1.5  # for the panels below the button, which the lines have moved
PANEL = 1030, 60, 1290, 500  # the sidebar from its top to the lines below the button
HAT = """
top = max(corner[2] for corner in bpy.data.objects["Suzanne"].bound_box)
place = bpy.data.objects["Suzanne"].matrix_world.translation
with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
    bpy.ops.mesh.primitive_cube_add(size=0.8, location=(place.x, place.y, place.z + top + 0.3))
    bpy.context.object.name = "Hat"
"""


def test_the_panel_offers_an_asset_and_one_job_bakes_it(window: Window) -> None:
    window.ask(HAT)
    choose(window, "Hat", "Suzanne", atlas_layout="auto", texels=48, samples=1, unwrap="blender")
    window.point(*AWAY)
    settle(window)
    sleep(SECONDS_TO_GLIDE)
    offered = window.shot("asset", PANEL)
    found = window.value("[list(each) for one in panel_state._cache.found.values() for each in one.assets]")
    assert found == [["Suzanne_asset", 2, 128]]
    window.ask("bpy.context.scene.radtex.together = 'off'")
    settle(window)
    assert changed(offered, window.picture("each")) > 0.001
    window.ask("bpy.context.scene.radtex.together = 'auto'")
    settle(window)
    press(window)
    told = wait_for_end(window)
    assert (told.what, told.state) == ("Suzanne_asset", "done"), told.message
    assert len(jobs(window)) == 1


def test_texels_are_shown_before_anything_is_baked(window: Window) -> None:
    choose(window, "Suzanne", atlas_layout="auto", texels=64, samples=1)
    button = window.find("radtex.show_texels(", right=TEXELS)
    window.point(*AWAY)
    settle(window)
    plain = window.picture("plain")
    window.click(*button)
    window.point(*AWAY)
    settle(window)
    shown = window.shot("texels")
    assert changed(plain, shown) > 0.1
    window.click(*button)
    window.point(*AWAY)
    settle(window)
    assert changed(plain, window.picture("plain again")) < 0.02
