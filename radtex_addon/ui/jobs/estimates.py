# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Estimate how long bakes take: at once, from earlier bakes, or after measuring small parts of them.

A worker measures all objects in one process; without a window this process does.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from time import monotonic
from typing import TYPE_CHECKING, Any, NamedTuple

import bpy

from ..panel import panel_state
from ..panel.redraw import redraw
from . import bake_times

if TYPE_CHECKING:
    from ...core.messages import Message
    from ...job.probes import Probe
    from ...job.variants import Bake
    from ...settings.estimate import BakeWork, Basis, Estimate
    from ...settings.spec import BakeSpec
    from ...settings.time_left import Left
    from ...worker.job import Job
    from ...worker.queue import Queue

    Key = tuple[int, str, str, str]  # scene, object, kind, layout

_PULSE = 0.5  # seconds between two polls of the worker, and so at least between two redraws for it


class KnownTime(NamedTuple):
    """Expected seconds of bakes together, and the worst of what the estimates of the single ones rest on.

    `range` is how long they take at least and at most.
    """

    seconds: float
    basis: Basis
    range: Left


class _Probed(NamedTuple):
    """A probe, the specification that it is of, and the object's triangles in the viewport then."""

    spec: BakeSpec
    probe: Probe
    shown_triangles: int


@dataclass
class _Session:
    """Probes of this session, and the worker that makes more.

    It was `asked` for the bakes of a scene, whose objects had so many triangles in the viewport.
    """

    probes: dict[Key, _Probed] = field(default_factory=dict)
    asked: tuple[int, tuple[Bake, ...], tuple[int, ...]] = (0, (), ())
    queue: Queue | None = None
    shown: Job | None = None
    since: float = 0.0
    took: float | None = None
    message: Message | None = None


_session = _Session()


def seconds_known(scene: bpy.types.Scene, bakes: Iterable[Bake]) -> KnownTime | None:
    """The expected time of all these bakes together, one after another; None without bakes.

    It is that of the whole job: the worker's start, the bake, and the preview, but no exports. Quick; nothing
    is measured.
    """
    from ...settings.estimate import Basis
    from ...settings.time_left import NO_TIME, expected_time

    preview: bool = scene.radtex.preview  # type: ignore[attr-defined]  # ours, not Blender's
    total, bases, together = 0.0, [], NO_TIME
    for name, spec in bakes:
        made = expected_of(scene, name, spec, preview)
        total += made.total
        bases.append(made.basis)
        together += expected_time(made)
    return KnownTime(total, max(bases, key=list(Basis).index), together) if bases else None


def expected_of(
    scene: bpy.types.Scene, name: str, spec: BakeSpec, preview: bool, exports: int = 0
) -> Estimate:
    """The expected time of each stage of a bake, with so many exports, by all that was measured here."""
    from ...settings.estimate import estimate

    place, history = bake_times.scene_key(scene.name), bake_times.measured()
    found = _session.probes.get(_key(scene, name, spec))
    probes = () if found is None else found.probe.measurements(place, name, found.spec)
    work = replace(_work_of(scene, name, spec), preview=preview, exports=exports)
    return estimate(work, place, name, (*history, *probes))


def probe_now(scene: bpy.types.Scene, bakes: Iterable[Bake]) -> None:
    """Measure small parts of the bakes in this process. Raises the errors of a bake."""
    from ...job.probes import probe_object

    since = monotonic()
    for name, spec in bakes:
        shown = _shown_triangles(scene, name, spec)
        _session.probes[_key(scene, name, spec)] = _Probed(spec, probe_object(scene, name, spec), shown)
    _session.took = monotonic() - since
    panel_state.mark_stale()


def ask(scene: bpy.types.Scene, bakes: Iterable[Bake]) -> None:
    """Let a worker measure small parts of the bakes. Raises BakeError if the scene cannot be saved for it."""
    from ...worker.handover import hand_over, this_program
    from ...worker.orders import order_estimate
    from ...worker.queue import Queue
    from ..settings.preferences import preferred

    asked = tuple(bakes)
    _session.since, _session.message, _session.took = monotonic(), None, None
    order = order_estimate(hand_over(scene, preferred().cache), asked)
    queue = Queue(this_program())
    queue.add(order)
    shown = tuple(_shown_triangles(scene, name, spec) for name, spec in asked)
    _session.queue, _session.asked = queue, (scene.session_uid, asked, shown)
    (_session.shown,) = queue.snapshot()
    bpy.app.timers.register(_pulse, first_interval=0.0, persistent=True)


