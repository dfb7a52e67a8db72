# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The artist's tutorial (docs/tutorials/artist.md) in Blender's window, a step after another.

With RADTEX_FIGURES=docs/figures it makes the tutorial's pictures again, `tutorial-*.png`.
"""

from __future__ import annotations

import io
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from time import sleep

import numpy as np
import PIL.Image
import pytest
from playwright.sync_api import BrowserType

from tests.real.browser import SOFTWARE_GL, Shown, chromium, served, tab_of
from tests.real.panel import install, latest, wait_for, wait_for_end
from tests.real.root import Root
from tests.real.window import Window, opened, wait_until

_FIGURES = os.environ.get("RADTEX_FIGURES")
_WIDTH = 1000  # pixels of a kept picture at most
_VIEW = 0, 26, 1292, 812  # the 3D view with its sidebar, left, top, right and bottom
_FLOOR = 150, 500, 450, 780  # in the 3D view
_WORDS = 66, 128, 300, 146  # where Eevee says that it compiles shaders
_WHITE = 210  # of 255
_PANEL = 1030, 66, 1292, 640
_DIALOG = 700, 480, 1292, 880  # the export dialog, which opens below the mouse
_PICTURES = 42, 46, 1560, 625  # in the window that a comparison opens
_SECONDS_TO_COMPILE = 280  # shaders of Eevee, on a processor that does much else
_SECONDS_TO_SMOOTH = 6  # edges, by drawing them several times
_SHADED = 15  # of 255, how much a floor of tiles varies at least; without its material it is even
_SECONDS_TO_DRAW = 6  # a new window
_KNOWN = "[str(found.next) for found in panel_state._cache.found.values()]"
_PREFERENCES = """
bpy.context.preferences.active_section = "EXTENSIONS"
area = next(area for area in bpy.context.window_manager.windows[0].screen.areas if area.type == "VIEW_3D")
area.ui_type = "PREFERENCES"
bpy.context.preferences.addons["bl_ext.user_default.radtex"].preferences.export_target = "web"
"""
_VIEW_AGAIN = """
area = next(a for a in bpy.context.window_manager.windows[0].screen.areas if a.type == "PREFERENCES")
area.ui_type = "VIEW_3D"
"""
_MENU = 1293, 72  # the arrow at the right of the page Get Extensions
_INSTALL = 0, 26, 1600, 400

# A glazed vase, a profile that a Screw modifier turns, between two balls on a tiled table, in an HDRI that
# Blender ships.
_SCENE = """
import bpy, math
from pathlib import Path
bpy.ops.object.select_all(action="SELECT")
bpy.ops.object.delete()
profile = [(0.0, 0), (0.62, 0), (0.66, 0.05), (0.6, 0.12), (0.42, 0.2), (0.4, 0.26), (0.7, 0.55),
           (0.95, 1.0), (0.92, 1.45), (0.62, 1.85), (0.36, 2.1), (0.34, 2.3), (0.55, 2.5), (0.57, 2.55),
           (0.5, 2.53), (0.28, 2.3)]
mesh = bpy.data.meshes.new("Vase")
mesh.from_pydata([(x, 0, z) for x, z in profile], [(k, k + 1) for k in range(len(profile) - 1)], [])
vase = bpy.data.objects.new("Vase", mesh)
bpy.context.collection.objects.link(vase)
screw = vase.modifiers.new("Screw", "SCREW")
screw.steps = screw.render_steps = 32
screw.use_merge_vertices, screw.use_normal_calculate = True, True
smooth = vase.modifiers.new("Subdivision", "SUBSURF")
smooth.levels = smooth.render_levels = 1
def material(name, colour, metallic, roughness, coat=0.0):
    made = bpy.data.materials.new(name)
    inputs = made.node_tree.nodes["Principled BSDF"].inputs
    inputs["Base Color"].default_value = *colour, 1
    inputs["Metallic"].default_value, inputs["Roughness"].default_value = metallic, roughness
    inputs["Coat Weight"].default_value = coat
    return made
mesh.materials.append(material("Glaze", (0.02, 0.12, 0.3), 0, 0.35, 1.0))
bpy.ops.mesh.primitive_plane_add(size=9)
table = bpy.context.object
table.name = "Table"
tiles = material("Tiles", (0.5, 0.5, 0.5), 0, 0.4)
checker = tiles.node_tree.nodes.new("ShaderNodeTexChecker")
checker.inputs["Scale"].default_value = 9
checker.inputs["Color1"].default_value = 0.75, 0.7, 0.62, 1
checker.inputs["Color2"].default_value = 0.18, 0.16, 0.15, 1
tiles.node_tree.links.new(checker.outputs[0], tiles.node_tree.nodes["Principled BSDF"].inputs["Base Color"])
table.data.materials.append(tiles)
for name, place, colour, metallic in (("Orange", (1.5, -0.9, 0.45), (0.8, 0.25, 0.02), 0),
                                      ("Steel", (-1.5, -0.6, 0.4), (0.8, 0.8, 0.8), 1)):
    bpy.ops.mesh.primitive_uv_sphere_add(radius=place[2], location=place)
    bpy.ops.object.shade_smooth()
    bpy.context.object.name = name
    bpy.context.object.data.materials.append(material(name, colour, metallic, 0.15))
