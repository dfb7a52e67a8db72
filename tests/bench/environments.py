# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes in unusual environments: `python -m tests.bench.environments`, on Linux; some rows only as root.

Each row starts the batch by a few words of bash that spoil its surroundings: locales, folders, limits,
streams, users, Python's own switches, clocks. It must then make the files of an ordinary bake, to
the last bit, or be refused with exit code 1 or 2 and one line; nothing half-written may bear a final name, no
temporary file of ours may be left, and --resume in an ordinary environment must go on.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from tests.blender.batch_process import BAKE
from tests.blender.killed import digests
from tests.blender.room import save_room

ARGUMENTS = (
    "--object",
    "Ball",
    "--layout",
    "buckets",
    "--texels",
    "16",
    "--bucket",
    "4",
    "--samples",
    "1",
    "--save-preview",
)
PYTHON = "$PYTHON"
_LIMIT = 120.0  # seconds


@dataclass(frozen=True)
class Attack:
    """Words of bash before the batch: $WORK is a folder of the row's own, "$@" is the batch.

    `may_refuse`: whether an error is an answer, too; `quiet`: whether its line may be lost, as where there is
    no standard error, or others may talk; `codes`: other exit codes that are right, such as a signal's.
    """

    title: str
    before: str
    may_refuse: bool = False
    quiet: bool = False
    codes: tuple[int, ...] = ()
    as_root: bool = False


_TIME = """
import time
_real = time.time
time.time = lambda: _real() + ({0})
"""


def attacks() -> list[Attack]:
    """All rows."""
    return [*_locales(), *_folders(), *_pythons(), *_limits(), *_streams(), *_systems()]


def _locales() -> list[Attack]:
    made = (
        'localedef -i {0} -f {1} "$WORK/{0}.{1}"\nexec env LOCPATH="$WORK" LC_ALL={0}.{1} LANG={0}.{1} "$@"'
    )
    return [
        Attack("LC_ALL=C", "export LC_ALL=C"),
        Attack("LC_ALL=POSIX, no UTF-8 mode", "export LC_ALL=POSIX PYTHONUTF8=0 PYTHONCOERCECLOCALE=0"),
        *(
            Attack(f"LC_ALL={name}.{charset}", made.format(name, charset))
            for name, charset in (
                ("tr_TR", "UTF-8"),
                ("de_DE", "UTF-8"),
                ("de_DE", "ISO-8859-1"),
                ("fa_IR", "UTF-8"),
                ("ja_JP", "EUC-JP"),
            )
        ),
        Attack("an unknown locale", 'exec env LC_ALL=xx_YY.UTF-9 "$@"'),
        Attack("TZ=Pacific/Kiritimati", "export TZ=Pacific/Kiritimati"),
        Attack("TZ is nonsense", "export TZ=:/etc/passwd"),
        Attack("no environment at all", 'exec env -i "$@"'),
        Attack("PATH is empty", "export PATH="),
        Attack("COLUMNS=0, TERM=dumb", "export COLUMNS=0 LINES=0 TERM=dumb"),
        Attack("COLUMNS is a word", "export COLUMNS=wide LINES=high"),
    ]


