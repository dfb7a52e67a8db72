# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
#
# /// script
# requires-python = ">=3.11"
# dependencies = []
# ///
"""Run the tests on every supported Blender: `uv run tests/run.py [--blender 5.2] [pytest's arguments]`.

Each Blender has an environment of its own (.venv-4.5, .venv-5.2), made from uv.lock when needed.
The last line sums up, as pytest would; the exit code is 0 only if all passed.
"""

from __future__ import annotations

import argparse
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path
from time import perf_counter
from xml.etree import ElementTree as ET

ROOT = Path(__file__).resolve().parent.parent
UV = os.environ.get("UV") or shutil.which("uv") or "uv"
PYTHON_OF = {"4.5": "3.11", "5.2": "3.13"}


def main() -> int:
    """Run the suite on the chosen Blenders and return the exit code of the worst."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter, allow_abbrev=False
    )
    parser.add_argument("--blender", choices=PYTHON_OF, action="append", help="only this one; repeatable")
    options, pytest_arguments = parser.parse_known_args()
    started = perf_counter()
    counts: Counter[str] = Counter()
    codes = []
    for blender in options.blender or PYTHON_OF:
        code, outcome = run_pytest(blender, pytest_arguments)
        codes.append(code)
        counts += outcome
    print(summary(counts, perf_counter() - started), flush=True)
    return max(codes, key=abs)


def run_pytest(blender: str, arguments: list[str]) -> tuple[int, Counter[str]]:
    """Run pytest in one Blender's environment; return its exit code and how many tests ended how."""
    command = [UV, "run", "--frozen", "--python", PYTHON_OF[blender]]
    command += ["--no-default-groups", f"--group=blender-{blender.replace('.', '')}", "--group=test"]
    command += ["python", "-m", "pytest"]
    environment = os.environ | {"UV_PROJECT_ENVIRONMENT": str(ROOT / f".venv-{blender}")}
    environment.pop("VIRTUAL_ENV", None)
    with tempfile.TemporaryDirectory() as folder:
        report = Path(folder, "report.xml")
        print(f"Blender {blender}: {shlex.join([*command, *arguments])}", flush=True)
        code = subprocess.run(
            [*command, f"--junit-xml={report}", *arguments], cwd=ROOT, env=environment, check=False
        ).returncode
        outcome = read_report(report) if report.exists() else Counter({"error": 1})
    return code, outcome


def read_report(path: Path) -> Counter[str]:
    """Count the outcomes in a JUnit report."""
    words = {"failure": "failed", "error": "error", "skipped": "skipped"}
    cases = ET.parse(path).iter("testcase")
    return Counter(next((words[e.tag] for e in case if e.tag in words), "passed") for case in cases)


def summary(counts: Counter[str], seconds: float) -> str:
    """One line for all runs together, worded as pytest's last."""
    words = {"failed": "failed", "passed": "passed", "skipped": "skipped"}
    words["error"] = "error" if counts["error"] == 1 else "errors"
    parts = [f"{counts[key]} {word}" for key, word in words.items() if counts[key]]
    return f" {', '.join(parts) or 'no tests ran'} in {seconds:.2f}s ".center(80, "=")


if __name__ == "__main__":
    sys.exit(main())
