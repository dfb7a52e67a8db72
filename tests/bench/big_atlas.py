# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What large atlases cost: `python -m tests.bench.big_atlas [--sides 4096 8192 16384] [--kind incident]`.

A ball in a world of one colour, 1 sample a cell. Every atlas is baked in a process of its own; its peak of
memory is compared with that of a bake of the same scene that has 16 texels, and costs by the cell are seconds
of the processor without that bake's, which another program on the machine disturbs little.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import bpy

from radtex_addon.job import bake_object
from radtex_addon.settings.kinds import Kind
from radtex_addon.settings.spec import BakeSpec
from tests.blender import stage

BUCKET = 8
_LEAST = 16  # texels of the bake that others are compared with


def main() -> None:
    """Bake each atlas, and print the table."""
    keep_lines = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=keep_lines)
    parser.add_argument("--sides", type=int, nargs="+", default=[4096, 8192, 16384], help="in pixels")
    parser.add_argument("--kind", type=Kind, default=Kind.INCIDENT, choices=list(Kind))
    parser.add_argument("--memory", type=int, default=2048, help="MiB that a bake may take beside the scene")
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        _bake(options.one, options.kind, options.memory)
        return
    least = _measured(_LEAST * BUCKET, options)
    print(f"{options.kind}, --memory {options.memory} MiB; 16 texels peak at {least['peak'] / 1e6:.0f} MB\n")
    print("| pixels | cells, M | peak above, MB | CPU, s | ns a cell | of the first | s | by stage |")
    print("|---|---|---|---|---|---|---|---|")
    first = 0.0
    for side in options.sides:
        found = _measured(side, options)
        cells = found["cells"]
        cpu = found["cpu"] - least["cpu"]
        cost = cpu / cells * 1e9
        first = first or cost
        stages = ", ".join(
            f"{stage} {seconds:.0f}" for stage, seconds in found["stages"].items() if seconds > 1
        )
        above = (found["peak"] - least["peak"]) / 1e6
        row = [f"{side} x {side}", f"{cells / 1e6:.1f}", f"{above:.0f}", f"{cpu:.0f}", f"{cost:.0f}"]
        row += [f"{cost / first:.3f}", f"{sum(found['stages'].values()):.0f}", stages]
        print(f"| {' | '.join(row)} |", flush=True)


def _measured(side: int, options: argparse.Namespace) -> dict[str, Any]:
    command = [sys.executable, "-m", "tests.bench.big_atlas", f"--one={side}"]
    command += [f"--kind={options.kind}", f"--memory={options.memory}"]
    said = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    found: dict[str, Any] = json.loads(said.splitlines()[-1])
    return found


def _bake(side: int, kind: Kind, memory_mb: int) -> None:
    """One bake; the last line says what it took, in JSON."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    stage.world()
    bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32)
    ball: Any = bpy.context.object
    ball.data.materials.append(stage.material("matt", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1)))
    texels = side // BUCKET
    spec = BakeSpec(
        kind=kind,
        texels=texels,
        bucket=BUCKET,
        samples=1,
        uv_layer="UVMap",
        memory_mb=memory_mb,
        device="cpu",
    )
    scene: Any = bpy.context.scene
    with tempfile.TemporaryDirectory(prefix="radtex-big-") as folder:
        result = bake_object(scene, ball.name, spec, Path(folder))
    used = resource.getrusage(resource.RUSAGE_SELF)
    print(
        "\n"
        + json.dumps(
            {
                "cells": result.covered_texels * BUCKET**2,
                "peak": used.ru_maxrss * 1024,
                "cpu": used.ru_utime + used.ru_stime,
                "stages": {str(stage): seconds for stage, seconds in result.seconds.items()},
            }
        )
    )


if __name__ == "__main__":
    main()
