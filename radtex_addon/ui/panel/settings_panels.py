# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Folded panels below the button: all settings but the few that the main panel shows."""

from __future__ import annotations

from typing import Any

import bpy

from ...bake.forms import FormTraits
from ...bake.kinds import Kind, Layout, Light, form_in
from ..settings.bake_settings import BakeSettings
from ..settings.surfaces import draw_surfaces
from .draw_messages import draw_text
from .main_panel import Sidebar, drawn


class _Folded(Sidebar):
    """Mixin of the folded panels below the button."""

    bl_parent_id = "RADTEX_PT_bake"
    bl_options: Any = {"DEFAULT_CLOSED"}


class RADTEX_PT_light(_Folded, bpy.types.Panel):
    """Which light is baked, and how it is stored"""

    bl_label = "Light"

    def draw(self, context: bpy.types.Context | None) -> None:
        layout, settings, found = drawn(self, context)
        column = layout.column()
        column.prop(settings, "kind")
        kind, form = Kind(settings.kind).traits, form_of(settings)
        if kind.views:
            column.prop(settings, "view")
        if kind.content:
            column.prop(settings, "content")
            if settings.content == "collection":
                column.prop_search(settings, "content_collection", bpy.data, "collections")
        if kind.ao_distance:
            column.prop(settings, "ao_distance")
        if not kind.content:
            column.prop(settings, "alone")
        if kind.form is None:
            column.prop(settings, "atlas_layout")
        if found is not None and found.layout:
            draw_text(layout, found.layout, "INFO")
        column = layout.column()
        column.prop(settings, "variants")
        if settings.variants == "frames":
            column.prop(settings, "frames")
        if form.layers and kind.layers:
            layout.column().prop(settings, "layers")


class RADTEX_PT_surface(_Folded, bpy.types.Panel):
    """How the surface is laid out in the texture, and whose light it shows"""

    bl_label = "Surface"

    def draw(self, context: bpy.types.Context | None) -> None:
        layout, settings, found = drawn(self, context)
        assert context is not None  # Blender always gives one
        layout.row().prop(settings, "atlas_size", expand=True)
        _draw_uv(layout.column(), settings, context.active_object)
        draw_surfaces(layout.column(), settings, found is not None and len(found.objects) > 1)
        if not Kind(settings.kind).traits.source:
            return
        column = layout.column()
        column.prop_search(settings, "source", context.scene, "objects")
        if settings.source:
            column.prop_search(settings, "cage", context.scene, "objects")
            if not settings.cage:
                column.prop(settings, "extrusion")


class RADTEX_PT_sampling(_Folded, bpy.types.Panel):
    """How sharp reflections are, and how clean"""

    bl_label = "Sampling"

    def draw(self, context: bpy.types.Context | None) -> None:
        layout, settings, _ = drawn(self, context)
        kind, form = Kind(settings.kind).traits, form_of(settings)
        if kind.cells and form.any_cells:
            layout.prop(settings, "bucket")
        layout.prop(settings, "seed")
        if kind.light is not Light.OCCLUSION and not form.by_paths:
            layout.prop(settings, "denoise")


class RADTEX_PT_output(_Folded, bpy.types.Panel):
    """Where files go, and which"""

    bl_label = "Output"

    def draw(self, context: bpy.types.Context | None) -> None:
        layout, settings, _ = drawn(self, context)
        layout.prop(settings, "directory", text="Folder")
        form, kind = form_of(settings), Kind(settings.kind).traits
        if form.accumulates and kind.accumulates:
            column = layout.column(heading="Earlier Bake")
            column.prop(settings, "accumulate")
            if form.refreshes:
                column.prop(settings, "refresh")
            if form.accumulates_parts and (settings.accumulate or settings.refresh):
                column.prop(settings, "where")
        column = layout.column(heading="Files")
        column.prop(settings, "preview")
        if kind.full_floats:
            column.prop(settings, "full_floats")
        layout.prop(settings, "compression")
        layout.column().prop(settings, "export_targets")
        layout.operator("radtex.open_folder", icon="FILE_FOLDER")


def form_of(settings: BakeSettings) -> FormTraits:
    """The form that the settings ask for; buckets while the layout is automatic."""
    chosen = settings.atlas_layout if settings.atlas_layout in tuple(Layout) else Layout.BUCKETS
    return Kind(settings.kind).traits.form or form_in(Layout(chosen))


def _draw_uv(column: Any, settings: BakeSettings, item: bpy.types.Object | None) -> None:
    if item is not None and item.type == "MESH":
        column.prop_search(settings, "uv_layer", item.data, "uv_layers", icon="GROUP_UVS")
    else:
        column.prop(settings, "uv_layer", icon="GROUP_UVS")
    if not settings.uv_layer:
        column.prop(settings, "unwrap")
        column.prop(settings, "padding")
