# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What exports of large atlases take, of memory and time: `python -m tests.bench.big_exports`.

A plane is baked for its preview; its atlas is then replaced by a synthetic one of smooth light with 5 % of
noise, in half floats and buckets of 8 x 8 cells. Each export runs in a process of its own; its peak is that
of the resident memory beyond what it had before the export began, with Blender loaded. Seconds are the
processor's, on one core.

Goal: 1 GiB at most, whatever the side and the target.
"""

from __future__ import annotations

import argparse
import json
import resource
import shutil
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from time import process_time

import numpy as np

from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Floats
from radtex_addon.formats.containers.exr import Compression
from radtex_addon.formats.containers.exr_rows import BandWriter
from radtex_addon.formats.disk.memory import readable_size
from radtex_addon.formats.sidecar import read_sidecar, write_sidecar
from radtex_addon.textures.export_spec import ExportSpec, Target, TextureFormat

ROOT = Path(__file__).parents[2]
NAME = "Plane"
BUCKET = 8
BAND = 64  # rows that are made at once


def bake_plane(folder: Path) -> Path:
    """A small bake of a plane, with its preview, in an empty world; its sidecar."""
    import bpy  # noqa: PLC0415  # the processes that measure load it themselves

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_plane_add()
    scene = folder / "plane.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(scene))
    options = [
        "--layout",
        "buckets",
        "--uv",
        "UVMap",
        "--texels",
        "16",
        "--bucket",
        str(BUCKET),
        "--samples",
        "1",
        "--save-preview",
    ]
    command = [sys.executable, str(ROOT / "bake.py"), str(scene), "--object", NAME, *options]
    subprocess.run([*command, "--out", str(folder)], check=True, capture_output=True)
    return folder / f"{NAME}.radiance.json"


def enlarge(small: Path, side: int, folder: Path) -> Path:
    """The bake with an atlas of `side` pixels, in the folder; its sidecar."""
    path = folder / small.name
    if path.exists():
        return path
    folder.mkdir(parents=True, exist_ok=True)
    texels = side // BUCKET
    sidecar = replace(read_sidecar(small), width=texels, height=texels)
    shutil.copyfile(small.with_name(f"{NAME}.preview.blend"), folder / f"{NAME}.preview.blend")
    image = path.with_suffix(".exr")
    writer = BandWriter(image, side, side, 4, sidecar.to_json(), half=True, packing=Compression.ZIP)
    for top in range(side, 0, -BAND):
        writer.write(light(side, top - BAND))
    writer.close()
    write_sidecar(path, sidecar)
    return path


def light(side: int, first: int) -> Floats:
    """The rows from the number `first` on of an atlas (BAND, side, 4)."""
    x, y = np.arange(side, dtype=np.float32), np.arange(first, first + BAND, dtype=np.float32)[:, None]
    bright = 0.5 + 0.4 * np.sin(x / 700) * np.cos(y / 900) + 0.3 * (x % BUCKET) / BUCKET
    noise = np.random.default_rng(first).uniform(0.95, 1.05, (BAND, side, 3)).astype(np.float32)
    colour = bright[..., None] * np.array([1.0, 0.8, 0.6], np.float32) * noise
    return np.concatenate([colour, np.ones((BAND, side, 1), np.float32)], axis=2)


def peak() -> float:
    """The most memory that this process has had so far, in MB on Linux."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def measure(sidecar: Path, target: Target, form: TextureFormat) -> None:
    """Export once, in this process, and print what it took."""
    from radtex_addon.export.exporting import export_steps  # noqa: PLC0415  # it loads Blender

    before, began = peak(), process_time()
    with tempfile.TemporaryDirectory(dir=sidecar.parent) as folder:
        steps = export_steps(sidecar, ExportSpec(target, form), Path(folder, "out"))
        size = finished(steps).bytes
    facts = {"peak": peak() - before, "seconds": process_time() - began, "bytes": size}
    print(json.dumps(facts))


def row(sidecar: Path, target: Target, form: TextureFormat) -> str:
    """A line of the table."""
    command = [sys.executable, "-m", "tests.bench.big_exports", "--one", str(sidecar), target, form]
    ended = subprocess.run(command, check=True, capture_output=True, text=True, cwd=ROOT)
    facts = json.loads(ended.stdout.splitlines()[-1])
    return f"{facts['peak']:6.0f} | {facts['seconds']:7.1f} | {readable_size(facts['bytes']):>9} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--sides", type=int, nargs="+", default=[4096, 8192, 16384], help="of the atlases, pixels"
    )
    parser.add_argument("--targets", nargs="+", type=Target, default=list(Target))
    parser.add_argument("--formats", nargs="+", type=TextureFormat, default=[TextureFormat.AUTO])
    parser.add_argument("--work", type=Path, help="where atlases stay, for the next time")
    parser.add_argument("--one", nargs=3, help=argparse.SUPPRESS)
    found = parser.parse_args()
    if found.one:
        measure(Path(found.one[0]), Target(found.one[1]), TextureFormat(found.one[2]))
        return
    with tempfile.TemporaryDirectory() as temporary:
        work = found.work or Path(temporary)
        work.mkdir(parents=True, exist_ok=True)
        small = work / f"{NAME}.radiance.json"
        small = small if small.exists() else bake_plane(work)
        print(
            "| pixels a side | target | format | peak, MB | CPU seconds | files |\n|---|---|---|---|---|---|"
        )
        for side in found.sides:
            sidecar = enlarge(small, side, work / str(side))
            for target in found.targets:
                for form in found.formats:
                    print(f"| {side} | {target} | {form} | {row(sidecar, target, form)}", flush=True)


if __name__ == "__main__":
    main()
