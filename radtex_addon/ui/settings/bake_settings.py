# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake's settings: stored with the scene for the panel, and keyword arguments of the bake operator."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from ...bake.kinds import DEFAULT_KIND, Kind, Layout, form_in
from ..panel.panel_state import mark_stale
from . import output_settings, surfaces
from .menu_items import ATLAS_SIZES, CONTENTS, KINDS, LAYOUTS_OR_AUTOMATIC, UNWRAPS, VARIANTS, VIEWS
from .update_callbacks import NOTICED

# Property names of the mixin below, in the panel's order.
NAMES = (
    "kind",
    "view",
    "content",
    "content_collection",
    "ao_distance",
    "alone",
    "atlas_layout",
    *surfaces.NAMES,
    "uv_layer",
    "unwrap",
    "padding",
    "source",
    "extrusion",
    "cage",
    "variants",
    "frames",
    "atlas_size",
    "texels",
    "density",
    "bucket",
    "samples",
    "seed",
    "denoise",
    *output_settings.NAMES,
)


_OWN_CELLS = "radtex_cells"  # custom property: the user's bucket size for each `_sort_of_cells`


def _suit_bucket(settings: BakeSettings, _: bpy.types.Context) -> None:
    """Update callback of kind and layout: restore the bucket size last used with them, or the default.

    Only for the panel: an operator's keyword arguments are not adjusted.
    """
    if isinstance(settings, bpy.types.PropertyGroup):
        from .suited_cells import suited_bucket

        own = cast(Any, settings).get(_OWN_CELLS, {}).get(_sort_of_cells(settings))
        settings.bucket = own or suited_bucket(settings.kind, settings.atlas_layout)
        mark_stale()


def _keep_bucket(settings: BakeSettings, _: bpy.types.Context) -> None:
    """Update callback: remember the bucket size for the current `_sort_of_cells`."""
    if isinstance(settings, bpy.types.PropertyGroup):
        known = dict(cast(Any, settings).get(_OWN_CELLS, {}))
        cast(Any, settings)[_OWN_CELLS] = known | {_sort_of_cells(settings): settings.bucket}
        mark_stale()


def _sort_of_cells(settings: BakeSettings) -> str:
    """Key of the remembered bucket size; for `ao`, which has no buckets, that is its grid of rays."""
    kind = Kind(settings.kind).traits
    if kind.views or kind.ao_distance:
        return settings.kind
    if kind.form is None and settings.atlas_layout in tuple(Layout):
        return form_in(Layout(settings.atlas_layout)).name
    return settings.atlas_layout if kind.looks_at_surface else Layout.BUCKETS.value