def _folders() -> list[Attack]:
    return [
        Attack("HOME and USER unset", "unset HOME USER LOGNAME XDG_CONFIG_HOME"),
        Attack("HOME is a file", 'touch "$WORK/h"; export HOME="$WORK/h"'),
        Attack("HOME does not exist", 'export HOME="$WORK/none/at/all"'),
        Attack("HOME is relative", "export HOME=. XDG_CONFIG_HOME=. XDG_CACHE_HOME=."),
        Attack("TMPDIR does not exist", 'export TMPDIR="$WORK/none"'),
        Attack("TMPDIR is a file", 'touch "$WORK/t"; export TMPDIR="$WORK/t"'),
        Attack("TMPDIR is relative", 'mkdir "$WORK/t"; cd "$WORK"; export TMPDIR=t'),
        Attack("TMPDIR is .", 'mkdir "$WORK/t"; cd "$WORK/t"; export TMPDIR=.'),
        Attack("TMPDIR has a name with marks", 'T="$WORK/a b%d#{x}\'ü球"; mkdir "$T"; export TMPDIR="$T"'),
        Attack(
            "TMPDIR is no Unicode",
            'T="$WORK/"$\'\\xff\\xfe\'; mkdir "$T"; export TMPDIR="$T"',
            may_refuse=True,
        ),
        Attack(
            "TMPDIR is 900 bytes long",
            'T="$WORK"; while [ ${#T} -lt 900 ]; do T="$T/aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"; done\n'
            'mkdir -p "$T"; export TMPDIR="$T"',
            may_refuse=True,
        ),
        Attack(
            "TMPDIR is 2000 bytes long",
            'T="$WORK"; while [ ${#T} -lt 2000 ]; do T="$T/aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"; done\n'
            'mkdir -p "$T"; export TMPDIR="$T"',
            may_refuse=True,
        ),
        Attack("TMPDIR is the folder of the files", 'mkdir -p "$OUT"; export TMPDIR="$OUT"'),
        Attack("TMPDIR is a link", 'mkdir "$WORK/t"; ln -s t "$WORK/u"; export TMPDIR="$WORK/u"'),
        Attack(
            "the working folder is gone",
            'mkdir "$WORK/gone"; cd "$WORK/gone"; rmdir "$WORK/gone"',
            quiet=True,  # Blender starts a shell, which complains
        ),
        Attack("the working folder is /", "cd /"),
        Attack(
            "the working folder has Python's names",
            'mkdir "$WORK/p"; cd "$WORK/p"; for n in json numpy copy pickle xatlas queue bpy; do\n'
            'echo "raise SystemExit(7)" > $n.py; done',
        ),
        Attack("umask 077", "umask 077"),
        Attack("umask 000", "umask 000"),
        Attack("umask 777", "umask 777", may_refuse=True),
        Attack("umask 222", "umask 222", may_refuse=True),
    ]


def _pythons() -> list[Attack]:
    switches = (
        "OPTIMIZE=2",
        "WARNINGS=error",
        "HASHSEED=1",
        "HASHSEED=4294967295",
        "DONTWRITEBYTECODE=1",
        "SAFEPATH=1",
        "DEVMODE=1",
        "UNBUFFERED=1",
        "MALLOC=debug",
        "IOENCODING=ascii:strict",
        "NOUSERSITE=1",
        "UTF8=0",
        "FAULTHANDLER=1",
        "TRACEMALLOC=5",
        "INTMAXSTRDIGITS=640",
        "NODEBUGRANGES=1",
        "_JIT=1",
    )
    return [
        Attack("PYTHONIOENCODING=utf-16", "export PYTHONIOENCODING=utf-16", quiet=True),
        *(Attack(f"PYTHON{switch}", f"export PYTHON{switch}") for switch in switches),
        Attack(
            "PYTHONPATH with modules of our names",
            'mkdir "$WORK/p"; for n in radtex_addon core formats scene bake job cli lock; do\n'
            'echo "raise SystemExit(7)" > "$WORK/p/$n.py"; done; export PYTHONPATH="$WORK/p"',
        ),
        Attack(
            "PYTHONPATH with odd entries", 'touch "$WORK/f"; export PYTHONPATH=":::/none/at/all:$WORK/f:.."'
        ),
        *(
            Attack(
                f"the clock {title}",
                f'mkdir "$WORK/p"; cat > "$WORK/p/sitecustomize.py" <<\'X\'{_TIME.format(shift)}X\n'
                'export PYTHONPATH="$WORK/p"',
            )
            for title, shift in (
                ("is 200 years ahead", "200 * 31557600"),
                ("stands before 1970", "-80 * 31557600"),
                ("jumps back and forth", "((int(_real() * 1000) % 3) - 1) * 86400"),
            )
        ),
    ]


