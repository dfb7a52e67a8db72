# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake on a disk that fails it: `python -m tests.bench.disks`, as root on Linux.

The disk is a small ext4 in a file. It runs full at each stage, becomes read-only, goes away, takes nothing
any more, loses power; pieces are damaged. Each time the bake must end with one line that names a file, leave
nothing half-written under a final name, and go on by --resume, once the disk is mended, to the bits of an
uninterrupted bake.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from tests.blender.disk import Disk, set_fixed, small_disk, unavailable
from tests.blender.killed import Command, Ended, Running, digests, left_behind
from tests.blender.room import save_room

ARGUMENTS = (
    *(
        "--layout",
        "buckets",
        "--uv",
        "UVMap",
        "--texels",
        "96",
        "--bucket",
        "8",
        "--samples",
        "4",
        "--sheet",
        "256",
    ),
    *("--layer", "diffuse", "--save-preview"),
)
_KB = 1 << 10
_TEMPORARY = "temporary files find no room"
_MODEST = ("setpriv", "--bounding-set=-dac_override,-dac_read_search,-fowner")  # root that modes bind
_BLEND = (b"\x28\xb5\x2f\xfd", b"BLEN")  # how a .blend begins, packed or not


@dataclass(frozen=True)
class Way:
    """How a disk fails a bake: `before` it starts, while it runs, and how that is mended."""

    title: str
    breaks: Callable[[Disk, Path, Running], None] = lambda *_: None
    mend: Callable[[Disk, Path], None] = lambda *_: None
    before: Callable[[Disk], None] = lambda *_: None
    says: bool = True  # whether the bake lives to say a word
    tidies: bool = False  # whether it can remove what it was writing
    damages: bool = False  # whether pieces may have to be made again


class Bench:
    """A command, and what it makes where nothing fails."""

    def __init__(self, command: Command, root: Path) -> None:
        self.command, self.root = command, root
        whole = command.start(root / "uninterrupted").end()
        if whole.code:
            raise SystemExit(f"the uninterrupted bake failed: {whole.err}")
        self.expected, self.stages, self.life = digests(root / "uninterrupted"), whole.stages, whole.seconds
        self.images = sum(path.stat().st_size for path in (root / "uninterrupted").glob("*.exr"))
        self.problems: list[str] = []

    def row(self, way: Way, command: Command) -> None:
        """Break the disk while a bake runs, mend it, and go on; print what came of it."""
        with small_disk(self.root) as disk:
            out = disk.folder / "out"
            way.before(disk)
            running = command.start(out)
            way.breaks(disk, out, running)
            ended = running.end()
            wrong = self._judge(ended) if way.says else []
            if way.tidies:
                wrong += [f"{path.name} is left" for path in disk.folder.rglob(".radtex-*")]
            way.mend(disk, out)
            wrong += self._half_written(out)
            wrong += self._go_on(command, out, way)
        said = ended.err.strip().replace(str(self.root), "").removeprefix("radtex: ")
        print(
            f"| {way.title} | {ended.stage} | {ended.code} | {said} | {'; '.join(wrong) or 'same'} |",
            flush=True,
        )
        self.problems += [f"{way.title}: {each}" for each in wrong]

    def _judge(self, ended: Ended) -> list[str]:
        wrong = [] if ended.code == 1 else [f"exit code {ended.code}"]
        if (
            ended.err.count("\n") != 1
            or not ended.err.startswith("radtex: ")
            or str(self.root) not in ended.err
        ):
            wrong.append(f"said {ended.err!r}")
        return wrong

    def _half_written(self, out: Path) -> list[str]:
        found = digests(out) if out.exists() else {}
        return [
            f"{name} is half-written"
            for name, digest in found.items()
            if name in self.expected
            and (
                digest != self.expected[name] or (not digest and (out / name).read_bytes()[:4] not in _BLEND)
            )
        ]

    def _go_on(self, command: Command, out: Path, way: Way) -> list[str]:
        resumed = command.start(out, "--resume").end()
        finished_before = not way.says and "nothing of object" in resumed.err
        if (resumed.code or resumed.err) and not finished_before:
            return [f"resumed: exit code {resumed.code}, {resumed.err!r}"]
        wrong = [] if way.damages else list(resumed.warnings)
        if digests(out) != self.expected:
            wrong.append(f"differs: {sorted(digests(out))}")
        return wrong + left_behind(command.temporary)


def at(
    stage: str, then: Callable[[Disk, Path], None], pieces: int = 0
) -> Callable[[Disk, Path, Running], None]:
    """Do it once a stage has begun, and so many tiles are kept."""

    def breaks(disk: Disk, out: Path, running: Running) -> None:
        running.wait_for(stage)
        while running.process.poll() is None and len(list(out.glob("*/tile-*.piece"))) < pieces:
            time.sleep(0.01)
        then(disk, out)

    return breaks


