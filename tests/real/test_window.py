# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""RadTex in Blender's window, a test after another: installed, baking by a click, cancelled, killed, quit."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from time import monotonic, sleep

import numpy as np
import pytest

from tests.real.installable import build_zip, with_wheels
from tests.real.root import Root
from tests.real.window import Window, changed, opened, wait_until

SCENE = """
bpy.ops.object.delete()
bpy.ops.mesh.primitive_plane_add(size=8, location=(0, 0, -1))
bpy.ops.mesh.primitive_monkey_add(size=2)
bpy.ops.object.shade_smooth()
gold = bpy.data.materials.new("Gold")
shader = gold.node_tree.nodes["Principled BSDF"]
shader.inputs["Base Color"].default_value = 1, 0.6, 0.2, 1
shader.inputs["Metallic"].default_value, shader.inputs["Roughness"].default_value = 1, 0.25
bpy.context.object.data.materials.append(gold)
for area in bpy.context.window_manager.windows[0].screen.areas:
    if area.type == "VIEW_3D":
        area.spaces.active.region_3d.view_distance = 8
bpy.ops.ed.undo_push(message="Scene")
bpy.ops.wm.save_as_mainfile(filepath={path!r})
"""
FINGERPRINT = """
import sys
sys.path.append("/repository")
from tests.blender.fingerprint import differences, fingerprint
"""
FORGET = """
import sys
outlook = sys.modules["bl_ext.user_default.radtex.radtex_addon.ui.outlook"]
if bpy.ops.radtex.clear_jobs.poll():
    bpy.ops.radtex.clear_jobs()
states.clear()
"""
SEEN = "sorted(item.name for item in bpy.context.visible_objects if item.type == 'MESH')"
RENDERED = """
space = bpy.context.window_manager.windows[0].screen
space = next(area.spaces.active for area in space.areas if area.type == "VIEW_3D")
bpy.context.scene.render.engine, space.shading.type = {engine!r}, {shading!r}
"""
SECONDS_TO_RENDER = 12
WORKER = "--background"
LONG = {"texels": 128, "bucket": 8, "samples": 16}  # a minute or more on two cores
SHORT = {"texels": 64, "bucket": 4, "samples": 4}


@pytest.fixture(scope="module")
def window(blender_root: Root, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Window]:
    """Blender's window, with the extension installed from a zip of this tree, and a scene to bake."""
    archive = build_zip(tmp_path_factory.mktemp("dist"))
    wheels = sorted((blender_root.path / "wheels").glob("*.whl"))
    with opened(blender_root) as window:
        shutil.copy(with_wheels(archive, wheels), window.folder / "radtex.zip")
        window.ask(
            f"bpy.ops.extensions.package_install_files(filepath={window.inside + '/radtex.zip'!r}, "
            "repo='user_default', enable_on_install=True)"
        )
        window.ask(SCENE.format(path=f"{window.inside}/room.blend"))
        window.show_tab("RadTex")
        yield window


def choose(window: Window, **settings: object) -> None:
    """Set what the panel shows, and wait until it has thought about it."""
    for name, value in settings.items():
        window.ask(f"bpy.context.scene.radtex.{name} = {value!r}")
    window.ask(FORGET)
    sure = "[found.errors for found in outlook._cache.found.values()] == [()]"
    wait_until(lambda: window.value(sure), 20, "the panel knows nothing, or sees what would fail")


def press(window: Window) -> None:
    """Click on the panel's large button."""
    window.click(*window.find("radtex.bake("))
    wait_until(lambda: state(window) != ("", 0.0, ""), 20, "no bake")


def state(window: Window) -> tuple[str, float, str]:
    """State, fraction and message of the latest bake."""
    told = window.value("states[-1:]")
    return tuple(told[0][1:]) if told else ("", 0.0, "")


def wait_for(window: Window, fraction: float) -> None:
    wait_until(lambda: state(window)[1] > fraction, 120, f"the bake does not reach {fraction}")


def test_the_zip_installs(window: Window) -> None:
    addons = window.value("[addon.module for addon in bpy.context.preferences.addons]")
    assert "bl_ext.user_default.radtex" in addons
    origin = window.ask("import importlib.util as u; answer = u.find_spec('xatlas').origin")
    assert origin.startswith(f"{window.inside}/home/extensions/")


