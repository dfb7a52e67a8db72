# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Read what a scene renders now, and the fingerprint that a bake of it leaves in its sidecar."""

from __future__ import annotations

import bpy

from ..core.errors import FormatError
from ..formats.fingerprint import Fingerprint, fingerprint_in
from ..formats.sidecar_file import read_facts
from ..preview.kept_copies import copies_not_rendered
from ..preview.swap import previews_not_rendered
from ..scene.digests import SceneDigests, read_scene
from ..scene.scratch import scratch_scene
from ..settings.spec import BakeSpec
from ..store.output_files import OutputFiles


def read_now(scene: bpy.types.Scene, frame: int | None = None, view_layer: str | None = None) -> SceneDigests:
    """Digests of all that renders of a scene's view layer show, at a frame, or else at the scene's own.

    The scene is evaluated once, and is unchanged afterwards. Where a bake is shown in an object's place, the
    object is read. Raises InputError as `scratch_scene` does.
    """
    with scratch_scene(scene, view_layer) as scratch:
        if frame is not None:
            scratch.frame_current, scratch.frame_subframe = frame, 0.0
        return read_originals(scratch)


def read_originals(scratch: bpy.types.Scene) -> SceneDigests:
    """Digests of what a scratch scene shows with the objects in the place of bakes that are shown."""
    with copies_not_rendered(scratch), previews_not_rendered(scratch):
        return read_scene(scratch)


def fingerprint_of_bake(
    now: SceneDigests, layer: bpy.types.ViewLayer, name: str, spec: BakeSpec, files: OutputFiles
) -> Fingerprint | None:
    """The fingerprint of an atlas that a bake of a scene makes `now`, or adds to; None if not known."""
    found = now.of_bake(name, spec, layer)
    if not spec.incremental:
        return found
    return found.folded_onto(_earlier(files), everywhere=spec.refresh and spec.where is None)


def _earlier(files: OutputFiles) -> Fingerprint | None:
    try:
        return fingerprint_in(read_facts(files.sidecar))
    except FormatError:
        return None
