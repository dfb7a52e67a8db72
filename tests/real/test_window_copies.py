# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""In Blender's window: a view that shows no bake offers shadings that do, and copies have their buttons."""

from __future__ import annotations

from time import sleep

from tests.real.panel import SHORT, bake, settle
from tests.real.window import Window, wait_until

SHADING = "room._view().spaces.active.shading.type"
QUADS = """
window = bpy.context.window_manager.windows[0]
area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
region = next(region for region in area.regions if region.type == "WINDOW")
with bpy.context.temp_override(window=window, area=area, region=region):
    bpy.ops.{}()
"""
_PIE = 700, 400  # where the pie menu opens; what it has on the right is so many pixels away
_COMPILED = 20  # seconds for Eevee's shaders, for the picture alone
_OPENED = 3  # seconds for a menu, which Mesa's software drivers draw
_RIGHT = 130
_BELOW = range(92, 29, -8)  # pixels below the preview's button: the shadings, the last one first


def test_a_view_that_shows_no_bake_offers_shadings_that_do(window: Window) -> None:
    bake(window, **SHORT)
    window.ask("room._view().spaces.active.shading.type = 'SOLID'")
    x, y = window.find("radtex.preview_toggle(")
    window.click(x, y)
    wait_until(lambda: "Suzanne (baked)" in window.value("room.seen()"), 30, "the bake is not shown")
    settle(window)
    window.shot("solid-offer")
    for below in _BELOW:
        if window.value(SHADING) == "SOLID":
            window.click(x + 40, y + below)
    assert window.value(SHADING) == "RENDERED"
    window.shot("solid-taken")


def test_the_pie_menu_offers_them_at_the_mouse(window: Window) -> None:
    window.ask("bpy.ops.radtex.preview_toggle(object='Suzanne', action='OFF')")
    window.ask("room._view().spaces.active.shading.type = 'SOLID'")
    settle(window)
    window.key("ctrl+shift+b", over_view=True)
    sleep(_OPENED)
    window.shot("pie")
    window.click(_PIE[0] + _RIGHT, _PIE[1])
    wait_until(lambda: "Suzanne (baked)" in window.value("room.seen()"), 30, "the bake is not shown")
    sleep(_OPENED)
    window.shot("pie-offer")
    window.run("xdotool", "click", "1")  # on what the offer has under the mouse
    wait_until(lambda: window.value(SHADING) != "SOLID", 10, "no shading is chosen")


def test_local_view_and_four_views_show_bakes_too(window: Window) -> None:
    for operator in ("view3d.localview", "screen.region_quadview"):
        window.ask("room._view().spaces.active.shading.type = 'SOLID'")
        window.ask("bpy.ops.radtex.preview_toggle(object='Suzanne', action='OFF')")
        window.ask("room.select('Suzanne')")
        window.ask(QUADS.format(operator))
        window.ask("bpy.ops.radtex.preview_toggle(object='Suzanne', action='ON')")
        settle(window)
        window.shot(f"offer-{operator.rpartition('.')[2]}")
        assert "Suzanne (baked)" in window.value("room.seen()")
        window.ask(QUADS.format(operator))


def test_a_copy_has_buttons_of_its_own(window: Window) -> None:
    window.ask("bpy.ops.radtex.preview_toggle(object='Suzanne', action='OFF')")
    window.ask("room._view().spaces.active.shading.type = 'MATERIAL'")
    window.ask("bpy.ops.radtex.apply_to_copy(object='Suzanne')")
    settle(window)
    sleep(_COMPILED)
    window.shot("copy")
    window.key("ctrl+shift+b", over_view=True)
    sleep(_OPENED)
    window.shot("copy-pie")
    window.key("Escape")
    window.click(*window.find("radtex.select_original("))
    wait_until(lambda: window.value("bpy.context.active_object.name") == "Suzanne", 10, "it is not selected")
    window.ask("room.select('Suzanne (baked copy)')")
    settle(window)
    window.click(*window.find("radtex.delete_copy("))
    wait_until(lambda: "Suzanne (baked copy)" not in window.value("room.seen()"), 10, "it is not deleted")
    assert not window.value("'Radiance Textures' in bpy.data.collections")


def test_finished_bake_chooses_among_bakes_of_several_names(window: Window) -> None:
    window.ask("room.select('Suzanne')")
    for name, texels in (("draft", 16), ("final", 32)):
        window.ask(f"bpy.context.scene.radtex.bake_name = '{{object}}.{name}'")
        bake(window, **{**SHORT, "texels": texels})
    window.ask("bpy.ops.radtex.preview_toggle(object='Suzanne', action='ON')")
    assert "Suzanne.final (baked)" in window.value("room.seen()")
    settle(window)
    window.ask(QUADS.format("view3d.view_all"))
    window.scroll(30)
    window.shot("named")
    window.click(*window.find('called="Suzanne.draft"'))
    wait_until(lambda: "Suzanne.draft (baked)" in window.value("room.seen()"), 30, "it is not shown instead")
    settle(window)
    window.shot("named-other")
