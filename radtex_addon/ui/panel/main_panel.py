# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The sidebar's tab "RadTex". Panels only draw the cached `Forecast`: they compute nothing."""

from __future__ import annotations

from typing import Any, cast

import bpy

from ...bake.forms import FormTraits
from ...bake.kinds import Kind, Layout, Light, form_in
from ..jobs import jobs
from ..operators.switch import LARGE, draw_shading, draw_switch
from ..settings.bake_settings import BakeSettings
from ..settings.presets import RADTEX_PT_presets
from ..settings.surfaces import draw_surfaces
from .draw_messages import draw_remarks, draw_text
from .labels import iface_
from .panel_state import Forecast, cached_forecast


class Sidebar:
    """Mixin that places a panel in the 3D view's sidebar, tab RadTex."""

    bl_space_type: Any = "VIEW_3D"
    bl_region_type: Any = "UI"
    bl_category = "RadTex"


class RADTEX_PT_bake(Sidebar, bpy.types.Panel):
    """What to bake, and the button"""

    bl_label = "Bake Radiance Texture"

    def draw_header_preset(self, context: bpy.types.Context | None) -> None:
        RADTEX_PT_presets.draw_panel_header(self.layout)

    def draw(self, context: bpy.types.Context | None) -> None:
        layout, settings, found = drawn(self, context)
        _draw_objects(layout, found)
        _draw_kind(layout.column(), settings)
        if found is not None and found.layout:
            draw_text(layout.box(), found.layout, "INFO")
        draw_surfaces(layout.column(), settings, found is not None and len(found.objects) > 1)
        _draw_uv(layout, settings, context)
        if Kind(settings.kind).traits.source:
            column = layout.column()
            assert context is not None  # Blender always gives one
            column.prop_search(settings, "source", context.scene, "objects")
            if settings.source:
                column.prop_search(settings, "cage", context.scene, "objects")
                if not settings.cage:
                    column.prop(settings, "extrusion")
        column = layout.column()
        column.prop(settings, "variants")
        if settings.variants == "frames":
            column.prop(settings, "frames")
        if found is not None:
            draw_remarks(layout, settings, found)
            _draw_preview(layout, found, context)
        row = layout.row()
        row.scale_y = LARGE
        row.enabled = found is None or not found.errors
        row.operator("radtex.bake", icon="RENDER_STILL")


class RADTEX_PT_quality(Sidebar, bpy.types.Panel):
    """How fine, how sharp and how clean the bake will be"""

    bl_label = "Quality"
    bl_parent_id = "RADTEX_PT_bake"

    def draw(self, context: bpy.types.Context | None) -> None:
        layout, settings, found = drawn(self, context)
        layout.row().prop(settings, "atlas_size", expand=True)
        column = layout.column(align=True)
        kind = Kind(settings.kind).traits
        for name, shown in (
            (settings.atlas_size, True),  # "texels" or "density"
            ("bucket", kind.cells and form_of(settings).any_cells),
            ("samples", kind.samples),
        ):
            if shown:
                column.prop(settings, name)
        for line in found.sizes if found is not None else ():
            draw_text(layout, line, "INFO")
        layout.prop(settings, "seed")
        if kind.light is not Light.OCCLUSION and not form_of(settings).by_paths:
            layout.prop(settings, "denoise")


class RADTEX_PT_output(Sidebar, bpy.types.Panel):
    """Where files go, and which"""

    bl_label = "Output"
    bl_parent_id = "RADTEX_PT_bake"
    bl_options: Any = {"DEFAULT_CLOSED"}

    def draw(self, context: bpy.types.Context | None) -> None:
        layout, settings, _ = drawn(self, context)
        layout.prop(settings, "directory", text="Folder")
        column = layout.column(heading="Files")
        column.prop(settings, "resume")
        column.prop(settings, "overwrite")
        form, kind = form_of(settings), Kind(settings.kind).traits
        if form.accumulates and kind.accumulates:
            column.prop(settings, "accumulate")
            if form.refreshes:
                column.prop(settings, "refresh")
            if form.accumulates_parts and (settings.accumulate or settings.refresh):
                column.prop(settings, "where")
        column.prop(settings, "preview")
        if kind.full_floats:
            column.prop(settings, "full_floats")
        layout.prop(settings, "compression")
        if form.layers and kind.layers:
            layout.column().prop(settings, "layers")
        layout.column().prop(settings, "export_targets")
        layout.operator("radtex.open_folder", icon="FILE_FOLDER")


def _draw_kind(column: bpy.types.UILayout, settings: BakeSettings) -> None:
    """Draw the kind and its own settings."""
    column.prop(settings, "kind")
    kind = Kind(settings.kind).traits
    if kind.views:
        column.prop(settings, "view")
    if kind.content:
        column.prop(settings, "content")
        if settings.content == "collection":
            column.prop_search(settings, "content_collection", bpy.data, "collections")
    if kind.ao_distance:
        column.prop(settings, "ao_distance")
    if kind.form is None:
        column.prop(settings, "atlas_layout")


def form_of(settings: BakeSettings) -> FormTraits:
    """The form that the settings ask for; buckets while the layout is automatic."""
    chosen = settings.atlas_layout if settings.atlas_layout in tuple(Layout) else Layout.BUCKETS
    return Kind(settings.kind).traits.form or form_in(Layout(chosen))


def drawn(
    panel: bpy.types.Panel, context: bpy.types.Context | None
) -> tuple[Any, BakeSettings, Forecast | None]:
    """The panel's layout with our options set, the scene's settings, and the cached forecast, if any."""
    assert context is not None  # Blender always gives one
    scene, view_layer = cast(bpy.types.Scene, context.scene), cast(bpy.types.ViewLayer, context.view_layer)
    layout: Any = panel.layout
    layout.use_property_split = True
    layout.use_property_decorate = False  # a bake is not animated
    settings: BakeSettings = scene.radtex  # type: ignore[attr-defined]  # ours, not Blender's
    return layout, settings, cached_forecast(scene, view_layer)


def _draw_objects(layout: Any, found: Forecast | None) -> None:
    names = found.objects if found is not None else ()
    if len(names) == 1:
        layout.label(text=names[0], icon="OUTLINER_OB_MESH", translate=False)
    elif names:
        text = iface_("{} objects").format(len(names))
        layout.label(text=text, icon="OUTLINER_OB_MESH", translate=False)
    elif found is not None:
        layout.label(text="Select a mesh object", icon="INFO")


def _draw_preview(layout: Any, found: Forecast, context: bpy.types.Context | None) -> None:
    """Draw the preview button if a bake exists and the job list does not offer it; and shading buttons."""
    assert context is not None  # Blender always gives one
    offered = {job.object for job in jobs.snapshot() if job.state == "done" and job.work == "bake"}
    if (found.baked or found.shown) and not offered.intersection(found.objects):
        draw_switch(layout, context.active_object)
    if found.shown:
        draw_shading(layout.column(), context.space_data)


def _draw_uv(layout: Any, settings: BakeSettings, context: bpy.types.Context | None) -> None:
    item = context.active_object if context is not None else None
    column = layout.column()
    if item is not None and item.type == "MESH":
        column.prop_search(settings, "uv_layer", item.data, "uv_layers", icon="GROUP_UVS")
    else:
        column.prop(settings, "uv_layer", icon="GROUP_UVS")
    if not settings.uv_layer:
        column.prop(settings, "unwrap")
        column.prop(settings, "padding")
