# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What once crashed, hung or surprised a reader no longer does, nor do some hundred other damaged files.

`python -m tests.fuzz.run --executions 1000000` is the whole of it.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from .readers import READERS
from .run import FAILURES, ROOT

EXECUTIONS = 60  # of each reader


@pytest.mark.skipif(sys.platform == "win32", reason="its memory is bounded by the system's limits")
def test_damaged_files_are_refused_in_one_line(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "tests.fuzz.worker", *READERS, f"--executions={EXECUTIONS}"]
    command += [f"--folder={tmp_path}", f"--replay={FAILURES}"]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stdout[-4000:] + ended.stderr[-4000:]
    lines = (
        line.split() for line in ended.stdout.splitlines() if line.startswith("done ")
    )  # Blender's are others
    done = {name: int(read) for _, name, read, _, _ in lines}
    assert set(done) == set(READERS)
    assert min(done.values()) > 0  # what was not damaged
