# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The facts in the sidecar that do not depend on how a bake is stored."""

from __future__ import annotations

import bpy

from ..formats.fingerprint import Fingerprint
from ..formats.sidecar import Part, Sidecar, Source, TexelDensity
from ..settings.bake_names import own_name
from ..settings.spec import BakeSpec
from ..version import VERSION


def facts_of(
    name: str,
    spec: BakeSpec,
    width: int,
    height: int,
    uv_layer: str,
    mesh: str = "",
    source: Source | None = None,
    part: Part | None = None,
    islands: int | None = None,
    coverage: float | None = None,
    texel_density: TexelDensity | None = None,
    wasteful: str = "",
    fingerprint: Fingerprint | None = None,
    blend: str = "",
) -> Sidecar:
    """The sidecar's facts about a bake called `name` with `width` x `height` texels."""
    return Sidecar(
        object_name=name,
        kind=spec.kind,
        width=width,
        height=height,
        bucket=spec.bucket,
        uv_map=uv_layer,
        samples=spec.samples,
        seed=spec.seed,
        capture=spec.capture,
        tool=f"RadTex {VERSION}",
        blender=bpy.app.version_string,
        mesh=mesh,
        source=source,
        frame=spec.frame,
        lights=spec.lights,
        objects=spec.objects,
        part=part,
        islands=islands,
        coverage=coverage,
        texel_density=texel_density,
        wasteful=wasteful,
        fingerprint=fingerprint,
        marks=spec.marks,
        blend=blend,
        texel_weights=spec.texel_weights or "",
        backs=str(spec.backs) if spec.form.backs else "",
        called=own_name(spec.bake_name, name),
    )