def _limits() -> list[Attack]:
    return [
        *(Attack(f"ulimit -n {n}", f"ulimit -n {n}", may_refuse=n < 64) for n in (10, 16, 24, 32, 64, 256)),
        *(
            Attack(f"ulimit -v {size} MiB", f"ulimit -v {size << 10}", may_refuse=True)
            for size in (600, 2500, 4000)  # between, Blender itself crashes
        ),
        *(Attack(f"ulimit -f {size} KiB", f"ulimit -f {size}", may_refuse=True) for size in (0, 1, 4, 40)),
        *(
            Attack(f"ulimit -s {size} KiB", f"ulimit -s {size}", may_refuse=True)
            for size in (256, 1024, "unlimited")
        ),
        *(
            Attack(f"ulimit -t {s} s", f"ulimit -t {s}", may_refuse=True, codes=(-24, -9, 152, 137))
            for s in (1, 2, 3)
        ),
        Attack("ulimit -l 0, -c 0, -q 0", "ulimit -l 0 -c 0 -q 0"),
        Attack("one CPU", 'exec taskset -c 0 "$@"'),
        Attack("OMP_NUM_THREADS=1", "export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 MKL_NUM_THREADS=1"),
        Attack("OMP_NUM_THREADS=64", "export OMP_NUM_THREADS=64 OPENBLAS_NUM_THREADS=64"),
        Attack("nice 19, idle disk", 'exec nice -n 19 "$@"'),
    ]


def _streams() -> list[Attack]:
    return [
        Attack("no standard input", "exec 0<&-"),
        Attack("standard input is full of words", "exec 0< <(yes)"),
        Attack("no standard error", "exec 2>&-", quiet=True),
        Attack("standard error is full", "exec 2>/dev/full", quiet=True),
        Attack("standard error has no reader", "exec 2> >(true); sleep 0.3", quiet=True),
        Attack("no stream at all", "exec 0<&- 1>&- 2>&-", quiet=True, may_refuse=True),
        Attack("all signals are ignored", "trap '' HUP INT TERM PIPE USR1 ALRM TSTP"),
        Attack("standard output is a file opened to append", 'exec 1>> "$WORK/log"'),
    ]


def _systems() -> list[Attack]:
    def apart(title: str, words: str, may_refuse: bool = False, says: bool = False) -> Attack:
        inner = words.replace('"', '\\"').replace("$", "\\$")
        command = f'exec unshare -mui bash -c "{inner}; exec \\"\\$@\\"" bash "$@"'
        return Attack(title, command, may_refuse, quiet=says, as_root=True)

    reads = "--inh-caps +dac_read_search --ambient-caps +dac_read_search"  # Python may lie in root's folder
    modest = f'exec setpriv --reuid {{}} --regid 65534 --clear-groups {reads} "$@"'

    return [
        apart("no /proc", "mount -t tmpfs none /proc", says=True),
        apart("no /sys", "mount -t tmpfs none /sys"),
        apart("no /dev/shm", "umount -l /dev/shm 2>/dev/null; mount -t tmpfs -o ro none /dev/shm", True),
        apart("no network", "true"),
        apart("an odd host name", "hostname a-$(printf 'x%.0s' {1..60})"),
        apart("/tmp may only be read", "mount -t tmpfs -o ro none /var/tmp; export TMPDIR=/var/tmp"),
        apart(
            "TMPDIR may not be executed",
            "mkdir $WORK/n; mount -t tmpfs -o noexec,nosuid,nodev none $WORK/n; export TMPDIR=$WORK/n",
        ),
        apart(
            "TMPDIR is full",
            "mkdir $WORK/n; mount -t tmpfs -o size=4k none $WORK/n; export TMPDIR=$WORK/n",
            True,
        ),
        apart(
            "TMPDIR has no inodes left",
            "mkdir $WORK/n; mount -t tmpfs -o nr_inodes=3 none $WORK/n; export TMPDIR=$WORK/n",
            True,
        ),
        apart(
            "all but one's own folder is read-only", "mount --bind $WORK $WORK; mount -o remount,ro,bind /"
        ),
        Attack(
            "another user without rights", f'chmod 755 "$WORK"; {modest.format(65534)}', True, as_root=True
        ),
        Attack(
            "another user with folders of its own",
            f'mkdir "$OUT"; chown 65534 "$OUT"; chmod 755 "$WORK"\n{modest.format(65534)}',
            as_root=True,
        ),
        Attack(
            "a user without a name",
            f'mkdir "$OUT"; chmod 777 "$OUT"; chmod 755 "$WORK"\n{modest.format(12345)}',
            as_root=True,
        ),
    ]


