# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is chosen for a bake: the panel's, kept with the scene, and the operator's keyword arguments."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from .choices import COMPRESSIONS, CONTENTS, KINDS, LAYERS, LAYOUTS, LIMITS, TARGETS, UNWRAPS
from .outlook import mark_stale

# Of the mixin below, in the panel's order.
NAMES = (
    "kind",
    "content",
    "content_collection",
    "atlas_layout",
    "uv_layer",
    "unwrap",
    "padding",
    "source",
    "extrusion",
    "texels",
    "bucket",
    "samples",
    "limit",
    "budget",
    "target",
    "seed",
    "layers",
    "directory",
    "full_floats",
    "compression",
    "preview",
    "overwrite",
    "accumulate",
    "refresh",
    "resume",
    "export_targets",
)


def _notice(_: BakeSettings, __: bpy.types.Context) -> None:
    """The panel shows what is no longer so. (Of what scripts change, Blender tells no handler.)"""
    mark_stale()


def _suit_bucket(settings: BakeSettings, _: bpy.types.Context) -> None:
    """In the panel, kind and layout bring the cells that suit them; keyword arguments mean what they say."""
    if isinstance(settings, bpy.types.PropertyGroup):
        from .request import suited_bucket

        settings.bucket = suited_bucket(settings.kind, settings.atlas_layout, settings.limit)
    mark_stale()


_NOTICED: dict[str, Any] = {"update": _notice, "options": {"SKIP_SAVE"}}