def asking() -> bool:
    """Whether a worker is measuring."""
    return _session.queue is not None


def progress() -> tuple[int, int]:
    """The object that is being measured, counted from 1, and how many there are."""
    total = len(_session.asked[1])
    done = 0.0 if _session.shown is None else _session.shown.fraction
    return min(total, round(done * total) + 1), total


def cancel() -> None:
    """Let the worker stop; what it has measured is forgotten."""
    if _session.queue is not None:
        _session.queue.cancel_all()


def took() -> float | None:
    """How many seconds the last measurement took; None if there was none, or it failed."""
    return _session.took


def message() -> Message | None:
    """Why the last measurement failed; None if it did not, or was cancelled."""
    return _session.message


def advance() -> bool:
    """Read the worker's messages; returns whether it is still running."""
    queue = _session.queue
    if queue is None:
        return False
    more = queue.advance()
    (job,) = queue.snapshot()
    _session.shown = job
    if more:
        return True
    if job.state == "done":
        _keep(job.facts)
    elif job.state == "failed":
        _session.message = job.message
    _end()
    panel_state.mark_stale()
    return False


def unregister() -> None:
    """End the worker and clear all measurements."""
    if bpy.app.timers.is_registered(_pulse):
        bpy.app.timers.unregister(_pulse)
    _end()
    _session.probes.clear()
    _session.message = _session.took = None


def _pulse() -> float | None:
    before = progress()
    more = advance()
    if progress() != before:
        redraw()
    return _PULSE if more else None


def _keep(facts: Mapping[str, Any]) -> None:
    from ...job.probes import Probe

    uid, bakes, shown = _session.asked
    for (name, spec), count, told in zip(bakes, shown, facts["probes"], strict=True):
        _session.probes[uid, name, str(spec.kind), spec.form.name] = _Probed(spec, Probe.of(told), count)
    _session.took = monotonic() - _session.since


def _end() -> None:
    if _session.queue is not None:
        _session.queue.close()
    _session.queue = _session.shown = None
    _session.asked = 0, (), ()


def _key(scene: bpy.types.Scene, name: str, spec: BakeSpec) -> Key:
    return scene.session_uid, name, str(spec.kind), spec.form.name


def _work_of(scene: bpy.types.Scene, name: str, spec: BakeSpec) -> BakeWork:
    """The bake's work: measured by a probe, else like that of its last bake, else a guess."""
    from ...cycles.device import preferred_device
    from ...settings.estimate import BakeWork

    device = preferred_device() if spec.device == "auto" else spec.device
    shown = _shown_triangles(scene, name, spec)
    triangles, texels, share = shown, spec.texels, None
    found = _session.probes.get(_key(scene, name, spec))
    if found is not None:
        probe = found.probe
        triangles = _triangles_now(probe.triangles, found.shown_triangles, shown)
        share = probe.covered / probe.texels**2
        if spec.density is not None and found.spec.density == spec.density:
            texels = probe.texels
    else:
        place = bake_times.scene_key(scene.name)
        last = [one for one in bake_times.measured() if (one.place, one.name) == (place, name)]
        if last:
            work = last[-1].work
            triangles = _triangles_now(work.triangles, last[-1].shown_triangles, shown)
            share = work.covered / work.texels**2
    covered = None if share is None else max(1, round(share * texels**2))
    return BakeWork.of(spec, triangles, covered=covered, texels=texels, device=device)


def _triangles_now(baked: int, shown_then: int, shown_now: int) -> int:
    """The triangles of a bake now, where an earlier one had `baked`, by what the viewport showed."""
    return round(baked * shown_now / shown_then) if shown_then and shown_now else baked


def _shown_triangles(scene: bpy.types.Scene, name: str, spec: BakeSpec) -> int:
    return bake_times.shown_triangles(scene, spec.objects or (name,))
