# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Evaluates objects with every modifier again and again: `python -m tests.bench.evaluations --times 10`.

Each evaluation has a process of its own, which reads the digests that `--resume`, `--changed` and farms
compare. A table names the objects whose digests are not the same to the last bit each time; all of them must
be like the first, or the exit code is 1. With `--threads N` every other process has so many of the machine's
processors. On Linux.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, TypeAlias

import bpy

from radtex_addon.core.near_digest import NearDigest
from radtex_addon.scene.digests import looks_of, read_scene, scene_digests
from radtex_addon.scene.geometry_digests import mesh_digest
from radtex_addon.scene.mesh.evaluated import evaluate
from radtex_addon.scene.scratch import scratch_scene
from tests.blender.modifier_stacks import STACKS, add_stack

Digests: TypeAlias = dict[str, NearDigest]  # by what reads it, and the object
context: Any = bpy.context  # to the stubs, every pointer may be None

_COLUMNS = 10  # objects in a row of the scene
_NO_FACES = ("build",)  # stacks that show nothing at the first frame


def save_stacks(path: Path) -> None:
    """A .blend of all stacks."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    for number, name in enumerate(STACKS):
        add_stack(name, (4 * (number % _COLUMNS), 4 * (number // _COLUMNS), 0))
    bpy.ops.wm.save_as_mainfile(filepath=str(path))


def read(path: Path) -> Digests:
    """All digests of a .blend."""
    bpy.ops.wm.open_mainfile(filepath=str(path))
    found: Digests = {}
    with scratch_scene(context.scene) as scratch:
        for each in read_scene(scratch).objects:
            if not each.is_instance:
                found[f"fingerprint {each.of}"] = each.mesh
        found |= {f"farm {name}": look for name, look in looks_of(scratch).items()}
        for name in STACKS:
            if name not in _NO_FACES:
                found[f"bake {name}"] = mesh_digest(evaluate(scratch, scratch.objects[name]))
        found["bake all"] = NearDigest.parse(scene_digests(scratch)["objects"])
    return found


def _in_a_process(blend: Path, out: Path, processors: int | None) -> Digests:
    few = set(range(processors)) if processors else os.sched_getaffinity(0)
    subprocess.run(
        [sys.executable, "-m", "tests.bench.evaluations", "--read", str(blend), str(out)],
        check=True,
        stdout=subprocess.DEVNULL,
        preexec_fn=lambda: os.sched_setaffinity(0, few),
    )
    return {
        name: NearDigest(exact, of, tuple(sums))
        for name, (exact, of, sums) in json.loads(out.read_text()).items()
    }


def main() -> None:
    """Evaluate, and say what differs."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--times", type=int, default=10)
    parser.add_argument("--threads", type=int)
    parser.add_argument("--read", nargs=2, type=Path, metavar=("BLEND", "OUT"), help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.read:
        blend, out = options.read
        digests = {name: [each.exact, each.of, each.sums] for name, each in read(blend).items()}
        out.write_text(json.dumps(digests))
        return
    with tempfile.TemporaryDirectory() as folder:
        blend = Path(folder, "stacks.blend")
        save_stacks(blend)
        runs = [
            _in_a_process(blend, Path(folder, "read.json"), options.threads if number % 2 else None)
            for number in range(options.times)
        ]
    first = runs[0]
    unlike = {name for name in first for run in runs if not first[name].is_like(run[name])}
    print("| digest | exact ones | greatest difference of sums | |\n|---|---|---|---|")
    for name, digest in first.items():
        exact = {run[name].exact for run in runs}
        if len(exact) > 1:
            pairs = [pair for run in runs for pair in zip(digest.sums, run[name].sums, strict=True)]
            apart = max((abs(one - other) for one, other in pairs), default=0.0)
            print(f"| {name} | {len(exact)} | {apart:.1e} | {'UNLIKE' if name in unlike else 'like'} |")
    print(f"{len(first)} digests of {len(STACKS)} stacks, {options.times} evaluations each")
    if unlike:
        sys.exit(f"not like the first: {', '.join(sorted(unlike))}")


if __name__ == "__main__":
    main()