class BakeSettings:
    """Not registered itself: the scene's settings and the operator take its properties."""

    if TYPE_CHECKING:  # what an instance holds; Blender makes it from the annotations below
        kind: str
        content: str
        content_collection: str
        atlas_layout: str
        uv_layer: str
        unwrap: str
        padding: int
        source: str
        extrusion: float
        texels: int
        bucket: int
        samples: int
        limit: str
        budget: float
        target: float
        seed: int
        layers: set[str]
        directory: str
        full_floats: bool
        compression: str
        preview: bool
        overwrite: bool
        accumulate: bool
        refresh: bool
        resume: bool
        export_targets: set[str]
    else:
        kind: EnumProperty(
            name="Kind",
            description="Which light each texel keeps",
            items=KINDS,
            default="radiance",
            update=_suit_bucket,
            options={"SKIP_SAVE"},
        )
        content: EnumProperty(
            name="Content",
            description="What the hull shows in its place; the hull itself is never seen",
            items=CONTENTS,
            default="inside",
            **_NOTICED,
        )
        content_collection: StringProperty(
            name="Collection",
            description="The collection whose objects the hull shows",
            **_NOTICED,
        )
        atlas_layout: EnumProperty(
            name="Layout",
            description="How the light is kept",
            items=LAYOUTS,
            default="buckets",
            update=_suit_bucket,
            options={"SKIP_SAVE"},
        )
        uv_layer: StringProperty(
            name="UV Layer",
            description="The UV layer to bake on: inside the unit square and without overlaps, or places on "
            "the surface would show each other's light. Left empty, a copy is unwrapped anew",
            **_NOTICED,
        )
        unwrap: EnumProperty(
            name="Unwrap",
            description="Who lays out the surface where no UV layer is chosen",
            items=UNWRAPS,
            default="xatlas",
            **_NOTICED,
        )
        padding: IntProperty(
            name="Padding",
            description="Texels left free between islands: too few, and light bleeds across seams",
            default=2,
            min=0,
            max=256,
            soft_max=16,
            **_NOTICED,
        )
        source: StringProperty(
            name="From",
            description="A detailed object in the same place, whose light the simple one shall show. The "
            "simple one is not seen while it is baked. Left empty, objects show their own",
            **_NOTICED,
        )
        extrusion: FloatProperty(
            name="Extrusion",
            description="How far from the simple surface, outwards and inwards, the detailed one is looked "
            "for. 0 is 3 % of the object's size",
            default=0.0,
            min=0.0,
            soft_max=1.0,
            step=1,
            precision=3,
            subtype="DISTANCE",
            **_NOTICED,
        )
        texels: IntProperty(
            name="Texels",
            description="Texels along the atlas's longer side: more show finer detail on the surface. Twice "
            "as many cost four times as much",
            default=128,
            min=1,
            max=65536,
            soft_min=16,
            soft_max=1024,
            **_NOTICED,
        )
        bucket: IntProperty(
            name="Cells",
            description="Cells along each side of a texel's bucket: more keep sharper reflections and "
            "highlights. In the Buckets layout, twice as many cost four times as much",
            default=8,
            min=2,
            max=256,
            soft_max=32,
            **_NOTICED,
        )
        samples: IntProperty(
            name="Samples",
            description="Paths traced for each cell: more leave less noise. In the Shared layout each texel "
            "spends about 64 times as many, however many cells it has",
            default=16,
            min=1,
            max=2**24,
            soft_max=1024,
            **_NOTICED,
        )
        limit: EnumProperty(
            name="Limit",
            description="What bounds the size of the Shared layout's textures",
            items=LIMITS,
            default="none",
            update=_suit_bucket,
            options={"SKIP_SAVE"},
        )
        budget: FloatProperty(
            name="MB on the GPU",
            description="What the textures may take, in millions of bytes: less blurs what differs from "
            "texel to texel, first in reflections of near things",
            default=1.0,
            min=0.01,
            max=1e6,
            soft_max=16.0,
            step=10,
            precision=2,
            **_NOTICED,
        )
        target: FloatProperty(
            name="dB",
            description="How near the textures come to the full bake: at 40 dB hardly anybody tells them "
            "apart, at 30 dB reflections of near things are softer",
            default=40.0,
            min=10.0,
            max=60.0,
            step=100,
            precision=0,
            **_NOTICED,
        )
        seed: IntProperty(
            name="Seed",
            description="Another seed gives other noise; the same one gives the same picture",
            default=0,
            min=0,
            **_NOTICED,
        )
        layers: EnumProperty(
            name="Layers",
            description="Parts of the light to keep as atlases of their own, beside the whole: for deferred "
            "rendering, or for a base that needs no view and a rest that does",
            items=LAYERS,
            update=_notice,
            options={"ENUM_FLAG", "SKIP_SAVE"},
            default=set(),
        )
        directory: StringProperty(
            name="Output Folder",
            description="Where the atlas and all that belongs to it are written; // is the .blend "
            "file's folder",
            default="//radtex/",
            subtype="DIR_PATH",
            update=_notice,
            options={"SKIP_SAVE", "PATH_SUPPORTS_BLEND_RELATIVE"},
        )
        full_floats: BoolProperty(
            name="32-bit Floats",
            description="Keep light beyond 65504 and steps that 16 bits are too few for. Hardly ever seen, "
            "and twice as large",
            default=False,
            **_NOTICED,
        )
        compression: EnumProperty(
            name="Compression",
            description="How the images are packed on disk",
            items=COMPRESSIONS,
            default="zip",
            **_NOTICED,
        )
        preview: BoolProperty(
            name="Preview",
            description="Also write a .blend in which the baked copy stands in the object's place. Showing "
            "the bake here and exporting it need that",
            default=True,
            **_NOTICED,
        )
        overwrite: BoolProperty(
            name="Overwrite",
            description="Replace the files of an earlier bake of the same object",
            default=False,
            **_NOTICED,
        )
        accumulate: BoolProperty(
            name="Accumulate",
            description="Fold the samples into the atlas that is there: less noise, and what was baked "
            "before still counts",
            default=False,
            **_NOTICED,
        )
        refresh: BoolProperty(
            name="Refresh",
            description="Bake again only the places whose light has changed since the atlas was baked, as "
            "after a lamp was moved",
            default=False,
            **_NOTICED,
        )
        resume: BoolProperty(
            name="Resume",
            description="Go on with a bake that was cancelled or that failed, from what is kept of it: the "
            "picture is the same as if it had never stopped",
            default=False,
            **_NOTICED,
        )
        export_targets: EnumProperty(
            name="Export",
            description="Folders to make of the bake once it is done: for browsers, engines and viewers",
            items=TARGETS,
            update=_notice,
            options={"ENUM_FLAG", "SKIP_SAVE"},
            default=set(),
        )


class RADTEX_PG_settings(BakeSettings, bpy.types.PropertyGroup):
    """What RadTex's panel shows, kept with the scene"""
