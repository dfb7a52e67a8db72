# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Running bake.py in a process of its own."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parents[2]
BAKE = str(ROOT / "bake.py")
QUICK = [
    "--layout",
    "buckets",
    "--uv",
    "UVMap",
    "--texels",
    "4",
    "--bucket",
    "2",
    "--samples",
    "1",
    "--progress",
    "none",
]


class Outcome(NamedTuple):
    code: int
    out: str
    err: str


Batch = Callable[..., Outcome]  # the fixture `batch`: the batch in this process


def process(*arguments: object, start: Sequence[str] = (BAKE,), **options: Any) -> Outcome:
    """Run the batch as a user does."""
    command = [sys.executable, *start, *(str(argument) for argument in arguments)]
    ended = subprocess.run(
        command, capture_output=True, text=True, encoding="utf-8", timeout=120, check=False, **options
    )
    return Outcome(ended.returncode, ended.stdout, ended.stderr)


def refusal(outcome: Outcome, code: int = 2) -> str:
    """The one line that a run without progress said, on standard error and nowhere else."""
    assert outcome.out == ""
    assert outcome.err.startswith("radtex: ")
    assert outcome.err.count("\n") == 1, outcome.err
    assert outcome.err.endswith("\n")
    assert outcome.code == code
    return outcome.err
