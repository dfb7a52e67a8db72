# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A session of its own that bakes by a worker, as Blender's window does: a script for a process.

python worker_parent.py BLEND JOBS OUT stay|leave

It opens BLEND, hands it over below JOBS and bakes its card into OUT, which takes a day. It prints the
worker's process id, then "capture" as soon as that renders; "leave" ends Python then, "stay" goes on.
"""

from __future__ import annotations

import sys
from pathlib import Path
from time import sleep

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import bpy

from radtex_addon.settings.spec import BakeSpec
from radtex_addon.worker.handover import hand_over, this_program
from radtex_addon.worker.orders import order_bake
from radtex_addon.worker.queue import Queue


def main() -> None:
    blend, jobs, out, manner = sys.argv[1:]
    bpy.ops.wm.open_mainfile(filepath=blend)
    spec = BakeSpec(texels=16, bucket=2, samples=10_000_000, uv_layer="UVMap")
    scene = bpy.context.scene
    assert scene is not None
    queue = Queue(this_program())
    queue.add(order_bake(hand_over(scene, Path(jobs)), "Card", spec, Path(out)))
    queue.advance()
    assert queue._running is not None
    print("worker", queue._running[1].pid, flush=True)
    rendering = False
    while queue.advance():
        if queue.snapshot()[0].stage == "capture" and not rendering:
            rendering = True
            print("capture", flush=True)
            if manner == "leave":
                return
        sleep(0.05)


if __name__ == "__main__":
    main()
