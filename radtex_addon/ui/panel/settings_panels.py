# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Folded panels below the button: all settings but the few that the main panel shows."""

from __future__ import annotations

from typing import Any, cast

import bpy

from ...settings.bake_names import OBJECT
from ...settings.forms import FormTraits
from ...settings.kinds import Kind, Layout, form_in
from ...settings.option import Fold
from ...settings.options import OPTIONS, shown_in
from ..operators.export_dialog import shortened
from ..settings.bake_settings import BakeSettings
from ..settings.kept_exports import kept_export, rows_of
from ..settings.object_settings import owner_of
from .fitting import draw_button, draw_search, draw_setting, draw_text, headed
from .labels import iface_
from .main_panel import Sidebar, drawn

# Settings that are drawn below in a way, or under a condition, of their own.
_BY_HAND = frozenset(
    (
        *("variants", "frames", "layers"),
        *("atlas_size", "uv_layer", "unwrap", "texel_weights", "backs", "padding"),
        *("together", "atlas_name", "split", "part"),
        *("source", "cage", "extrusion"),
        *("directory", "bake_name", "accumulate", "refresh", "where"),
        *("preview", "full_floats", "compression", "export_targets"),
    )
)
_MOST_KEPT = 8  # exports after each bake that are listed


class _Folded(Sidebar):
    """Mixin of the folded panels below the button."""

    bl_parent_id = "RADTEX_PT_bake"
    bl_options: Any = {"DEFAULT_CLOSED"}


class RADTEX_PT_light(_Folded, bpy.types.Panel):
    """Which light is baked, and how it is stored"""

    bl_label = Fold.LIGHT.value

    def draw(self, context: bpy.types.Context | None) -> None:
        layout, settings, found = drawn(self, context)
        _draw_others(layout.column(), settings, Fold.LIGHT)
        if found is not None and found.layout:
            draw_text(layout, found.layout, "INFO")
        column = layout.column()
        draw_setting(column, settings, "variants")
        if settings.variants == "frames":
            draw_setting(column, settings, "frames")
        if OPTIONS["layers"].applies(Kind(settings.kind).traits, form_of(settings)):
            draw_setting(layout.column(), settings, "layers")


class RADTEX_PT_surface(_Folded, bpy.types.Panel):
    """How the surface is laid out in the texture, and whose light it shows"""

    bl_label = Fold.SURFACE.value

    def draw(self, context: bpy.types.Context | None) -> None:
        layout, settings, found = drawn(self, context)
        assert context is not None  # Blender always gives one
        draw_setting(layout.row(), settings, "atlas_size", expand=True)
        scene, active = cast(bpy.types.Scene, context.scene), context.active_object
        names = found.objects if found is not None else ()
        _draw_uv(layout.column(), settings, owner_of(scene, active, names) or active)
        _draw_parts(layout.column(), settings, found is not None and len(found.objects) > 1)
        if Kind(settings.kind).traits.source:
            column = layout.column()
            draw_search(column, settings, "source", context.scene, "objects")
            if settings.source:
                draw_search(column, settings, "cage", context.scene, "objects")
                if not settings.cage:
                    draw_setting(column, settings, "extrusion")
        _draw_others(layout, settings, Fold.SURFACE)


class RADTEX_PT_sampling(_Folded, bpy.types.Panel):
    """How sharp reflections are, and how clean"""

    bl_label = Fold.SAMPLING.value

    def draw(self, context: bpy.types.Context | None) -> None:
        layout, settings, _ = drawn(self, context)
        _draw_others(layout, settings, Fold.SAMPLING)


