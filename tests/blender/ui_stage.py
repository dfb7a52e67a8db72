# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""RadTex registered as Blender does it, for tests of what it registers."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import bpy

from radtex_addon.ui import registration
from radtex_addon.ui.jobs import jobs
from radtex_addon.ui.jobs.bake_times import history_file
from radtex_addon.ui.settings.preferences import ADDON
from radtex_addon.worker.job import Job

context: Any = bpy.context  # to the stubs, every pointer may be None
ops: Any = bpy.ops  # and they know Blender's own operators only
PATIENCE = 120.0  # seconds for a worker


@contextmanager
def registered() -> Iterator[None]:
    """RadTex, with preferences of its own."""
    history_file().unlink(missing_ok=True)  # of bakes by other tests
    registration.register()
    with _undirtied():
        context.preferences.addons.new().module = ADDON
    try:
        yield
    finally:
        if ADDON in context.preferences.addons:  # unless the test went back to factory settings
            with _undirtied():
                context.preferences.addons.remove(context.preferences.addons[ADDON])
        registration.unregister()


@contextmanager
def _undirtied() -> Iterator[None]:
    """Let preferences count as changed only if they were: `empty_file` reads them again then."""
    dirty = context.preferences.is_dirty
    yield
    context.preferences.is_dirty = dirty


def settings() -> Any:
    """The open scene's."""
    return context.scene.radtex


def preferences() -> Any:
    """RadTex's."""
    return context.preferences.addons[ADDON].preferences


def properties_of(cls: Any) -> list[Any]:
    """What a registered class shows; Blender's own properties have no description of ours."""
    found = cls.bl_rna.properties
    if issubclass(cls, bpy.types.Operator):  # whose class does not know them
        found = getattr(ops.radtex, cls.bl_idname.partition(".")[2]).get_rna_type().properties
    kept = {"rna_type", "name", "bl_idname"}
    return [one for one in found if one.is_runtime and one.identifier not in kept]


def finish_jobs() -> tuple[Job, ...]:
    """Pulse as the timer does, until no job is left to do."""
    until = time.monotonic() + PATIENCE
    while jobs.advance():
        assert time.monotonic() < until, jobs.snapshot()
        time.sleep(0.05)
    return jobs.snapshot()
