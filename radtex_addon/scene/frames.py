# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes at another frame of their animation."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from .checks.refusals import refuse_unbaked_rigid_bodies


@contextmanager
def at_frame(scene: bpy.types.Scene, frame: int | None) -> Iterator[None]:
    """Put a scene to a frame, and back to its own afterwards; None changes nothing.

    What was changed by hand on an animated property, and not keyed, goes back to its keys, as ever when
    frames change. Raises InputError for rigid bodies that would have to be simulated until then.
    """
    if frame is None:
        yield
        return
    before, part = scene.frame_current, scene.frame_subframe
    try:
        scene.frame_set(frame)
        refuse_unbaked_rigid_bodies(scene)
        yield
    finally:
        scene.frame_set(before, subframe=part)