def test_the_button_bakes_by_a_click(window: Window) -> None:
    choose(window, **SHORT)
    before = window.shot("panel")
    press(window)
    wait_for(window, 0.1)
    during = window.shot("baking")
    wait_until(lambda: state(window)[0] != "running", 120, "the bake does not end")
    assert state(window)[0] == "done", state(window)[2]
    assert {path.name for path in (window.folder / "radtex").iterdir()} == {
        "Suzanne.radiance.exr",
        "Suzanne.radiance.json",
        "Suzanne.preview.blend",
    }
    after = window.shot("done")
    fractions = [told[2] for told in window.value("states")]
    assert len(set(fractions)) >= 4
    assert fractions == sorted(fractions)
    assert min(changed(before, during), changed(during, after)) > 0.005


def test_the_window_stays_alive_during_a_long_bake(window: Window) -> None:
    choose(window, **LONG | {"samples": 48}, overwrite=True)
    window.ask("ticks.clear()")
    press(window)
    pressed = int(window.value("len(ticks)"))
    wait_for(window, 0.4)
    window.shot("filling")
    wait_until(lambda: state(window)[0] != "running", 600, "the bake does not end")
    gaps = np.diff(window.value("ticks"))
    usual, longest = float(np.percentile(gaps, 99)), float(gaps.max())
    print(f"\n{gaps.sum():.0f} s: 99 % of ticks at most {usual:.3f} s apart, all {longest:.3f} s")
    print(f"when the button was pressed and the scene handed over {gaps[:pressed].max():.3f} s")
    assert state(window)[0] == "done"
    assert usual < 0.2
    assert longest < 1


def test_the_bake_is_shown_and_hidden_by_clicks(window: Window) -> None:
    window.ask(FINGERPRINT)
    window.ask("before = fingerprint()")
    window.click(*window.find("radtex.preview_toggle("))
    wait_until(lambda: "Suzanne (baked)" in window.value(SEEN), 30, "no preview")
    assert "Suzanne" not in window.value(SEEN)
    window.ask(RENDERED.format(shading="RENDERED", engine="CYCLES"))
    sleep(SECONDS_TO_RENDER)
    window.shot("preview")
    window.ask(RENDERED.format(shading="SOLID", engine="BLENDER_EEVEE"))
    window.click(*window.find("radtex.preview_toggle("))  # it has moved, for the panel says more
    wait_until(lambda: window.value(SEEN) == ["Plane", "Suzanne"], 30, "the preview stays")
    assert window.value("sorted(differences(before, fingerprint()))") == []


def test_escape_over_the_sidebar_cancels_within_two_seconds(window: Window) -> None:
    window.ask(FINGERPRINT)
    choose(window, **LONG)
    window.ask("before = fingerprint()")
    press(window)
    wait_for(window, 0.1)
    since = monotonic()
    window.key("Escape")
    wait_until(lambda: not window.processes(WORKER), 10, "the worker goes on")
    print(f"\ncancelled in {monotonic() - since:.1f} s")
    assert monotonic() - since < 2
    wait_until(lambda: state(window)[0] == "cancelled", 2, "nobody says so")
    window.shot("cancelled")
    assert window.value("sorted(differences(before, fingerprint()))") == []


def test_a_killed_worker_is_a_message_and_goes_on_by_resume(window: Window) -> None:
    choose(window, **LONG)
    window.ask("before = fingerprint()")
    press(window)
    wait_for(window, 0.1)
    (worker,) = window.processes(WORKER)
    window.run("kill", "-9", str(worker))
    wait_until(lambda: state(window)[0] == "failed", 5, "nobody notices")
    assert "killed by signal 9" in state(window)[2]
    window.shot("killed")
    assert window.value("sorted(differences(before, fingerprint()))") == []
    choose(window, resume=True)
    press(window)
    wait_until(lambda: state(window)[0] != "running", 600, "the bake does not end")
    assert state(window)[0] == "done", state(window)[2]


def test_quitting_blender_leaves_no_process(window: Window) -> None:
    choose(window, **LONG, resume=False)
    press(window)
    wait_for(window, 0.1)
    assert window.processes(WORKER)
    (window.folder / "ask.py").write_text("bpy.app.timers.register(bpy.ops.wm.quit_blender)")
    wait_until(lambda: not window.processes("blender"), 10, "Blender or its worker is left")
    assert list((window.folder / "home").rglob("radtex-job-*")) == []
