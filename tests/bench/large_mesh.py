# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake of a mesh of millions of triangles takes: seconds, memory and silence, by stage.

python -m tests.bench.large_mesh [--triangles 5000000] [--texels 128] [--samples 1] [--folder DIR]

The mesh is a ball with bumps and hollows, smooth, of one material, without UVs. For comparison, the same
file opened and rendered by Cycles alone. Memory is the most that the whole process has, in GB of 10^9 bytes;
silence is the longest time between two steps of the progress. --bake takes more options of the batch, in one
string. Linux only.
"""

from __future__ import annotations

import argparse
import json
import shlex
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from threading import Thread

ROOT = Path(__file__).resolve().parents[2]
_PULSE = 0.02  # seconds between two looks at the memory
_RENDER = """
import bpy, sys
bpy.ops.wm.open_mainfile(filepath=sys.argv[1])
bpy.ops.render.render()
"""


@dataclass
class Stage:
    """What one stage took: seconds, the most memory in bytes, the longest silence in seconds."""

    seconds: float = 0.0
    memory: int = 0
    silence: float = 0.0


@dataclass
class Run:
    """A process that is watched; the stage before it names one is "start"."""

    stages: dict[str, Stage] = field(default_factory=dict)
    now: str = "start"
    code: int | None = None

    def watch(self, command: list[str]) -> None:
        """Run it to its end."""
        process = subprocess.Popen([sys.executable, *command], cwd=ROOT, stdout=subprocess.PIPE, text=True)
        looking = Thread(target=self._look, args=(process.pid,), daemon=True)
        looking.start()
        assert process.stdout is not None  # as asked for
        since = time.perf_counter()
        for line in process.stdout:
            since = self._heard(since)
            if line.startswith("{"):
                self.now = json.loads(line).get("stage", self.now)
        self._heard(since)
        self.code = process.wait()
        looking.join()

    def _heard(self, since: float) -> float:
        now = time.perf_counter()
        stage = self.stages.setdefault(self.now, Stage())
        stage.seconds += now - since
        stage.silence = max(stage.silence, now - since)
        return now

    def _look(self, pid: int) -> None:
        while self.code is None:
            try:
                pages = int(Path(f"/proc/{pid}/statm").read_text(encoding="ascii").split()[1])
            except (OSError, IndexError):  # it has ended
                return
            stage = self.stages.setdefault(self.now, Stage())
            stage.memory = max(stage.memory, 4096 * pages)
            time.sleep(_PULSE)

    def print(self, title: str) -> None:
        """A row for each stage, and one for all."""
        whole = Stage(
            sum(stage.seconds for stage in self.stages.values()),
            max(stage.memory for stage in self.stages.values()),
            max(stage.silence for stage in self.stages.values()),
        )
        print(f"\n{title}, exit {self.code}\n\n| stage | s | GB | silence, s |\n|---|---|---|---|")
        for name, stage in [*self.stages.items(), ("whole", whole)]:
            print(f"| {name} | {stage.seconds:.1f} | {stage.memory / 1e9:.2f} | {stage.silence:.1f} |")
        sys.stdout.flush()


def main() -> None:
    """Make the file, render it, bake it, and print what that took."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--triangles", type=int, default=5_000_000)
    parser.add_argument("--texels", type=int, default=128)
    parser.add_argument("--samples", type=int, default=1)
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--bake", type=shlex.split, default=[], metavar="OPTIONS")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=asked.folder) as folder:
        scene = str(Path(folder, "sculpt.blend"))
        make = ["-m", "tests.bench.large_sculpt", scene, str(asked.triangles)]
        made = subprocess.run([sys.executable, *make], cwd=ROOT, check=True, capture_output=True, text=True)
        print(made.stdout.splitlines()[-1])
        render = Run()
        render.watch(["-c", _RENDER, scene])
        render.print("rendered by Cycles alone")
        bake = Run()
        bake.watch(
            [
                *["bake.py", scene, "--object", "Sculpt", "--out", str(Path(folder, "out"))],
                *["--texels", str(asked.texels), "--samples", str(asked.samples)],
                *["--progress", "json", *asked.bake],
            ]
        )
        bake.print("baked")


if __name__ == "__main__":
    main()
