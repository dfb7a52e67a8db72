# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run by the Blender under test: a timer that executes what is asked for, and notes how long ticks are apart.

Usage: blender -P driver.py -- FOLDER. A question is FOLDER/ask.py, which leaves its answer in `answer`; that
comes as JSON in FOLDER/answer.json.
"""

from __future__ import annotations

import json
import sys
import traceback
from pathlib import Path
from time import monotonic
from typing import Any

import bpy

sys.path.append("/repository")
from tests.real.inside.window import room  # found by now

INTERVAL = 0.02  # seconds
folder = Path(sys.argv[sys.argv.index("--") + 1])
ticks: list[float] = []
states: list[tuple[Any, ...]] = []  # of `jobs`, whenever one changed


def jobs() -> list[tuple[Any, ...]]:
    """(number, object, state, fraction, message) of all jobs, as the panel knows them."""
    known_to = sys.modules.get("bl_ext.user_default.radtex.radtex_addon.ui.jobs.jobs")
    return [
        (job.number, job.object, str(job.state), round(job.fraction, 4), str(job.message))
        for job in (known_to.snapshot() if known_to is not None else ())
    ]


def tick() -> float:
    """Note the time, and what bakes do; answer what is asked."""
    ticks.append(monotonic())
    _note_states()
    question = folder / "ask.py"
    if question.is_file():
        code = question.read_text(encoding="utf-8")
        question.unlink()
        unfinished = folder / "answer.unfinished"
        unfinished.write_text(json.dumps(_answered(code)), encoding="utf-8")
        unfinished.rename(folder / "answer.json")
    return INTERVAL


def _answered(code: str) -> dict[str, Any]:
    known["answer"] = None
    try:
        exec(code, known)
    except Exception:  # noqa: BLE001  # whatever it is, the test shall read it
        return {"error": traceback.format_exc()}
    return {"answer": known["answer"]}


def _note_states() -> None:
    for job in jobs():
        if job not in states[-8:]:
            states.append(job)


known: dict[str, Any] = {"bpy": bpy, "room": room, "ticks": ticks, "states": states, "jobs": jobs}
assert bpy.context.preferences is not None  # only restricted contexts have none
bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(tick, persistent=True)
