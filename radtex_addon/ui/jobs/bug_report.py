# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Text for a report of a bug: versions, system, a job's settings, and what it said."""

from __future__ import annotations

import json
import os
import platform
import sys
from typing import TYPE_CHECKING

import bpy
import gpu

from ...version import VERSION

if TYPE_CHECKING:
    from ...worker.job import Job


def report_of(job: Job | None) -> str:
    """Versions, system, hardware; with a job its state, message, warnings, settings and the end of its log.

    Folders are named as they are: users see the text before they send it.
    """
    blender = f"Blender {bpy.app.version_string} ({_text(bpy.app.build_hash)})"
    lines = [
        f"RadTex {VERSION}, {blender}, Python {sys.version.split()[0]}",
        f"{platform.platform()}, {platform.machine()}",
        *_hardware(),
    ]
    if job is None:
        return "\n".join(lines)
    lines += [f"{job.work} of {job.object}: {job.state}, at {job.fraction:.0%} ({job.stage})"]
    lines += [str(said) for said in (job.message, *job.warnings) if str(said)]
    if "spec" in job.order.facts:
        lines.append(json.dumps(job.order.facts["spec"], sort_keys=True))
    return "\n".join([*lines, "", job.log]).rstrip()


def _hardware() -> list[str]:
    """Lines on processor and memory, on what draws Blender's window, and on what Cycles renders with here."""
    from ...core.errors import InputError
    from ...cycles.device import known_devices, preferred_device
    from ...formats.disk.memory import physical_memory, readable_size
    from ..settings.preferences import preferred

    memory = physical_memory()
    has = f", {readable_size(memory)} of memory" if memory is not None else ""
    try:
        devices = known_devices()
        processors = [name for kind, name in devices if kind == "CPU"]
        others = ", ".join(f"{name} ({kind})" for kind, name in devices if kind != "CPU") or "no GPU"
        chosen = preferred_device().upper()
        cycles = f"Cycles: {others}; RadTex's device: {preferred().device}; Automatic is {chosen}"
    except InputError as error:  # Cycles is switched off
        processors, cycles = [], str(error)
    processor = ", ".join(processors) or platform.processor() or "unknown"
    return [f"CPU: {processor}, {os.cpu_count()} threads{has}", f"Window: {_drawn_by()}", cycles]


def _drawn_by() -> str:
    """The graphics card that draws Blender's window, and its driver."""
    if bpy.app.background:
        return "none"
    return f"{gpu.platform.renderer_get()}, {gpu.platform.backend_type_get()}, {gpu.platform.version_get()}"


def _text(raw: bytes | str) -> str:
    return raw.decode(errors="replace") if isinstance(raw, bytes) else raw
