# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs that are killed at the n-th rename or removal of a file: `python -m tests.bench.renames --kills 10`.

Each scenario is run once undisturbed, which counts its changes of names below the output folder. Then it is
run anew for each kill, dies just before or just after one of these changes, and is gone on with by --resume,
or as the refusal advises. What is there then must be what the undisturbed run left, to the last bit, with
nothing beside it. Of previews, in which Blender notes when they were saved, only the names are compared.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import re
import shutil
import signal
import stat
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from tests.blender.batch_process import BAKE, ROOT
from tests.blender.room import save_room

_KILL_AT = str(ROOT / "tests" / "blender" / "kill_at.py")
_SMALL = (
    "--layout",
    "buckets",
    "--uv",
    "UVMap",
    "--texels",
    "24",
    "--bucket",
    "4",
    "--samples",
    "1",
    "--sheet",
    "96",
)
_LAYERED = ("--layout", "layered", "--texels", "20", "--samples", "1")
_BALL = ("--object", "Ball")
_BOTH = (*_BALL, "--object", "Floor")
_SHOWN = "--save-preview"


@dataclass(frozen=True)
class Scenario:
    """A run of `bake.py` with `words`, after `before` was run in the same folder, and what others did there.

    `is_bake` runs are gone on with by --resume, others by the same words once more. {blend} and {out} in
    words are the room's file and the output folder.
    """

    words: tuple[str, ...]
    before: tuple[tuple[str, ...], ...] = ()
    others: Callable[[Path], None] = lambda _: None
    is_bake: bool = True


def _bake(*words: str, before: tuple[tuple[str, ...], ...] = ()) -> Scenario:
    ends = ("{blend}", "--out", "{out}")
    return Scenario((*ends, *words), tuple((*ends, *each) for each in before))


def put_own_things(out: Path) -> None:
    """What people put into an exported folder: a file, a link to a folder, a FIFO, an empty folder."""
    made = out / "Ball.raw"
    (made / "mine.txt").write_text("mine")
    (made / "link").symlink_to(out, target_is_directory=True)
    (made / "shaders" / "empty").mkdir()
    os.mkfifo(made / "fifo")


_EXPORT = ("export", "{out}/Ball.radiance.json", "--out", "{out}/Ball.raw", "--overwrite")
SCENARIOS = {
    "plain": _bake(*_BALL, *_SMALL, "--layer", "diffuse", _SHOWN),
    "layered": _bake(*_BALL, *_LAYERED, _SHOWN),
    "export": _bake(*_BALL, *_SMALL, _SHOWN, "--export", "raw", "--export", "gltf"),
    "objects": _bake(*_BOTH, *_SMALL, _SHOWN, "--export", "raw"),
    "frames": _bake(*_BALL, *_SMALL, _SHOWN, "--frames", "1,2", "--export", "raw"),
    "accumulate": _bake(*_BALL, *_SMALL, _SHOWN, "--accumulate", before=((*_BALL, *_SMALL),)),
    "accumulate, objects": _bake(*_BOTH, *_SMALL, "--accumulate", before=((*_BOTH, *_SMALL),)),
    "refresh": _bake(*_BALL, *_SMALL, _SHOWN, "--refresh", before=((*_BALL, *_SMALL, "--seed", "5"),)),
    "overwrite, objects": _bake(
        *_BOTH,
        *_SMALL,
        *(_SHOWN, "--export", "raw", "--overwrite"),
        before=((*_BOTH, *_SMALL, "--device", "cpu", "--layer", "diffuse", _SHOWN, "--export", "raw"),),
    ),
    "shadow": _bake(*_BALL, *_SMALL, "--kind", "shadow", _SHOWN),
    "lights": _bake(*_BALL, *_SMALL, "--lights", "each", "--lights", "all", _SHOWN),
    "export anew": Scenario(
        (*_EXPORT, "--to", "gltf"),
        (
            ("{blend}", "--out", "{out}", *_BALL, *_SMALL, _SHOWN),
            (*_EXPORT, "--to", "raw"),
        ),
        put_own_things,
        is_bake=False,
    ),
}


@dataclass
class Outcome:
    """What came of a scenario: how many kills there were, how they were gone on with, and what was wrong."""

    changes: int
    kills: int = 0
    resumed: int = 0
    was_done: int = 0
    advised: int = 0
    problems: list[str] = field(default_factory=list)


