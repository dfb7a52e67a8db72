# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The current view path traced and baked, side by side."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

import bpy
from bpy.props import FloatVectorProperty, IntProperty

from .finding import originals, sidecar_of
from .of_bake import AsksFirst, OfBake
from .operator import shown
from .words import remark

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems

    from ..report.eye import Eye

_MATRIX: dict[str, Any] = {"size": 16, "options": {"SKIP_SAVE", "HIDDEN"}}


class RADTEX_OT_compare(AsksFirst, OfBake, bpy.types.Operator):
    """Render what you see by Cycles, with the object and with its bake, and show how they differ"""

    bl_idname = "radtex.compare"
    bl_label = "Compare with Cycles"
    bl_options = {"REGISTER", "UNDO"}

    if TYPE_CHECKING:  # what an instance holds; Blender makes it from the annotations below
        pixels: int
        samples: int
        view_matrix: tuple[float, ...]
        window_matrix: tuple[float, ...]
    else:
        pixels: IntProperty(
            name="Pixels",
            description="Pixels along the pictures' longer side: more take longer",
            default=512,
            min=16,
            max=8192,
            soft_max=2048,
        )
        samples: IntProperty(
            name="Samples",
            description="Paths traced for each pixel. Pictures are denoised; too few still leave blotches "
            "that are none of the bake's",
            default=64,
            min=1,
            max=2**24,
            soft_max=1024,
        )
        view_matrix: FloatVectorProperty(
            name="View Matrix",
            description="From world space to the viewer's, row by row. Left out, the 3D view's, or the "
            "camera's",
            **_MATRIX,
        )
        window_matrix: FloatVectorProperty(
            name="Window Matrix",
            description="The projection that belongs to it, row by row",
            **_MATRIX,
        )

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ..bake.progress import finished
        from ..core.errors import RadTexError
        from ..preview.swap import is_on
        from ..report.side_by_side import ComparisonSpec, compare_steps
        from .comparison import make_images, show_images
        from .preferences import preferred

        scene, layer = shown(context)
        try:
            items = originals(layer, self.object)
            bakes = {item: None if is_on(item) else sidecar_of(scene, item, self.bake) for item in items}
            spec = ComparisonSpec(self.pixels, self.samples, preferred().device)
            found = finished(compare_steps(scene, bakes, self._eye(context), spec))
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        show_images(make_images(found))
        names = ", ".join(item.name for item in items)
        self.report(
            {"INFO"}, f"{names}: {found.figures.psnr:.1f} dB (at 40 dB hardly anybody sees a difference)"
        )
        return {"FINISHED"}

    def _eye(self, context: bpy.types.Context | None) -> Eye:
        """The view that was named, or the 3D view's, or the camera's. Raises InputError."""
        import numpy as np

        from ..report.eye import Eye

        region = cast(Any, context).region_data
        if self.properties.is_property_set("window_matrix"):
            view, window = np.array(self.view_matrix), np.array(self.window_matrix)
        elif isinstance(region, bpy.types.RegionView3D) and region.view_perspective != "CAMERA":
            view, window = np.array(region.view_matrix), np.array(region.window_matrix)
        else:
            return Eye.of_camera(*shown(context))
        return Eye.of_view(view.reshape(4, 4), window.reshape(4, 4))
