# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a finished bake looks like: the material of its kind, and the .blend that shows it."""

from __future__ import annotations

import bpy

from ..bake.spec import BakeSpec, Kind, Layout
from ..core.sampler import Filter
from ..preview.material import preview_material, preview_shared_material
from ..preview.occlusion import preview_ambient_material, preview_shadow_material
from ..preview.save import save_preview
from ..preview.sun import preview_transfer_material
from ..scene.copy import copy_object
from ..scene.enclosed import EVERYTHING, find_content
from ..scene.scratch import find_view_layer
from .made import Made
from .prepare import Prepared


def save_preview_of(
    scene: bpy.types.Scene,
    name: str,
    spec: BakeSpec,
    made: Made,
    prepared: Prepared,
    preview: Filter,
    view_layer: str | None,
) -> None:
    """Write `<name>.preview.blend` of the object `name` as it was baked. Raises BakeError as it cannot."""
    assert made.files.preview is not None  # there is one where there is a filter
    material = _material(f"RadTex {name}", spec, made, prepared.uv_layer, preview, scene)
    original = scene.objects[name]
    copy = copy_object(original, prepared.mesh)
    hidden: tuple[bpy.types.Object, ...] = ()
    if spec.kind is Kind.PROXY and spec.content != EVERYTHING:
        hidden = find_content(find_view_layer(scene, view_layer), original, spec.content)
    if spec.source is not None:
        hidden = (scene.objects[spec.source],)
    save_preview(scene, original, copy, material, made.files.preview.absolute(), hidden)


def _material(
    title: str, spec: BakeSpec, made: Made, uv_layer: str, preview: Filter, scene: bpy.types.Scene
) -> bpy.types.Material:
    if spec.layout is Layout.SHARED:
        return preview_shared_material(title, made.files.sidecar.absolute(), uv_layer, spec.half)
    if spec.kind is Kind.SHADOW:
        return preview_shadow_material(title, made.files.sidecar.absolute(), uv_layer, scene, preview)
    clear = spec.kind is Kind.RADIANCE and scene.render.film_transparent  # its far side is seen through it
    hull = spec.kind is Kind.PROXY or clear
    atlas = made.files.atlas.absolute()
    if spec.kind is Kind.TRANSFER:
        return preview_transfer_material(title, atlas, made.layout, uv_layer, scene, spec.half)
    if spec.kind is Kind.AO:
        return preview_ambient_material(title, atlas, made.layout, uv_layer, spec.half)
    return preview_material(title, atlas, made.layout, uv_layer, preview, spec.half, hull)
