# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Odd command lines end with one line on standard error: those that once did not, and some hundred others.

`python -m tests.fuzz.lines --executions 100000 --processes 200` is the whole of it.
"""

from __future__ import annotations

import json
from pathlib import Path
from random import Random

from .corpus import make_corpus
from .grammar import command_line
from .lines import FOLDER, KEPT, judge

EXECUTIONS = 300


def test_odd_command_lines_end_in_one_line(tmp_path: Path) -> None:
    make_corpus(tmp_path)
    kept = json.loads(KEPT.read_text(encoding="utf-8"))
    lines = [(inside, [word.replace(FOLDER, str(tmp_path)) for word in words]) for inside, words in kept]
    lines += [
        (bool(number % 2), command_line(Random(f"0 {number}"), tmp_path)) for number in range(EXECUTIONS)
    ]
    codes = {judge(words, inside) for inside, words in lines}
    assert codes == {0, 2}
