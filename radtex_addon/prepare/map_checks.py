# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a UV map wastes its atlas, and what to do about it."""

from __future__ import annotations

from ..core.messages import Message, Remedy, Setting, do, leave_out
from ..core.uv_map import UvMap
from ..scene.mesh.copy import UV_LAYER
from ..settings.spec import BakeSpec, Unwrap
from .unwrapping import COUNTED

_DRAFT = 64  # texels along the longer side: in fewer, gutters and seams take most of any map
_LEAST_COVERED = 0.35  # of the atlas
_MOST_SEAMS = 0.5  # of the islands' texels


def why_wasteful(uv_map: UvMap) -> str:
    """Why a map wastes its atlas, to go on after "the map …"; empty if it does not.

    It does if it leaves most of the atlas empty, or if most of its texels lie along seams, where each shows
    only part of a place. Small atlases are not judged, and seams are not looked for in very large meshes.
    """
    if max(uv_map.width, uv_map.height) < _DRAFT:
        return ""
    found = []
    if uv_map.coverage < _LEAST_COVERED:
        found.append(f"covers only {uv_map.coverage:.0%} of {uv_map.width} x {uv_map.height} texels")
    seams = uv_map.seams if len(uv_map.uv) <= COUNTED else 0.0
    if seams > _MOST_SEAMS:
        found.append(f"has {seams:.0%} of what it covers within a texel of seams")
    return " and ".join(found)


def wasteful_map(name: str, wasteful: str, layer: str, spec: BakeSpec) -> Message | None:
    """A warning of a map on the UV layer `layer` that is `wasteful`, and what to do; None if it is not."""
    if not wasteful:
        return None
    part = "" if spec.part is None else f", {spec.split} '{spec.part}',"
    return Message(f"the map of '{name}'{part} {wasteful}", _remedies(layer, spec))


def _remedies(layer: str, spec: BakeSpec) -> tuple[Remedy, ...]:
    if spec.uv_layer is not None:
        return (
            do("fill the square with fewer, larger islands"),
            leave_out(Setting.UV, to="to have one made"),
        )
    size = Setting.TEXELS if spec.density is None else Setting.DENSITY
    more = do("give it more texels", size)
    if layer != UV_LAYER or spec.unwrap not in (Unwrap.AUTO, Unwrap.UVUNWRAP):
        return more, do("have a new one made", Setting.UNWRAP, value=str(Unwrap.UVUNWRAP))
    return more, do("bake on a UV layer of your own", Setting.UV)