class RADTEX_PT_output(_Folded, bpy.types.Panel):
    """Where files go, and which"""

    bl_label = Fold.OUTPUT.value

    def draw(self, context: bpy.types.Context | None) -> None:
        layout, settings, found = drawn(self, context)
        draw_setting(layout, settings, "directory", text=iface_("Folder"))
        draw_setting(layout, settings, "bake_name")
        if settings.bake_name != OBJECT and found is not None and found.made:
            draw_text(layout, iface_("That is {}").format(found.made[0].name), "INFO")
        form, kind = form_of(settings), Kind(settings.kind).traits
        if form.accumulates and kind.accumulates:
            column = headed(layout, iface_("Earlier Bake"), settings, ("accumulate", "refresh"))
            draw_setting(column, settings, "accumulate")
            row = column.row()
            row.enabled = form.refreshes
            draw_setting(row, settings, "refresh")
            if settings.refresh and not form.refreshes:
                told = iface_(
                    "Refresh is for Buckets, and has no effect here: use Bake Again, or Bake Changed"
                )
                draw_text(column, told, "INFO")
            if form.accumulates_parts and (settings.accumulate or settings.refresh):
                draw_setting(column, settings, "where")
        column = headed(layout, iface_("Files"), settings, ("preview", "full_floats"))
        draw_setting(column, settings, "preview")
        if kind.full_floats:
            draw_setting(column, settings, "full_floats")
        draw_setting(layout, settings, "compression")
        draw_setting(layout.column(), settings, "export_targets")
        if context is not None and context.scene is not None:
            _draw_kept_exports(layout.column(align=True), context.scene)
        _draw_others(layout, settings, Fold.OUTPUT)
        draw_button(layout, "radtex.open_folder", "FILE_FOLDER", iface_("Open Folder"), iface_("Folder"))


def _draw_kept_exports(column: Any, scene: bpy.types.Scene) -> None:
    """Draw the exports that are made again after each bake, each with its folder and a cross."""
    rows = rows_of(scene)
    if not rows:
        return
    column.label(text="After Each Bake")
    for number, row in enumerate(rows[:_MOST_KEPT]):
        found, line = kept_export(row), column.row(align=True)
        title = row.name
        if found is not None:
            title = iface_("{} for {}").format(row.name, found.spec.target.traits.title)
        line.label(text=title, icon="EXPORT", translate=False)
        line.operator("radtex.forget_export", text="", icon="X", emboss=False).row = number
        if found is not None:
            draw_text(column, shortened(found.out), "BLANK1")
    if (more := len(rows) - _MOST_KEPT) > 0:
        column.label(text=iface_("and {} more").format(more), icon="BLANK1", translate=False)


def form_of(settings: BakeSettings) -> FormTraits:
    """The form that the settings ask for; buckets while the layout is automatic."""
    chosen = settings.atlas_layout if settings.atlas_layout in tuple(Layout) else Layout.BUCKETS
    return Kind(settings.kind).traits.form or form_in(Layout(chosen))


def _draw_others(layout: Any, settings: BakeSettings, fold: Fold) -> None:
    """Draw the options of a fold that need no more than their row, if they apply."""
    kind, form = Kind(settings.kind).traits, form_of(settings)
    for option in shown_in(fold):
        name = option.setting
        if name in _BY_HAND or not option.applies(kind, form):
            continue
        if name != "content_collection":
            draw_setting(layout, settings, name)
        elif settings.content == "collection":
            draw_search(layout, settings, name, bpy.data, "collections")


def _draw_parts(column: Any, settings: BakeSettings, several: bool) -> None:
    """Draw how surfaces are assigned to atlases; a shared one needs `several` objects."""
    if several and Kind(settings.kind).traits.shared_atlas:
        draw_setting(column, settings, "together")
        if settings.together == "one":
            draw_setting(column, settings, "atlas_name")
    draw_setting(column, settings, "split")
    if settings.split == "material":
        draw_search(column, settings, "part", bpy.data, "materials")
    elif settings.split != "none":
        draw_setting(column, settings, "part")


def _draw_uv(column: Any, settings: BakeSettings, item: bpy.types.Object | None) -> None:
    if item is not None and item.type == "MESH":
        draw_search(column, settings, "uv_layer", item.data, "uv_layers", icon="GROUP_UVS")
    else:
        draw_setting(column, settings, "uv_layer", icon="GROUP_UVS")
    if not settings.uv_layer:
        draw_setting(column, settings, "unwrap")
        if item is not None and item.type == "MESH":
            draw_search(column, settings, "texel_weights", item, "vertex_groups")
        else:
            draw_setting(column, settings, "texel_weights")
        if OPTIONS["backs"].applies(Kind(settings.kind).traits, form_of(settings)):
            draw_setting(column, settings, "backs")
        draw_setting(column, settings, "padding")
