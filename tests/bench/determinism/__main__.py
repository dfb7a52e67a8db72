# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Are the same scenes baked to the same bits, whatever surrounds the bake?

    python -m tests.bench.determinism                        every scene, every kind
    python -m tests.bench.determinism --scene lamps ao proxy

Each scene is saved once, and baked by fresh processes: as they come, and with one core, another hash seed,
another folder, little memory and one render thread. All files of a bake are compared, byte by byte. Prints a
table: the kinds, and the scenes in which some file of theirs differed.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import NamedTuple

from tests.bench.determinism.baking import DIGESTS, KINDS, Digests
from tests.bench.determinism.scenes import SCENES

_ROOT = Path(__file__).resolve().parents[3]
_BUILD = "import sys, bpy; from tests.bench.determinism.scenes import build; build(sys.argv[1]); "
_BUILD += "bpy.ops.wm.save_as_mainfile(filepath=sys.argv[2])"


class Running(NamedTuple):
    """A process, and the folder it bakes into."""

    process: subprocess.Popen[str]
    folder: Path


def main() -> None:
    """Bake, compare, tell."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.determinism",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--scene", action="append", choices=SCENES, help="only this one; repeatable")
    parser.add_argument("--plain-runs", type=int, default=2, help="processes as they come (2)")
    parser.add_argument("kinds", nargs="*", metavar="KIND", help="of " + ", ".join(KINDS))
    options = parser.parse_args()
    kinds, differing = options.kinds or list(KINDS), dict[str, list[str]]()
    scenes = options.scene or list(SCENES)
    for scene in scenes:
        with tempfile.TemporaryDirectory() as folder:
            runs = bake_all(scene, kinds, Path(folder), options.plain_runs)
        for kind in kinds:
            if any(run[kind] != runs[0][kind] for run in runs):
                differing.setdefault(kind, []).append(scene)
        print(f"{scene}: {len(runs)} processes, {sum(map(len, runs[0].values()))} files each", flush=True)
    print("\n| kind | bits |\n|---|---|")
    for kind in kinds:
        print(f"| {kind} | {'differ: ' + ', '.join(differing[kind]) if kind in differing else 'same'} |")


def bake_all(scene: str, kinds: list[str], folder: Path, plain: int) -> list[Digests]:
    """The digests of all kinds' files, of each process; the last one's surroundings are all others."""
    blend = folder / "scene.blend"
    subprocess.run([sys.executable, "-c", _BUILD, scene, blend], cwd=_ROOT, check=True, capture_output=True)
    runs = [baked(started(blend, kinds, folder / f"out {number}")) for number in range(plain)]
    return [*runs, baked(started(blend, kinds, folder / "an other place", odd=True))]


def started(blend: Path, kinds: list[str], folder: Path, *options: str, odd: bool = False) -> Running:
    """A process that bakes kinds of a .blend into a folder; `odd`: in surroundings that should not matter."""
    command = [sys.executable, "-m", "tests.bench.determinism.baking", str(blend), str(folder), *options]
    environment, alone = dict(os.environ), None
    if odd:
        folder.mkdir(parents=True)
        command += ["--memory", "900", "--render-threads", "1"]
        environment |= {"PYTHONHASHSEED": "7", "OMP_NUM_THREADS": "1", "TMPDIR": str(folder.parent)}
        alone = _on_one_core
    process = subprocess.Popen(
        [*command, *kinds],
        cwd=_ROOT,
        env=environment,
        preexec_fn=alone,  # noqa: PLW1509 -- nothing else runs in this process
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    return Running(process, folder)


def baked(running: Running) -> Digests:
    """What a process has made, once it is done."""
    _, said = running.process.communicate(timeout=1800)
    if running.process.returncode != 0:
        raise RuntimeError(said)
    found: Digests = json.loads((running.folder / DIGESTS).read_text(encoding="utf-8"))
    return found


def _on_one_core() -> None:
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})


if __name__ == "__main__":
    main()
