# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How a bake ends in Blender's window: told where nobody sees the list, cancelled, refused, killed, quit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from time import monotonic

from tests.real.panel import (
    CROSS,
    LONG,
    SHORT,
    WORKER,
    choose,
    jobs,
    latest,
    press,
    start_again,
    wait_for,
    wait_for_end,
)
from tests.real.window import Window, changed, wait_until

AWAY = 500, 600  # a place in the 3D view
HEADER = """
window = bpy.context.window_manager.windows[0]
area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
region = next(region for region in area.regions if region.type == "HEADER")
answer = region.x + region.width, window.height - region.y - region.height, region.height
"""


def test_the_end_is_told_while_the_sidebar_is_hidden_and_a_click_opens_the_list(window: Window) -> None:
    choose(window, **SHORT)
    window.key("n", over_view=True)
    wait_until(lambda: window._sidebar()[2] <= 1, 10, "the sidebar stays")
    right, top, height = window.ask(HEADER)
    line = right - 190, top, right, top + height
    before = window.picture("hidden").crop(line)
    window.ask("bpy.ops.radtex.bake('EXEC_DEFAULT')")
    assert wait_for_end(window).state == "done"
    wait_until(lambda: "RadTex: Baked Suzanne in" in window.said(), 20, "nothing in the status bar")
    assert changed(before, window.shot("told").crop(line)) > 0.1
    window.click(right - 90, top + height // 2)
    wait_until(lambda: window._sidebar()[2] > 1 and window._sidebar()[4] == "RadTex", 10, "no list")
    window.point(*AWAY)  # from the button that is in the line's place now
    assert changed(before, window.picture("opened").crop(line)) < 0.05


def test_escape_over_the_sidebar_cancels_within_two_seconds(window: Window) -> None:
    choose(window, **LONG)
    window.ask("room.remember('before')")
    press(window)
    wait_for(window, 0.1)
    since = monotonic()
    window.key("Escape")
    wait_until(lambda: not window.processes(WORKER), 10, "the worker goes on")
    print(f"\ncancelled in {monotonic() - since:.1f} s")
    assert monotonic() - since < 2
    wait_until(lambda: latest(window).state == "cancelled", 2, "nobody says so")
    window.shot("cancelled")
    assert window.value("room.changes('before')") == []


def test_a_folder_that_takes_nothing_any_more_is_a_message(window: Window) -> None:
    folder = f"{window.inside}/elsewhere"
    with read_only_later(window, folder) as make_read_only:
        choose(window, **LONG, directory=folder)
        window.ask("room.remember('before')")
        press(window)
        wait_for(window, 0.1)
        window.run(*make_read_only)
        told = wait_for_end(window)
        assert told.state == "failed"
        assert folder in told.message
        assert "Read-only file system" in told.message
        window.shot("read-only")
        assert window.value("room.changes('before')") == []


def test_a_killed_worker_is_a_message_and_goes_on_by_resume(window: Window) -> None:
    choose(window, **LONG, directory="//radtex/", overwrite=True)
    window.ask("room.remember('before')")
    press(window)
    wait_for(window, 0.1)
    (worker,) = window.processes(WORKER)
    window.run("kill", "-9", str(worker))
    wait_until(lambda: latest(window).state == "failed", 5, "nobody notices")
    assert "killed by signal 9" in latest(window).message
    window.shot("killed")
    assert window.value("room.changes('before')") == []
    window.ask("bpy.context.scene.radtex.overwrite = False")
    window.click(*window.find("resume=True", right=CROSS))
    wait_until(lambda: latest(window).state != "failed", 5, "it does not go on")
    told = wait_for_end(window, 280)
    assert told.state == "done", told.message


def test_quitting_blender_leaves_no_process_and_the_next_start_goes_on(window: Window) -> None:
    choose(window, **LONG, directory="//quit/")
    press(window)
    wait_for(window, 0.1)
    assert window.processes(WORKER)
    (window.folder / "ask.py").write_text("bpy.app.timers.register(bpy.ops.wm.quit_blender)")
    wait_until(lambda: not window.processes("blender"), 10, "Blender or its worker is left")
    assert list((window.folder / "home").rglob("radtex-list-*.json")), "the list is kept"
    start_again(window, "")
    wait_until(lambda: [job.state for job in jobs(window)] == ["left"], 20, "no bake at the next start")
    window.show_tab("RadTex")
    window.shot("left")
    window.click(*window.find("radtex.go_on("))
    wait_until(lambda: latest(window).state == "running", 20, "it does not go on")
    told = wait_for_end(window, 280)
    assert told.state == "done", told.message
    assert list((window.folder / "home").rglob("radtex-job-*")) == []


@contextmanager
def read_only_later(window: Window, folder: str) -> Iterator[Sequence[str]]:
    """A new folder on Blender's side, and the command that makes it read-only, even to its administrator.

    It mounts the folder over itself: what the worker holds open, such as its lock, keeps an older mount from
    being made read-only.
    """
    window.run("mkdir", folder)
    mount = 'mount --bind "$0" "$0"; until mount -o remount,ro,bind "$0" 2>/dev/null; do sleep 0.01; done'
    yield "timeout", "20", "sh", "-c", mount, folder
    window.run("umount", folder)