class BakeSettings(surfaces.SurfaceSettings, output_settings.OutputSettings):
    """Mixin with all bake properties, for the scene's settings and the operator; not registered itself."""

    if TYPE_CHECKING:  # types of the properties that Blender creates from the annotations below
        kind: str
        view: str
        content: str
        content_collection: str
        ao_distance: float
        alone: bool
        atlas_layout: str
        uv_layer: str
        unwrap: str
        padding: int
        source: str
        extrusion: float
        cage: str
        variants: str
        frames: str
        atlas_size: str
        texels: int
        density: float
        bucket: int
        samples: int
        seed: int
        denoise: bool
    else:
        kind: EnumProperty(
            name="Bake Type",
            description="What is recorded: how the object looks, the light that reaches it, or what blocks "
            "light",
            items=KINDS,
            default=DEFAULT_KIND.value,
            update=_suit_bucket,
            options={"SKIP_SAVE"},
        )
        view: EnumProperty(
            name="View",
            description="From where the object will be looked at: fixes how its gloss comes out when lamps "
            "move",
            items=VIEWS,
            default="normal",
            **NOTICED,
        )
        content: EnumProperty(
            name="Content",
            description="What the hull shows in its place; the hull itself is never seen",
            items=CONTENTS,
            default="inside",
            **NOTICED,
        )
        content_collection: StringProperty(
            name="Collection",
            description="The collection whose objects the hull shows",
            **NOTICED,
        )
        ao_distance: FloatProperty(
            name="Distance",
            description="What is farther away than this counts as open. With 0 there is no limit",
            default=0.0,
            min=0.0,
            max=1e18,
            soft_max=10.0,
            step=1,
            precision=3,
            subtype="DISTANCE",
            **NOTICED,
        )
        alone: BoolProperty(
            name="Alone",
            description="Bake each object as if it stood alone: no other object is mirrored in it or shades "
            "it. For objects that will stand elsewhere; lamps and the world stay",
            default=False,
            **NOTICED,
        )
        atlas_layout: EnumProperty(
            name="Storage",
            description="Decides how sharp reflections are, and how large the files",
            items=LAYOUTS_OR_AUTOMATIC,
            default="auto",
            update=_suit_bucket,
            options={"SKIP_SAVE"},
        )
        uv_layer: StringProperty(
            name="UV Map",
            description="The UV map to bake on: inside the unit square and without overlaps, or places on "
            "the surface would show each other's light. Left empty, Unwrap decides",
            **NOTICED,
        )
        unwrap: EnumProperty(
            name="Unwrap",
            description="How UVs are made where no map is chosen. Your mesh stays as it is",
            items=UNWRAPS,
            default="auto",
            **NOTICED,
        )
        padding: IntProperty(
            name="Padding",
            description="Texels left free between UV islands: too few, and light bleeds across seams",
            default=2,
            min=0,
            max=256,
            soft_max=16,
            **NOTICED,
        )
        source: StringProperty(
            name="Detailed Object",
            description="A high-poly object in the same place, whose light the low-poly one shall show. The "
            "low-poly one is not seen while it is baked. Left empty, objects show their own light",
            **NOTICED,
        )
        extrusion: FloatProperty(
            name="Extrusion",
            description="How far from the simple surface, outwards and inwards, the detailed one is looked "
            "for. 0 is 3 % of the object's size",
            default=0.0,
            min=0.0,
            max=1e18,
            soft_max=1.0,
            step=1,
            precision=3,
            subtype="DISTANCE",
            **NOTICED,
        )
        cage: StringProperty(
            name="Cage",
            description="A copy of the simple object whose vertices were moved out: the detailed one is "
            "looked for from there on, instead of along the normals. It may be hidden",
            **NOTICED,
        )
        variants: EnumProperty(
            name="Variations",
            description="Several bakes of each object at once",
            items=VARIANTS,
            default="none",
            **NOTICED,
        )
        frames: StringProperty(
            name="Frames",
            description="The frames to bake, such as 1,5,10-20",
            default="1",
            **NOTICED,
        )
        atlas_size: EnumProperty(
            name="Size By",
            description="What the size of the texture follows from",
            items=ATLAS_SIZES,
            default="texels",
            **NOTICED,
        )
        texels: IntProperty(
            name="Resolution",
            description="Texels along the texture's longer side: more show finer detail on the surface. "
            "Twice as many take four times as long",
            default=128,
            min=1,
            max=65536,
            soft_min=16,
            soft_max=1024,
            **NOTICED,
        )
        density: FloatProperty(
            name="Density",
            description="Texels per metre of surface: objects of every size come out alike, and their "
            "textures are as large as that needs, up to 4096 texels a side. The scene's Unit Scale "
            "says what a metre is",
            default=64.0,
            min=1e-3,
            max=1e12,
            soft_min=1.0,
            soft_max=4096.0,
            **NOTICED,
        )
        bucket: IntProperty(
            name="Angular Detail",
            description="Directions that each texel tells apart, along each side of its bucket: more give "
            "sharper reflections and highlights, and twice as many take four times as long. Layered chooses "
            "it itself; a number other than 14 makes Automatic choose Buckets",
            default=14,  # the default of the automatic layout (`job.layout_choice`)
            min=2,
            max=256,
            soft_max=32,
            update=_keep_bucket,
            options={"SKIP_SAVE"},
        )
        samples: IntProperty(
            name="Samples",
            description="Paths that Cycles traces for each direction of a texel: more leave less noise, and "
            "take longer. Layered traces about 64 times as many for each texel",
            default=16,
            min=1,
            max=2**24,
            soft_max=1024,
            **NOTICED,
        )
        seed: IntProperty(
            name="Seed",
            description="Another seed gives other noise; the same one gives the same picture again",
            default=0,
            min=0,
            **NOTICED,
        )
        denoise: BoolProperty(
            name="Denoise",
            description="Remove the grain by OpenImageDenoise. Turn it off for bakes to which samples "
            "are added later",
            default=True,
            **NOTICED,
        )


class RADTEX_PG_settings(BakeSettings, bpy.types.PropertyGroup):
    """What RadTex's panel shows, kept with the scene"""
