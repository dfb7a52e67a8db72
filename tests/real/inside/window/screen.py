# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run inside the root, before an X screen: execute commands that come as lines of JSON.

{"run": ARGV} waits for its end, {"start": ARGV, "log": FILE} does not; {"processes": null} lists those that
are there. Each is answered by one line.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any


def main() -> None:
    """Listen until nobody talks any more."""
    for line in sys.stdin:
        print(json.dumps(_answer(json.loads(line))), flush=True)


def _answer(order: dict[str, Any]) -> object:
    match order:
        case {"run": argv}:
            done = subprocess.run(argv, capture_output=True, text=True, check=False)
            return {"rc": done.returncode, "out": done.stdout, "error": done.stderr}
        case {"start": argv, "log": log}:
            with Path(log).open("wb") as output:
                process = subprocess.Popen(
                    argv, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT
                )
            _started.append(process)
            return {"pid": process.pid}
        case {"processes": _}:
            return {"processes": list(_processes())}
    return {"error": f"what is {order}?"}


def _processes() -> list[tuple[int, str]]:
    """Number and command line of each process that has not ended."""
    for process in _started:
        process.poll()  # or what has ended would still be listed
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            words = (folder / "cmdline").read_bytes().split(b"\0")
            state = (folder / "stat").read_text().rpartition(") ")[2][0]
        except OSError:  # it has ended meanwhile
            continue
        if state != "Z":
            found.append((int(folder.name), b" ".join(words).decode(errors="replace")))
    return found


_started: list[subprocess.Popen[bytes]] = []

if __name__ == "__main__":
    main()
