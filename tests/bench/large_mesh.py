# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake of a mesh of millions of triangles takes: time by stage, and most memory, of the whole process.

python -m tests.bench.large_mesh [--triangles 5000000] [--unwrap blender|xatlas] [--folder DIR]

Without --unwrap the grid's own UV layer is baked on. The bake is small (32 texels, 2 x 2 cells, 1 path each),
so that what is measured is the mesh. For comparison: the same file opened and rendered by Cycles alone.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
_MAKE = """
import bpy, sys
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.mesh.primitive_grid_add(x_subdivisions=int(sys.argv[2]), y_subdivisions=int(sys.argv[2]))
bpy.context.object.name = "Grid"
bpy.ops.object.light_add(type="SUN")
bpy.ops.object.camera_add(location=(0, 0, 4))
scene = bpy.context.scene
scene.camera, scene.render.engine, scene.cycles.samples = bpy.context.object, "CYCLES", 1
scene.render.resolution_x = scene.render.resolution_y = 64
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[1], compress=False)
"""
_RENDER = """
import bpy, sys
bpy.ops.wm.open_mainfile(filepath=sys.argv[1])
bpy.ops.render.render()
"""


def measured(command: list[str]) -> tuple[float, float, int, str]:
    """Run it; returns seconds, most memory in GB, the exit code and the standard output."""
    since = time.perf_counter()
    with tempfile.TemporaryFile("w+") as out:
        process = subprocess.Popen(command, cwd=ROOT, stdout=out)
        _, status, used = os.wait4(process.pid, 0)
        out.seek(0)
        text = out.read()
    code = os.waitstatus_to_exitcode(status)
    return time.perf_counter() - since, used.ru_maxrss * 1024 / 1e9, code, text


def main() -> None:
    """Make the file, render it, bake it, and print what that took."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--triangles", type=int, default=5_000_000)
    parser.add_argument("--unwrap", choices=("blender", "xatlas"))
    parser.add_argument("--folder", type=Path)
    asked = parser.parse_args()
    side = math.ceil(math.sqrt(asked.triangles / 2))
    with tempfile.TemporaryDirectory(dir=asked.folder) as folder:
        scene = str(Path(folder, "grid.blend"))
        for what, command in (
            ("made", ["-c", _MAKE, scene, str(side)]),
            ("rendered by Cycles alone", ["-c", _RENDER, scene]),
        ):
            seconds, memory, code, _ = measured([sys.executable, *command])
            print(
                f"{2 * side**2:,} triangles {what}: {seconds:.1f} s, {memory:.2f} GB (exit {code})",
                flush=True,
            )
        surface = ["--unwrap", asked.unwrap] if asked.unwrap else ["--uv", "UVMap"]
        bake = ["bake.py", scene, "--object", "Grid", "--out", str(Path(folder, "out")), *surface]
        size = [
            "--layout",
            "buckets",
            "--texels",
            "32",
            "--bucket",
            "2",
            "--samples",
            "1",
            "--progress",
            "json",
        ]
        seconds, memory, code, text = measured([sys.executable, *bake, *size])
        done: list[dict[str, Any]] = [json.loads(line) for line in text.splitlines()[-1:]]
        stages = done[0].get("seconds", {}) if done else {}
        print(f"baked: {seconds:.1f} s, {memory:.2f} GB (exit {code}); by stage {stages}", flush=True)


if __name__ == "__main__":
    main()
