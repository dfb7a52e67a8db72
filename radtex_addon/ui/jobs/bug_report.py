# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Text for a report of a bug: versions, system, a job's settings, and what it said."""

from __future__ import annotations

import json
import platform
import sys
from typing import TYPE_CHECKING

import bpy

from ...version import VERSION

if TYPE_CHECKING:
    from ...worker.job import Job


def report_of(job: Job | None) -> str:
    """Versions and system; with a job its state, message, warnings, settings and the end of its log.

    Folders are named as they are: users see the text before they send it.
    """
    blender = f"Blender {bpy.app.version_string} ({_text(bpy.app.build_hash)})"
    lines = [
        f"RadTex {VERSION}, {blender}, Python {sys.version.split()[0]}",
        f"{platform.platform()}, {platform.machine()}",
    ]
    if job is None:
        return "\n".join(lines)
    lines += [f"{job.work} of {job.object}: {job.state}, at {job.fraction:.0%} ({job.stage})"]
    lines += [str(said) for said in (job.message, *job.warnings) if str(said)]
    if "spec" in job.order.facts:
        lines.append(json.dumps(job.order.facts["spec"], sort_keys=True))
    return "\n".join([*lines, "", job.log]).rstrip()


def _text(raw: bytes | str) -> str:
    return raw.decode(errors="replace") if isinstance(raw, bytes) else raw
