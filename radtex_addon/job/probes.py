# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run the two small bakes from which a bake's time is estimated (`bake.estimate`)."""

from __future__ import annotations

import bpy

from ..bake.estimate import Probe, probe_specs
from ..bake.spec import BakeSpec
from ..formats.disk.temporary import temporary_folder
from .baking import bake_object


def probe_object(
    scene: bpy.types.Scene, name: str, spec: BakeSpec, view_layer: str | None = None
) -> tuple[Probe, Probe]:
    """Bake the object twice, small, into a temporary folder; returns both costs. Raises as `bake_steps`."""
    few, more = (_probe(scene, name, small, view_layer) for small in probe_specs(spec))
    return few, more


def _probe(scene: bpy.types.Scene, name: str, spec: BakeSpec, view_layer: str | None) -> Probe:
    with temporary_folder() as folder:
        made = bake_object(scene, name, spec, folder, view_layer=view_layer)
        return Probe(spec.texels, made.covered_texels, made.paths, made.seconds)
