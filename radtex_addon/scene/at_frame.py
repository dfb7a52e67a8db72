# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Set scenes to another frame of their animation."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from .checks.refusals import refuse_unbaked_rigid_bodies


@contextmanager
def at_frame(scene: bpy.types.Scene, frame: int | None) -> Iterator[None]:
    """Set a scene to a frame, and back to its own frame at exit; None changes nothing.

    Values of animated properties that were changed but not keyed are lost, as with any change of frame in
    Blender. Raises InputError if rigid bodies would have to be simulated up to that frame.
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
