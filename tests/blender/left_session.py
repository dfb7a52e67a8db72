# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A session of its own that queues fifteen bakes and ends amid them: a script for a process.

python left_session.py FOLDER quit|killed

Three bakes fail, since a file lies where their folder must go, and one is cancelled. Once all of them have
ended and another bake renders, it prints "ready"; then it quits, as Blender does, or waits to be killed.
"""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from pathlib import Path
from time import sleep
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import bpy

from radtex_addon.settings.spec import BakeSpec
from radtex_addon.ui import registration
from radtex_addon.ui.jobs import jobs
from radtex_addon.worker.handover import hand_over
from radtex_addon.worker.orders import order_bake

FAILING = ("Card 00", "Card 03", "Card 05")
CANCELLED = "Card 01"
RUNNING = "Card 06"  # rather long
DONE = ("Card 02", "Card 04")
TINY = BakeSpec(texels=4, bucket=2, samples=1, uv_layer="UVMap")
LONG = replace(TINY, texels=64, bucket=8, samples=32)


def main() -> None:
    folder, manner = Path(sys.argv[1]), sys.argv[2]
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    for number in range(15):
        bpy.ops.mesh.primitive_plane_add(size=1, location=(2 * number, 0, 0))
        item: Any = bpy.context.object
        item.name = f"Card {number:02}"
    scene: Any = bpy.context.scene
    scene.world = bpy.data.worlds.new("Light")
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "cards.blend"))
    registration.register()
    jobs.take_over(folder / "lists")
    (folder / "file").write_text("here no folder can be made")
    handover = hand_over(scene, folder / "cache")
    names = [item.name for item in scene.objects]
    jobs.add(
        order_bake(
            handover,
            name,
            LONG if name == RUNNING else TINY,
            folder / "file" if name in FAILING else folder / "out",
        )
        for name in sorted(names)
    )
    jobs.cancel(2)
    while not (jobs.snapshot()[6].stage == "capture" and jobs.snapshot()[6].fraction > 0.1):
        jobs.advance()
        sleep(0.05)
    queue = jobs._session.queue
    assert queue is not None
    assert queue._running is not None
    print("ready", os.getpid(), queue._running[1].pid, flush=True)
    if manner == "quit":
        return  # without a word to the add-on: Python's end must do
    while True:
        jobs.advance()
        sleep(0.05)


if __name__ == "__main__":
    main()