world = bpy.context.scene.world
sky = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
folder = Path(bpy.utils.resource_path("SYSTEM"), "datafiles", "studiolights", "world")
sky.image = bpy.data.images.load(str(folder / "interior.exr"))
world.node_tree.links.new(sky.outputs[0], world.node_tree.nodes["Background"].inputs["Color"])
room.select("Vase")
view = room._view().spaces.active
view.region_3d.view_distance = 7
view.region_3d.view_location = 0, 0, 1.1
view.shading.type = "MATERIAL"
view.shading.use_scene_world = True
"""


@pytest.fixture(scope="module")
def fresh(blender_root: Root, window_zip: Path) -> Iterator[Window]:
    """Blender as it starts the first time, RadTex installed from the zip."""
    with opened(blender_root) as window:
        install(window, window_zip)
        yield window
        assert "Traceback" not in window.said(), window.said()
        shutil.rmtree(window.folder / "radtex", ignore_errors=True)


def test_the_preferences_install_from_a_disk(fresh: Window) -> None:
    fresh.ask(_PREFERENCES)
    sleep(_SECONDS_TO_DRAW)
    fresh.click(*_MENU)
    sleep(_SECONDS_TO_DRAW)
    keep(fresh, "install", _INSTALL)
    fresh.key("Escape")
    fresh.ask(_VIEW_AGAIN)


def test_the_panel_is_ready_to_bake(fresh: Window) -> None:
    fresh.ask(_SCENE)
    fresh.ask(f"bpy.ops.wm.save_as_mainfile(filepath={fresh.inside + '/vase.blend'!r})")
    fresh.show_tab("RadTex")
    wait_until(lambda: fresh.value(_KNOWN) == ["bake"], 30, "the button is not ready")
    wait_until_shaded(fresh)
    keep(fresh, "panel", _VIEW)


def test_the_button_bakes(fresh: Window) -> None:
    shade(fresh, "SOLID")  # so that the processor is the bake's
    fresh.click(*fresh.find("radtex.bake("))
    wait_until(lambda: fresh.value("jobs()"), 20, "no bake")
    wait_for(fresh, 0.5)
    keep(fresh, "baking", _PANEL)
    ends(fresh, 0)
    wait_until(lambda: fresh.value(_KNOWN) == ["replace"], 30, "the panel does not see the bake")


def test_the_bake_is_shown_by_eevee(fresh: Window) -> None:
    fresh.click(*fresh.find("radtex.preview_toggle("))
    wait_until(lambda: "Vase (baked)" in fresh.value("room.seen()"), 30, "the bake is not seen")
    shade(fresh, "MATERIAL")
    wait_until_shaded(fresh)
    keep(fresh, "preview", _VIEW)


def test_it_is_compared_with_cycles(fresh: Window) -> None:
    shade(fresh, "SOLID")
    number = latest(fresh).number
    fresh.scroll(30)
    fresh.click(*fresh.find("radtex.compare("))
    fresh.key("Return")
    ends(fresh, number)
    fresh.ask(f"bpy.ops.radtex.show_comparison(number={latest(fresh).number})")
    wait_until(lambda: fresh.value("len(bpy.context.window_manager.windows)") == 2, 10, "no pictures")
    fresh.point(500, 400)  # Blender draws a window that the mouse comes to
    sleep(_SECONDS_TO_DRAW)
    keep(fresh, "compare", _PICTURES)
    fresh.ask("room.close_other_windows()")


def test_the_dialog_exports_it(fresh: Window) -> None:
    shade(fresh, "MATERIAL")
    number = latest(fresh).number
    fresh.scroll(30)
    fresh.click(*fresh.find("radtex.export("))
    sleep(_SECONDS_TO_DRAW)
    keep(fresh, "export", _DIALOG)
    fresh.key("Return")
    ends(fresh, number)
    assert (fresh.folder / "radtex/vase/Vase.web/index.html").is_file()


def test_a_browser_shows_it(fresh: Window, root: Root, driver: BrowserType) -> None:
    with served(fresh.folder / "radtex" / "vase") as address, chromium(root, driver, *SOFTWARE_GL) as browser:
        page = tab_of(browser, viewport={"width": 1000, "height": 640})
        page.goto(f"{address}/Vase.web/")
        Shown(page).wait()
        page.keyboard.press("c")
        Shown(page).still()
        with PIL.Image.open(io.BytesIO(page.screenshot())) as picture:
            keep_picture(picture.convert("RGB"), "browser")


def ends(window: Window, number: int) -> None:
    """Wait until the job after the one of that number has ended well; 0 if there was none."""
    wait_until(lambda: latest(window).number > number, 20, "no job")
    told = wait_for_end(window, 280)
    assert told.state == "done", told.message


def shade(window: Window, how: str) -> None:
    """How the 3D view is drawn."""
    window.ask(f"room._view().spaces.active.shading.type = {how!r}")


def wait_until_shaded(window: Window) -> None:
    """Wait until Eevee has compiled all shaders and drawn the 3D view, and its edges are smooth."""
    sleep(_SECONDS_TO_SMOOTH)
    wait_until(lambda: is_shaded(window.picture("shading").convert("L")), _SECONDS_TO_COMPILE, "no shaders")
    sleep(_SECONDS_TO_SMOOTH)


def is_shaded(screen: PIL.Image.Image) -> bool:
    """Whether the floor shows its tiles, and no white words say that shaders are being compiled."""
    floor, words = (np.asarray(screen.crop(box)) for box in (_FLOOR, _WORDS))
    return bool(floor.std() > _SHADED and words.max() < _WHITE)


def keep(window: Window, name: str, box: tuple[int, int, int, int] | None = None) -> None:
    """A picture of the screen, or of that box of it, with the figures where those are wanted."""
    keep_picture(window.picture(name).crop(box), name)


def keep_picture(picture: PIL.Image.Image, name: str) -> None:
    """The same of any picture, in 256 colours."""
    if not _FIGURES:
        return
    if picture.width > _WIDTH:
        size = _WIDTH, round(picture.height * _WIDTH / picture.width)
        picture = picture.resize(size, PIL.Image.Resampling.LANCZOS)
    picture.quantize(256).save(Path(_FIGURES, f"tutorial-{name}.png"), optimize=True)
