# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes at another frame of their animation."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from .refusals import refuse_unbaked_rigid_bodies


@contextmanager
def at_frame(scene: bpy.types.Scene, frame: int | None) -> Iterator[None]:
    """Put a scene to a frame, and back to its own afterwards; None changes nothing.

    Blender renders any scene at the frame of the one that is open, so that one goes along. What was changed
    by hand on an animated property, and not keyed, goes back to its keys, as ever when frames change. Raises
    InputError for rigid bodies that would have to be simulated until then.
    """
    if frame is None:
        yield
        return
    opened = bpy.context.scene
    scenes = [scene] if opened is None or opened == scene else [scene, opened]
    before = [(item, item.frame_current, item.frame_subframe) for item in scenes]
    try:
        for item in scenes:
            item.frame_set(frame)
        refuse_unbaked_rigid_bodies(scene)
        yield
    finally:
        for item, number, part in before:
            item.frame_set(number, subframe=part)