class Bench:
    """Scenarios below `root`."""

    def __init__(self, root: Path) -> None:
        self._root = root
        self._blend = save_room(root / "room.blend")
        self._temporary = root / "temporary"
        self._temporary.mkdir()

    def run(self, name: str, kills: int, offset: float = 0.5) -> Outcome:
        """Kill a scenario so often, at changes spread evenly over all that it makes."""
        scenario, start, whole = SCENARIOS[name], self._root / f"{name} start", self._root / f"{name} whole"
        start.mkdir()
        for words in scenario.before:
            self._must(words, start)
        scenario.others(start)
        _copy(start, whole)
        log = self._root / f"{name}.log"
        if code := self._killed(scenario.words, whole, log, 0, "before"):
            raise SystemExit(f"{name}: the undisturbed run ended with exit code {code}")
        changes = log.read_text().splitlines()
        expected, outcome = contents(whole), Outcome(len(changes))
        for kill in range(kills):
            place = (kill + offset) * len(changes) / kills
            number, when = int(place) + 1, ("before", "after")[kill % 2]
            out = self._root / f"{name} out"
            _copy(start, out)
            code = self._killed(scenario.words, out, log, number, when)
            outcome.kills += 1
            wrong = [] if code == -signal.SIGKILL else [f"exit code {code}"]
            wrong += self._go_on(scenario, out, expected, outcome)
            if found := _differences(expected, contents(out)):
                wrong.append(f"differs: {found}")
            told = re.sub(r"\.radtex-\d+-[0-9a-f]+", ".radtex-…", changes[number - 1])
            print(f"{name}: killed {when} {told}: {'; '.join(wrong) or 'same'}", flush=True)
            outcome.problems += [f"{name}, {when} {told}: {each}" for each in wrong]
            shutil.rmtree(out)
        return outcome

    def _go_on(self, scenario: Scenario, out: Path, expected: dict[str, str], outcome: Outcome) -> list[str]:
        """Resume, and where that is refused do what is advised. Returns what is wrong."""
        words = scenario.words
        if scenario.is_bake:
            words = (*(word for word in words if word != "--overwrite"), "--resume")
        ended = self._start(words, out)
        if ended.returncode == 0:
            outcome.resumed += 1
            return [ended.stderr] if ended.stderr else []
        if ended.returncode != 2 or ended.stderr.count("\n") != 1:
            return [f"resumed: exit code {ended.returncode}, {ended.stderr!r}"]
        if not _differences(expected, contents(out)):
            outcome.was_done += 1
            return [] if "nothing" in ended.stderr or "no bake of" in ended.stderr else [ended.stderr]
        if "leave --resume out" not in ended.stderr:
            return [f"no advice: {ended.stderr}"]
        outcome.advised += 1
        return self._as_advised(scenario.words, out, ended.stderr)

    def _as_advised(self, words: tuple[str, ...], out: Path, said: str) -> list[str]:
        anew = ("--overwrite",) if "--overwrite" in said and "--overwrite" not in words else ()
        ended = self._start((*words, *anew), out)
        return [] if ended.returncode == 0 else [f"as advised: {ended.returncode}, {ended.stderr!r}"]

    def _must(self, words: tuple[str, ...], out: Path) -> None:
        ended = self._start(words, out)
        if ended.returncode:
            raise SystemExit(f"{' '.join(words)}: {ended.stderr}")

    def _killed(self, words: tuple[str, ...], out: Path, log: Path, number: int, when: str) -> int:
        log.unlink(missing_ok=True)
        return self._start(words, out, _KILL_AT, str(out), str(log), str(number), when).returncode

    def _start(self, words: tuple[str, ...], out: Path, *program: str) -> subprocess.CompletedProcess[str]:
        filled = [word.format(blend=self._blend, out=out) for word in words]
        command = [sys.executable, *(program or (BAKE,)), *filled, "--progress", "json"]
        environment = {**os.environ, "TMPDIR": str(self._temporary)}
        return subprocess.run(
            command, capture_output=True, text=True, env=environment, timeout=300, check=False
        )


def contents(folder: Path) -> dict[str, str]:
    """All that is below a folder, hidden things too: files by digests, links by where they lead."""
    found = {}
    for path in sorted(folder.rglob("*")):
        name, mode = str(path.relative_to(folder)), path.lstat().st_mode
        if stat.S_ISREG(mode):
            is_preview = name.endswith(".preview.blend")
            found[name] = "preview" if is_preview else hashlib.sha256(path.read_bytes()).hexdigest()
        else:
            found[name] = f"link to {path.readlink()}" if stat.S_ISLNK(mode) else str(stat.S_IFMT(mode))
    return found


def _differences(expected: dict[str, str], found: dict[str, str]) -> list[str]:
    names = sorted({*expected, *found})
    return [name for name in names if expected.get(name) != found.get(name)]


def _copy(source: Path, target: Path) -> None:
    """With links and FIFOs, which `shutil.copytree` does not take."""
    subprocess.run(["cp", "-a", str(source), str(target)], check=True)


def main() -> None:
    """Kill, and say what came of it."""
    keep_lines = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=keep_lines)
    parser.add_argument("--kills", type=int, default=10, help="for each scenario")
    parser.add_argument("--offset", type=float, default=0.5, help="where in its share a kill lies, 0 to 1")
    parser.add_argument("scenarios", nargs="*", default=list(SCENARIOS))
    options = parser.parse_args()
    outcomes: dict[str, Outcome] = {}
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(Path(folder))
        for name in options.scenarios:
            outcomes[name] = bench.run(name, options.kills, options.offset)
    print("| scenario | changes | kills | resumed | was done | as advised | wrong |")
    print("|---|---|---|---|---|---|---|")
    for name, one in outcomes.items():
        counts = (one.changes, one.kills, one.resumed, one.was_done, one.advised, len(one.problems))
        print(f"| {name} | {' | '.join(map(str, counts))} |")
    if problems := [problem for one in outcomes.values() for problem in one.problems]:
        sys.exit("\n".join(problems))


if __name__ == "__main__":
    main()
