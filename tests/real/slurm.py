# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Slurm for a test: a cluster of this machine alone, with its own daemons and folder."""

from __future__ import annotations

import getpass
import os
import shutil
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

_PLACES = os.pathsep.join((os.environ.get("PATH", ""), "/usr/sbin", "/usr/local/sbin"))
_NEEDED = ("slurmctld", "slurmd", "sbatch", "squeue", "sinfo")
_START, _PATIENCE = 30.0, 240.0  # seconds until the daemons answer, and until all jobs have ended
# It asks nobody who a user is: no munge is needed, and nothing but this machine can reach it.
_SETTINGS = """\
ClusterName=radtex
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/none
CredType=cred/none
SlurmctldPort={control}
SlurmdPort={work}
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SchedulerParameters=batch_sched_delay=0,sched_interval=1
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
MailProg=/bin/true
MpiDefault=none
ReturnToService=2
NodeName={host} NodeAddr=127.0.0.1 CPUs={processors} RealMemory={memory} State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


class SlurmUnavailableError(Exception):
    """One line that says why this machine has no Slurm."""


@dataclass(frozen=True)
class Cluster:
    """A cluster that runs, and the variables with which its programs find it."""

    variables: dict[str, str]

    def wait(self, patience: float = _PATIENCE) -> None:
        """Until no job waits or runs, for so many seconds at most."""
        end = time.monotonic() + patience
        while queue := self._said("squeue", "--noheader"):
            assert time.monotonic() < end, queue
            time.sleep(0.3)

    def _said(self, *command: str) -> str:
        run = subprocess.run(command, env=self.variables, capture_output=True, text=True, check=True)
        return run.stdout.strip()


@contextmanager
def slurm_cluster(folder: Path) -> Iterator[Cluster]:
    """A cluster of this machine. Raises SlurmUnavailableError where its programs are not installed."""
    if missing := [name for name in _NEEDED if shutil.which(name, path=_PLACES) is None]:
        raise SlurmUnavailableError(f"Slurm is not installed: there is no {', '.join(missing)}")
    for name in ("state", "spool"):
        (folder / name).mkdir(parents=True)
    settings = folder / "slurm.conf"
    control, work = _free_ports()
    settings.write_text(
        _SETTINGS.format(
            host=socket.gethostname().split(".")[0], user=getpass.getuser(), control=control, work=work,
            folder=folder, processors=os.cpu_count() or 1, memory=_memory(),
        ),
        encoding="utf-8",
    )  # fmt: skip
    variables = os.environ | {"SLURM_CONF": str(settings), "PATH": _PLACES}
    daemons = []
    try:
        for name in ("slurmctld", "slurmd"):
            with (folder / f"{name}.log").open("wb") as log:
                daemons.append(subprocess.Popen([name, "-D"], env=variables, stdout=log, stderr=log))
        _await_idle(folder, variables)
        yield Cluster(variables)
    finally:
        for daemon in reversed(daemons):
            daemon.terminate()
            with suppress(subprocess.TimeoutExpired):
                daemon.wait(20)
            daemon.kill()


def _await_idle(folder: Path, variables: dict[str, str]) -> None:
    """Until the machine takes jobs. Raises SlurmUnavailableError with what the daemons say."""
    end = time.monotonic() + _START
    while time.monotonic() < end:
        command = ["sinfo", "--noheader", "--format=%T"]
        run = subprocess.run(command, env=variables, capture_output=True, text=True, check=False)
        if run.stdout.strip() == "idle":
            return
        time.sleep(0.2)
    said = " ".join((folder / "slurmctld.log").read_text().split()[-40:])
    raise SlurmUnavailableError(f"Slurm does not start here: {said}")


def _memory() -> int:
    """This machine's memory in MiB, less a little that Slurm may not see."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // (1 << 20) * 9 // 10


def _free_ports() -> tuple[int, int]:
    with socket.socket() as first, socket.socket() as second:
        for one in (first, second):
            one.bind(("127.0.0.1", 0))
        return first.getsockname()[1], second.getsockname()[1]
