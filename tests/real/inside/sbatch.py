# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A small stand-in for Slurm's sbatch: it runs a job's tasks at once, one after another.

It takes the options that slurm.sh uses, as Slurm's manual describes them, refuses all others, and keeps a
line of JSON for each job in $SBATCH_JOBS. Where $SBATCH_MOST is given it takes no more jobs.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

LARGEST = 1000  # last index of an array, where Slurm's MaxArraySize is 1001, its default


def main() -> None:
    parser = argparse.ArgumentParser(allow_abbrev=False)
    parser.add_argument("--parsable", action="store_true", required=True)
    for name in ("--job-name", "--mem", "--time", "--output"):
        parser.add_argument(name, required=True)
    for name in ("--array", "--dependency", "--partition"):
        parser.add_argument(name)
    parser.add_argument("--kill-on-invalid-dep", choices=("yes", "no"), default="no")
    parser.add_argument("script", type=Path)
    parser.add_argument("arguments", nargs=argparse.REMAINDER)
    job = parser.parse_args()
    record = Path(os.environ["SBATCH_JOBS"])
    before = [json.loads(line) for line in record.read_text().splitlines()] if record.exists() else []
    number = len(before) + 1
    if number > int(os.environ.get("SBATCH_MOST", number)):
        sys.exit("sbatch: error: Batch job submission failed: Job violates accounting/QOS policy")
    if not job.script.read_text().startswith("#!"):
        sys.exit("sbatch: error: This does not look like a batch script.")
    kind, *needs = (job.dependency or "afterok").split(":")
    if kind != "afterok" or not all(0 < int(need) < number for need in needs):
        sys.exit("sbatch: error: Batch job submission failed: Job dependency problem")
    elements = [int(word) for word in job.array.split(",")] if job.array else [None]
    if any(element is not None and not 0 <= element <= LARGEST for element in elements):
        sys.exit("sbatch: error: Batch job submission failed: Invalid job array specification")
    state = "CANCELLED"
    if all(before[int(need) - 1]["state"] == "COMPLETED" for need in needs):
        codes = [run(job.script, job.arguments, number, element) for element in elements]
        state = "FAILED" if any(codes) else "COMPLETED"
    facts = {"state": state, "name": job.job_name, "array": job.array, "needs": [int(need) for need in needs]}
    facts |= {"mem": job.mem, "time": job.time, "partition": job.partition, "kill": job.kill_on_invalid_dep}
    with record.open("a") as stream:
        stream.write(f"{json.dumps(facts)}\n")
    print(f"{number};here")


def run(script: Path, arguments: list[str], job: int, element: int | None) -> int:
    """Run a copy of the script, as Slurm does; returns how it ended."""
    variables = os.environ | {"SLURM_JOB_ID": str(job)}
    if element is not None:
        variables |= {"SLURM_ARRAY_JOB_ID": str(job), "SLURM_ARRAY_TASK_ID": str(element)}
    with tempfile.TemporaryDirectory() as spool:
        copy = shutil.copy(script, Path(spool) / "slurm_script")
        Path(copy).chmod(0o700)
        run = subprocess.run([copy, *arguments], env=variables, stdout=subprocess.DEVNULL, check=False)
    return run.returncode


if __name__ == "__main__":
    main()
