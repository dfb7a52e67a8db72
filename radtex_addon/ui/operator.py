# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bake as an operator: what a click does, a script does too."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems

KINDS = (
    ("radiance", "Radiance", "The light that leaves the surface, as a viewer in each direction sees it"),
    ("incident", "Incident", "The light that arrives at the surface from each direction"),
    ("reflection", "Reflection", "The light that arrives from where a mirror would send each view"),
)

LAYOUTS = (
    ("buckets", "Buckets", "Every texel keeps a picture of its own of the light in all directions"),
    (
        "shared",
        "Shared",
        "What all texels see in common is kept once, and sharp. For glossy things; radiance only",
    ),
)


class RADTEX_OT_bake(bpy.types.Operator):
    """Bake the active object's light in every direction into a texture atlas, path traced by Cycles"""

    bl_idname = "radtex.bake"
    bl_label = "Bake Radiance Texture"
    bl_options = {"REGISTER"}

    if TYPE_CHECKING:  # what an instance holds; Blender makes it from the annotations below
        kind: str
        atlas_layout: str
        texels: int
        bucket: int
        samples: int
        directory: str
    else:
        kind: EnumProperty(
            name="Kind",
            description="Which light each texel keeps",
            items=KINDS,
            default="radiance",
        )
        atlas_layout: EnumProperty(
            name="Layout",
            description="How the light is kept",
            items=LAYOUTS,
            default="buckets",
        )
        texels: IntProperty(
            name="Texels",
            description="Texels along the atlas's longer side",
            default=128,
            min=1,
            soft_max=1024,
        )
        bucket: IntProperty(
            name="Bucket",
            description="Cells along each side of a texel's bucket: more keep sharper reflections. "
            "The shared layout has 16 unless this is set",
            default=8,
            min=2,
            soft_max=64,
        )
        samples: IntProperty(
            name="Samples",
            description="Paths traced for each cell: more leave less noise. In the shared layout each texel "
            "spends about 64 times as many, however many cells it has",
            default=16,
            min=1,
            soft_max=1024,
        )
        directory: StringProperty(
            name="Output Folder",
            description="Where the atlas and its sidecar are written; // is the .blend file's folder",
            default="//",
            subtype="DIR_PATH",
        )

    @classmethod
    def poll(cls, context: bpy.types.Context | None) -> bool:
        item = context.active_object if context is not None else None
        if item is None or item.type != "MESH":
            cls.poll_message_set("Make a mesh object active to bake its radiance texture")
            return False
        return True

    def invoke(
        self, context: bpy.types.Context | None, event: bpy.types.Event | None
    ) -> set[OperatorReturnItems]:
        assert context is not None  # Blender always gives one
        assert context.window_manager is not None  # there is one wherever a click comes from
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        # Imported here, so that OpenEXR loads with the first bake and not with Blender.
        from ..bake.spec import BakeSpec, Kind, Layout
        from ..core.errors import RadTexError
        from ..job import bake_object

        assert context is not None  # Blender always gives one
        assert context.scene is not None  # nor is it without a scene
        assert context.active_object is not None  # poll's promise
        name = context.active_object.name
        try:
            layout = Layout(self.atlas_layout)
            chosen = self.properties.is_property_set("bucket")
            spec = BakeSpec(
                kind=Kind(self.kind),
                layout=layout,
                texels=self.texels,
                bucket=self.bucket if chosen else layout.cells,
                samples=self.samples,
            )
            bake_object(context.scene, name, spec, Path(bpy.path.abspath(self.directory)))
        except RadTexError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"Baked {name}")
        return {"FINISHED"}
