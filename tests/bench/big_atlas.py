# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What large atlases cost: `python -m tests.bench.big_atlas [--sides 4096 8192 16384] [--kind incident]`.

A ball in a world of one colour, 1 sample a cell. Every atlas is baked in a process of its own; its peak of
memory is compared with that of a bake of the same scene that has 16 texels, and costs by the cell are seconds
of the processor without that bake's, which another program on the machine disturbs little.

`python -m tests.bench.big_atlas --layered asset --texels 256 1024 --samples 16 --out DIR` bakes a scene of
the bench of fidelity in the default layout, each atlas in a process of its own, and judges it by `bake.py
report`.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from time import perf_counter, sleep
from typing import Any

import bpy

from radtex_addon.job import bake_object
from radtex_addon.settings.kinds import Kind
from radtex_addon.settings.spec import BakeSpec
from tests.bench.fidelity.scenes import SCENES
from tests.blender import stage

BUCKET = 8
_BAKE = [sys.executable, str(Path(__file__).resolve().parents[2] / "bake.py")]
_LEAST = 16  # texels of the bake that others are compared with


def main() -> None:
    """Bake each atlas, and print the table."""
    keep_lines = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=keep_lines)
    parser.add_argument("--sides", type=int, nargs="+", default=[4096, 8192, 16384], help="in pixels")
    parser.add_argument("--kind", type=Kind, default=Kind.INCIDENT, choices=list(Kind))
    parser.add_argument("--memory", type=int, default=2048, help="MiB that a bake may take beside the scene")
    parser.add_argument("--layered", metavar="SCENE", choices=list(SCENES), help="in the default layout")
    parser.add_argument("--texels", type=int, nargs="+", default=[256, 1024], help="of layered ones")
    parser.add_argument("--samples", type=int, default=16, help="of layered ones")
    parser.add_argument("--out", type=Path, default=Path(tempfile.gettempdir()) / "radtex-big-layered")
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.layered:
        _layered(options.layered, options.texels, options.samples, options.out)
        return
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


def _layered(scene: str, sides: list[int], samples: int, out: Path) -> None:
    """Bake a scene of the bench of fidelity by `bake.py`, at each size; print memory, times and PSNR."""
    out.mkdir(parents=True, exist_ok=True)
    blend = out / f"{scene}.blend"
    stage = SCENES[scene]()
    name = stage.subject.name
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    print("| texels | samples | no file, MiB | resident | disk | minutes | CPU | PSNR, dB | files, MB |")
    print("|---|---|---|---|---|---|---|---|---|", flush=True)
    for side in sides:
        place = out / f"{scene}-{side}-{samples}"
        options = ["--texels", str(side), "--samples", str(samples), "--out", str(place), "--overwrite"]
        used = _watched([*_BAKE, str(blend), "--object", name, *options, "--progress", "none"], place)
        size = sum(path.stat().st_size for path in place.glob("*.exr")) / 1e6
        page = place / "report.html"
        judge = ["report", str(place), "--scene", str(blend), "--out", str(page)]
        judge += ["--pixels", "512", "--samples", "48", "--progress", "json"]
        said = subprocess.run([*_BAKE, *judge], check=True, stdout=subprocess.PIPE, text=True).stdout
        found = re.search(r"([0-9.]+) dB", said)
        psnr = found[1] if found else "?"
        row = [side, samples, *(f"{value:.0f}" for value in used[:3]), f"{used[3]:.1f}", f"{used[4]:.1f}"]
        print(f"| {' | '.join(map(str, row))} | {psnr} | {size:.0f} |", flush=True)


def _watched(command: list[str], place: Path) -> tuple[float, float, float, float, float]:
    """Run a command to its end.

    Returns the most MiB that lay in no file, that were resident, and that the disk lost meanwhile, and the
    minutes by the clock and of processors. Linux only.
    """
    begun = perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    status = Path(f"/proc/{process.pid}/status")
    free = shutil.disk_usage(place.parent).free
    most = [0, 0, 0]
    while os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOHANG | os.WNOWAIT) is None:
        lines = dict(line.split(":", 1) for line in status.read_text().splitlines() if ":" in line)
        now = [int(lines.get(name, "0").split()[0]) >> 10 for name in ("RssAnon", "VmRSS")]
        now.append((free - shutil.disk_usage(place.parent).free) >> 20)
        most = [max(pair) for pair in zip(most, now, strict=True)]
        sleep(0.1)
    _, code, usage = os.wait4(process.pid, 0)
    if code:
        raise SystemExit(f"{command} ended with {code}")
    clock, processors = perf_counter() - begun, usage.ru_utime + usage.ru_stime
    return most[0], most[1], most[2], clock / 60, processors / 60


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
