# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that render the current view with the object and with its bake, and show the difference."""

from __future__ import annotations

import logging
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, cast

import bpy
from bpy.props import FloatVectorProperty, IntProperty

from ..jobs import jobs
from ..panel.labels import remark
from ..settings.chosen_bakes import chosen_name
from .bake_lookup import asset_bakes, bake_called, bake_location, originals
from .bake_operator import shown
from .operator_mixins import AsksFirst, MayWait, OfBake

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from bpy.stub_internal.rna_enums import OperatorReturnItems

    from ...formats.sidecar_file import SidecarFile
    from ...report.side_by_side import ComparisonSpec
    from ...report.viewpoint import Viewpoint
    from ...worker.job import Job

    _Bakes = Mapping[bpy.types.Object, SidecarFile | None]

_log = logging.getLogger(__name__)

_MATRIX: dict[str, Any] = {"size": 16, "options": {"SKIP_SAVE", "HIDDEN"}}


class RADTEX_OT_compare(AsksFirst, MayWait, OfBake, bpy.types.Operator):
    """Render what you see by Cycles, with the object and with its bake, and show how they differ"""

    bl_idname = "radtex.compare"
    bl_label = "Compare with Cycles"
    bl_options = {"REGISTER"}  # the undo step is pushed when the images arrive

    if TYPE_CHECKING:  # types of the properties that Blender creates from the annotations below
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

    def draw(self, context: bpy.types.Context | None) -> None:
        """Draw the dialog: without the object and the bake, which the button that was pressed has chosen."""
        layout: Any = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False  # nothing is animated
        layout.prop(self, "pixels")
        layout.prop(self, "samples")

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import RadTexError
        from ...report.shown import frame_of
        from ...report.side_by_side import ComparisonSpec
        from ...scene.scratch import at_frame
        from ..settings.preferences import preferred

        scene, layer = shown(context)
        try:
            self.check_files()
            items = originals(layer, self.object, scene, self.bake)
            bake = bake_called(layer, self.object, scene, self.bake)
            bakes, place = self._bakes(scene, items, bake)
            spec = ComparisonSpec(self.pixels, self.samples, preferred().device)
            with at_frame(scene, frame_of(scene, bakes)):  # the camera may be animated
                eye = self._eye(context)
            if self.at_once:
                self._compare(scene, bakes, eye, spec)
            else:
                submit(scene, bakes, place, eye, spec)
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def _bakes(
        self, scene: bpy.types.Scene, items: list[bpy.types.Object], bake: str
    ) -> tuple[_Bakes, Path | None]:
        """The sidecar of each object's bake, None if its preview is on; and the folder or file searched.

        That folder is None if all previews are on. Raises RadTexError.
        """
        from ...preview.swap import is_on
        from ...report.shown import bakes_of, shown_bake

        if all(map(is_on, items)):
            return dict.fromkeys(items), None
        place = bake_location(scene, bake, items[0].name)
        assets = asset_bakes(scene, [item.name for item in items], bake)
        if len(assets) == len(items) and len(set(assets.values())) == 1:
            place = assets[items[0].name]  # whose objects may also have bakes of their own in the folder
        if place.is_dir():
            named = {item: chosen_name(scene, place, item.name) for item in items}
            bakes = {
                item: None if is_on(item) else shown_bake(place, item.name, called)
                for item, called in named.items()
            }
            return bakes, place
        return bakes_of(items, place), place

    def _compare(self, scene: bpy.types.Scene, bakes: _Bakes, eye: Viewpoint, spec: ComparisonSpec) -> None:
        """Compare in this process and report the result. Raises RadTexError."""
        from ...bake.progress import finished
        from ...report.side_by_side import compare_steps
        from ..jobs.comparison import make_images, show_images

        found = finished(compare_steps(scene, bakes, eye, spec))
        show_images(make_images(found.traced, found.baked))
        names = ", ".join(item.name for item in bakes)
        self.report(
            {"INFO"}, f"{names}: {found.figures.psnr:.1f} dB (at 40 dB hardly anybody sees a difference)"
        )

    def _eye(self, context: bpy.types.Context | None) -> Viewpoint:
        """The view from the operator's matrices, else the 3D view's, else the camera's. Raises InputError."""
        import numpy as np

        from ...core.messages import do
        from ...report.viewpoint import Viewpoint

        region = cast(Any, context).region_data
        if self.properties.is_property_set("window_matrix"):
            view, window = np.array(self.view_matrix), np.array(self.window_matrix)
        elif isinstance(region, bpy.types.RegionView3D) and region.view_perspective != "CAMERA":
            view, window = np.array(region.view_matrix), np.array(region.window_matrix)
        else:
            return Viewpoint.of_camera(*shown(context), do("look at the object in a 3D view"))
        return Viewpoint.of_view(view.reshape(4, 4), window.reshape(4, 4))


class RADTEX_OT_show_comparison(bpy.types.Operator):
    """Show both pictures and their difference as images, in a window of their own unless an editor is free"""

    bl_idname = "radtex.show_comparison"
    bl_label = "Show Pictures"
    bl_options = {"INTERNAL"}  # loading images again pushes its own undo step

    if TYPE_CHECKING:
        number: int
    else:
        number: IntProperty(
            name="Number", description="The job's number", default=0, min=0, options={"SKIP_SAVE"}
        )

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        from ...core.errors import RadTexError
        from ..jobs.comparison import load_images, open_window, show_images

        facts = next((job.facts for job in jobs.snapshot() if job.number == self.number), {})
        if "traced" not in facts:
            self.report({"ERROR"}, f"Job {self.number} has no pictures: compare again")
            return {"CANCELLED"}
        try:
            images = load_images(facts)
        except RadTexError as error:
            self.report({"ERROR"}, remark(error))
            return {"CANCELLED"}
        if not show_images(images) and not bpy.app.background:
            open_window(images)
        return {"FINISHED"}


def submit(
    scene: bpy.types.Scene, bakes: _Bakes, place: Path | None, eye: Viewpoint, spec: ComparisonSpec
) -> None:
    """Queue a comparison with the bakes in `place` as a background job.

    Raises BakeError if the scene cannot be saved.
    """
    from ...worker.handover import hand_over
    from ...worker.orders import order_comparison
    from ..settings.preferences import preferred

    handover = hand_over(scene, preferred().cache)
    results = TemporaryDirectory(prefix="radtex-comparison-", ignore_cleanup_errors=True)
    names = [item.name for item in bakes]
    sidecars = [None if bake is None else bake.path for bake in bakes.values()]
    order = order_comparison(handover, names, place, eye, spec, Path(results.name), sidecars)
    jobs.add([order], jobs.Completion(_arrival(scene), results))


def _arrival(scene: bpy.types.Scene) -> Callable[[Job], None]:
    """A callback that loads a comparison's pictures, if the file of `scene` is still open."""
    number = scene.session_uid

    def arrived(job: Job) -> None:
        from ...core.errors import RadTexError
        from ..jobs.comparison import load_images, show_images

        if all(other.session_uid != number for other in bpy.data.scenes):
            return  # the button can still load the pictures
        try:
            show_images(load_images(job.facts))
        except RadTexError as error:
            _log.warning("%s", error)

    return arrived