class Bench:
    """An ordinary bake, and rows that are held against it."""

    def __init__(self, root: Path, arguments: tuple[str, ...]) -> None:
        self.root = root
        self._blend = save_room(root / "room.blend")
        self._arguments = arguments
        root.chmod(0o755)
        ended = self._run("", root / "ordinary", ())
        if ended.returncode:
            raise SystemExit(f"the ordinary bake failed: {ended.stderr.decode()}")
        self.expected = digests(root / "ordinary" / "out")

    def row(self, attack: Attack) -> tuple[str, list[str]]:
        """What was said last, and what is wrong."""
        work = self.root / f"row-{time.monotonic_ns()}"
        try:
            ended = self._run(attack.before, work, ())
        except subprocess.TimeoutExpired:
            return "", [f"hangs for {_LIMIT:g} s"]
        said = ended.stderr.decode(errors="replace")
        wrong = self._judge(attack, ended.returncode, said)
        wrong += self._left(work)
        if ended.returncode:
            resumed = self._run("", work, ("--resume",))
            if resumed.returncode:
                wrong.append(f"resumed: {resumed.returncode}, {resumed.stderr.decode()[-300:]}")
        if ended.returncode == 0 or not wrong:
            found = digests(work / "out") if (work / "out").is_dir() else {}
            if found != self.expected:
                wrong.append(f"other files: {sorted(set(found.items()) ^ set(self.expected.items()))}")
        if not wrong:
            shutil.rmtree(work, ignore_errors=True)
        last = said.strip().splitlines()[-1:] or [""]
        return f"{ended.returncode} {last[0] if ended.returncode else ''}".replace(str(work), ""), wrong

    def _run(self, before: str, work: Path, more: tuple[str, ...]) -> subprocess.CompletedProcess[bytes]:
        out, temporary = work / "out", work / "temporary"
        temporary.mkdir(parents=True, exist_ok=True)
        temporary.chmod(0o1777)
        command = [sys.executable, BAKE, str(self._blend), "--out", str(out), *self._arguments, *more]
        environment = {
            **os.environ,
            "WORK": str(work),
            "OUT": str(out),
            "ROOT": str(self.root),
            "TMPDIR": str(temporary),
        }
        words = ["bash", "-c", f'{before}\nexec "$@"', "bash", *command]
        return subprocess.run(
            words, env=environment, capture_output=True, stdin=subprocess.DEVNULL, timeout=_LIMIT, check=False
        )

    @staticmethod
    def _judge(attack: Attack, code: int, said: str) -> list[str]:
        wrong = []
        if "Traceback" in said:
            wrong.append("a traceback:\n" + said)
        if code in (0, *attack.codes):
            ours = ("Ball: ",)
            strange = [line for line in said.splitlines() if line and not line.startswith(ours)]
            if strange and code == 0 and not attack.quiet:
                wrong.append(f"says {strange[:5]}")
            return wrong
        if not attack.may_refuse or code not in (1, 2):
            wrong.append(f"exit code {code}: {said[-500:]}")
        elif not attack.quiet and not (said.strip().splitlines() or [""])[-1].startswith("radtex: "):
            wrong.append(f"exit code {code}, says {said[-500:]!r}")
        return wrong

    def _left(self, work: Path) -> list[str]:
        """Temporary files, and files under final names that are not those of an ordinary bake."""
        left = [
            str(path.relative_to(work))
            for path in work.rglob("*radtex*")
            if (".radtex-" in path.name and "radtex-unfinished" not in path.name)
            or "radtex-temporary" in path.name
        ]
        found = digests(work / "out") if (work / "out").is_dir() else {}
        odd = [name for name, digest in found.items() if digest and digest != self.expected.get(name)]
        return [f"{name} is left" for name in left] + [f"{name} is half-written" for name in odd]


def main() -> None:
    """Attack, and print what came of it."""
    keep_lines = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=keep_lines)
    parser.add_argument("--only", default="", help="of rows whose titles hold this")
    options = parser.parse_args()
    findings = 0
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        bench = Bench(Path(folder), ARGUMENTS)
        tried = 0
        print("| environment | ends | findings |\n|---|---|---|")
        for attack in attacks():
            if options.only not in attack.title or (attack.as_root and os.geteuid() != 0):
                continue
            said, wrong = bench.row(attack)
            tried, findings = tried + 1, findings + len(wrong)
            print(f"| {attack.title} | {said} | {'; '.join(wrong)} |", flush=True)
    print(f"{tried} environments, {findings} findings")
    sys.exit(1 if findings else 0)


if __name__ == "__main__":
    main()