def full_ways(images: int) -> list[Way]:
    """A disk that runs full; the images take so many bytes."""

    def full(leave: int = 0) -> Callable[[Disk, Path], None]:
        return lambda disk, _: disk.fill(leave)

    def empty(disk: Disk, _out: Path) -> None:
        disk.empty()

    return [
        Way("full before the first piece", mend=empty, before=lambda disk: disk.fill(8 * _KB), tidies=True),
        Way("full at the first tiles", mend=empty, before=lambda disk: disk.fill(images // 2)),
        Way("full in the middle", at("capture", full(), pieces=2), empty, tidies=True),
        Way("full at the end", at("fill", full()), empty),
        Way("full at the atlas", at("fill", full(64 * _KB)), empty, tidies=True),
        Way("full at the layer", at("fill", full(images * 3 // 4)), empty),
        Way("full at the preview", at("preview", full()), empty, tidies=True),
    ]


def refusing_ways() -> list[Way]:
    """A disk that takes nothing any more."""

    def fixed(is_fixed: bool) -> Callable[[Disk, Path], None]:
        def change(_disk: Disk, out: Path) -> None:
            for folder in (out, *out.glob("*.radtex-unfinished")):
                set_fixed(folder, is_fixed)

        return change

    return [
        *(
            Way(f"read-only at {stage}", at(stage, fixed(True), pieces), fixed(False))
            for stage, pieces in (("capture", 2), ("fill", 0), ("preview", 0))
        ),
        Way("disk fails", at("capture", lambda disk, _: disk.fail(), 2), lambda disk, _: disk.restart()),
        Way(
            "disk taken away",
            at("capture", lambda disk, _: disk.unmount(lazily=True), 2),
            lambda disk, _: disk.mount(),
        ),
    ]


def rights_way() -> Way:
    """A user who loses the right to write."""

    def allowed(mode: int) -> Callable[[Disk, Path], None]:
        def change(_disk: Disk, out: Path) -> None:
            for folder in (out, *out.glob("*.radtex-unfinished")):
                folder.chmod(mode)

        return change

    return Way("right to write lost", at("capture", allowed(0o500), 2), allowed(0o700))


def temporary_row(bench: Bench) -> None:
    """No room for what Cycles renders into."""
    root = bench.root / "other"
    root.mkdir()
    with small_disk(root, 8) as other:
        small = replace(bench.command, temporary=other.folder / "temporary")
        way = Way(
            _TEMPORARY,
            before=lambda _: other.fill(100 * _KB),
            mend=lambda *_: other.empty(),
        )
        bench.row(way, small)


def power_ways(cuts: int, chance: random.Random) -> list[Way]:
    """The power goes: while tiles are rendered, and at the end, in turn."""

    def later(stage: str, pieces: int, seconds: float) -> Callable[[Disk, Path, Running], None]:
        def breaks(disk: Disk, out: Path, running: Running) -> None:
            at(stage, lambda *_: time.sleep(seconds), pieces)(disk, out, running)
            disk.cut_power()
            running.process.kill()

        return breaks

    stages = ("capture", "write", "capture", "preview", "capture", "fill")
    return [
        Way(
            f"power cut at {stage}",
            later(stage, chance.randint(1, 5) if stage == "capture" else 0, chance.uniform(0, 0.4)),
            lambda disk, _: disk.restart(),
            says=False,
            damages=True,
        )
        for stage in (stages[number % len(stages)] for number in range(cuts))
    ]


def damage_way(chance: random.Random) -> Way:
    """Pieces that are empty, cut short, of zeros, or have one bit turned."""

    def kill(_disk: Disk, out: Path, running: Running) -> None:
        at("capture", lambda *_: running.process.kill(), 3)(_disk, out, running)

    def damage(_disk: Disk, out: Path) -> None:
        for number, piece in enumerate(sorted(out.glob("*/*.piece"))):
            whole = bytearray(piece.read_bytes())
            place = chance.randrange(len(whole))
            turned = bytes((*whole[:place], whole[place] ^ 4, *whole[place + 1 :]))
            piece.write_bytes((b"", bytes(whole[:place]), bytes(len(whole)), turned)[number % 4])

    return Way("every piece damaged", kill, damage, says=False, damages=True)


def main() -> None:
    """Fail, and say what came of it."""
    keep_lines = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=keep_lines)
    parser.add_argument("--cuts", type=int, default=10, help="of the power")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="", help="of rows whose titles begin so")
    options = parser.parse_args()
    if why := unavailable():
        sys.exit(f"skipped: {why}")
    chance = random.Random(options.seed)
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        bench = Bench(Command(save_room(root / "room.blend", 4), root / "temporary", ARGUMENTS), root)
        print(f"uninterrupted: {bench.life:.1f} s\n")
        print("| the disk | hit in | exit code | says | resumed |\n|---|---|---|---|---|")
        modest = replace(bench.command, through=_MODEST)
        ways = [(way, bench.command) for way in (*full_ways(bench.images), *refusing_ways())]
        ways += [(rights_way(), modest)]
        ways += [(way, bench.command) for way in (*power_ways(options.cuts, chance), damage_way(chance))]
        for way, command in ways:
            if way.title.startswith(options.only):
                bench.row(way, command)
        if _TEMPORARY.startswith(options.only):
            temporary_row(bench)
    sys.exit("\n".join(bench.problems) or None)


if __name__ == "__main__":
    main()
