# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Estimate how long bakes take, from two small probe bakes: made in this process or by a worker."""

from __future__ import annotations

import tempfile
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import bpy

from ..panel import panel_state

if TYPE_CHECKING:
    from ...bake.estimate import Probe
    from ...bake.spec import BakeSpec
    from ...core.messages import Message
    from ...job.variants import Bake
    from ...worker.job import Job
    from ...worker.queue import Queue

    Key = tuple[int, str, tuple[BakeSpec, BakeSpec]]  # scene, object, specifications of its probes

_PULSE = 0.25  # seconds between two polls of the worker


@dataclass
class _Asked:
    """The job numbers of the two probe bakes of one object."""

    key: Key
    numbers: tuple[int, ...]


@dataclass
class _Session:
    probes: dict[Key, tuple[Probe, Probe]] = field(default_factory=dict)
    asked: list[_Asked] = field(default_factory=list)
    queue: Queue | None = None
    folder: tempfile.TemporaryDirectory[str] | None = None
    message: Message | None = None


_session = _Session()


def seconds_known(scene: bpy.types.Scene, bakes: Iterable[Bake]) -> float | None:
    """Estimated seconds for all these bakes together; None unless all of them were probed."""
    from ...bake.estimate import seconds_needed

    total = None
    for name, spec in bakes:
        probes = _session.probes.get(_key(scene, name, spec))
        if probes is None:
            return None
        total = (total or 0.0) + seconds_needed(spec, *probes)
    return total


def probe_now(scene: bpy.types.Scene, bakes: Iterable[Bake]) -> None:
    """Make the probe bakes in this process. Raises the errors of a bake."""
    from ...job.probes import probe_object

    for name, spec in bakes:
        _session.probes[_key(scene, name, spec)] = probe_object(scene, name, spec)
    panel_state.mark_stale()


def ask(scene: bpy.types.Scene, bakes: Iterable[Bake]) -> None:
    """Queue the probe bakes for a worker. Raises BakeError if the scene cannot be saved for it."""
    from ...bake.estimate import probe_specs
    from ...worker.handover import hand_over, this_program
    from ...worker.orders import order_bake
    from ...worker.queue import Queue
    from ..settings.preferences import preferred

    handover = hand_over(scene, preferred().cache)
    _session.folder = tempfile.TemporaryDirectory(prefix="radtex-probes-", ignore_cleanup_errors=True)
    queue = _session.queue = Queue(this_program())
    _session.message = None
    for name, spec in bakes:
        numbers = tuple(
            queue.add(order_bake(handover, name, small, Path(_session.folder.name, str(small.samples))))
            for small in probe_specs(spec)
        )
        _session.asked.append(_Asked(_key(scene, name, spec), numbers))
    bpy.app.timers.register(_pulse, first_interval=0.0, persistent=True)


def asking() -> bool:
    """Whether a worker is making probe bakes."""
    return _session.queue is not None


def message() -> Message | None:
    """Why the last estimate failed; empty if it did not."""
    return _session.message


def advance() -> bool:
    """Read the worker's messages; returns whether it is still running."""
    queue = _session.queue
    if queue is None:
        return False
    if queue.advance():
        return True
    jobs = {job.number: job for job in queue.snapshot()}
    for asked in _session.asked:
        _keep(asked.key, [jobs[number] for number in asked.numbers])
    _end()
    panel_state.mark_stale()
    return False


def unregister() -> None:
    """End the worker and clear all estimates."""
    if bpy.app.timers.is_registered(_pulse):
        bpy.app.timers.unregister(_pulse)
    _end()
    _session.probes.clear()
    _session.message = None


def _pulse() -> float | None:
    return _PULSE if advance() else None


def _keep(key: Key, jobs: list[Job]) -> None:
    from ...bake.estimate import Probe
    from ...bake.progress import Stage

    failed = next((job for job in jobs if not job.facts), None)
    if failed is not None:
        _session.message = failed.message
        return
    few, more = (
        Probe(
            small.texels,
            job.facts["covered_texels"],
            job.facts["paths"],
            {Stage(stage): seconds for stage, seconds in job.facts["seconds"].items()},
        )
        for small, job in zip(key[2], jobs, strict=True)
    )
    _session.probes[key] = few, more


def _end() -> None:
    if _session.queue is not None:
        _session.queue.close()
    if _session.folder is not None:
        _session.folder.cleanup()
    _session.queue, _session.folder = None, None
    _session.asked.clear()


def _key(scene: bpy.types.Scene, name: str, spec: BakeSpec) -> Key:
    from ...bake.estimate import probe_specs

    return scene.session_uid, name, probe_specs(spec)
