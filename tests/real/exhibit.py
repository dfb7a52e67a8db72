# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One small real bake of the demo's head, the same cameras for every program, and what each must show.

    python -m tests.real.exhibit plain FOLDER        bakes it; or: layered FOLDER

The head is turned, moved and stretched, so that a program which forgets the object's matrix shows it, and
its gold is worn, so that it scatters light too. It stands alone: behind it everything is black.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cache, cached_property
from math import radians, tan
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import pytest
from mathutils import Euler, Matrix, Vector

from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.fragments import Fragments
from radtex_addon.core.sampler import Filter, sample
from radtex_addon.formats.containers.exr import read_atlas
from radtex_addon.forms.layered.files.layered_files import read_layered
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas, look_at, sample_layered, shading_normal
from radtex_addon.job import bake_object
from radtex_addon.report.finished_bake import Finished, find_bake, read_bake
from radtex_addon.report.gbuffer import BakedSurface, CameraRays, GBuffer
from radtex_addon.report.metrics import Mask, Picture, psnr
from radtex_addon.scene.demo import OBJECT, build_demo_scene
from radtex_addon.scene.preview_file import baked_copy
from radtex_addon.settings.choices import Backs
from radtex_addon.settings.spec import BakeSpec, Layout
from tests.blender import surroundings
from tests.lookups import squared_steps

ROOT = Path(__file__).resolve().parents[2]
FIGURES = os.environ.get("RADTEX_FIGURES")  # where pictures for the docs are kept: of a finer head
STEADY = 0.16  # RADTEX_STEADY of what is exported
SUBDIVISIONS = 2 if FIGURES else 1
PLACE = Matrix.LocRotScale((0.1, -0.05, 0.15), Euler((0.15, -0.1, 0.4)), (1.0, 1.1, 0.95))


class Form(StrEnum):
    """How the head is baked."""

    PLAIN = "plain"
    LAYERED = "layered"

    @property
    def spec(self) -> BakeSpec:
        if self is Form.LAYERED:
            # With the backs that no camera sees, so that blocks are judged by light as coarse as ever:
            return BakeSpec(texels=64, samples=2, layout=Layout.LAYERED, backs=Backs.ALL)
        return BakeSpec(texels=64, bucket=8, samples=4)


@dataclass(frozen=True)
class Camera:
    """Looks from `place` at `target`, both in Blender's world, z up; `fovy` degrees; `pixels` a side."""

    name: str
    place: tuple[float, float, float]
    target: tuple[float, float, float] = (0.1, -0.05, 0.15)
    fovy: float = 40.0
    pixels: int = 256

    @property
    def matrix(self) -> Matrix:
        """The camera's place in the world (4, 4), as Blender has it: it looks along its own −z, y up."""
        away = Vector(self.place) - Vector(self.target)
        matrix = away.to_track_quat("Z", "Y").to_matrix().to_4x4()
        matrix.translation = Vector(self.place)
        return matrix

    @property
    def rays(self) -> CameraRays:
        """One ray through the middle of each pixel, rows from the top."""
        matrix = np.array(self.matrix)
        return CameraRays.of_camera(
            matrix[:3, 3], matrix[:3, :3], tan(radians(self.fovy) / 2), self.pixels, 1
        )


CAMERAS = (
    Camera("front", (1.6, -3.4, 0.9)),
    Camera("left", (-3.1, -2.2, 0.4)),
    Camera("behind", (0.9, 3.6, 1.9)),
)


@dataclass(frozen=True, eq=False)
class Bake:
    """A finished bake in `folder`: `sidecar`, images, and `preview`, the .blend with the baked copy."""

    folder: Path

    @cached_property
    def sidecar(self) -> Path:
        return find_bake(self.folder, None).path

    @cached_property
    def finished(self) -> Finished:
        return read_bake(self.sidecar)

    @property
    def preview(self) -> Path:
        return self.finished.preview

    @cached_property
    def surface(self) -> BakedSurface:
        """The baked copy in the world, without Blender's data."""
        facts = self.finished.sidecar
        with baked_copy(self.preview, facts.surfaces, facts.uv_map) as (_, copy):
            return BakedSurface(cast(bpy.types.Mesh, copy.data), np.array(PLACE), facts.uv_map)

    @cached_property
    def buffer(self) -> Callable[[Camera], GBuffer]:
        """What a shader knows at each pixel's middle."""

        @cache
        def seen(camera: Camera) -> GBuffer:
            return self.surface.gbuffer(camera.rays, np.full(camera.pixels**2, np.inf))

        return seen

    def picture(
        self, camera: Camera, kind: Filter = Filter.QUADRILINEAR, *, steady: float = STEADY
    ) -> Picture:
        """Linear light (H, W, 3), rows from the top, black beside the head; `kind` is for plain bakes.

        Layered ones are as `steady` as what engines show.
        """
        buffer = self.buffer(camera)
        if self.finished.form.traits.by_paths:
            return steady_picture(self._layers, buffer, buffer.fragments, steady)
        pixels, facts = self._atlas
        layout = AtlasLayout(facts.width, facts.height, facts.bucket)
        seen = sample(pixels, layout, buffer.uv[buffer.hit], buffer.incidence[buffer.hit], kind)
        return buffer.resolve(buffer.spread(seen[:, :3]))

    @cached_property
    def _atlas(self) -> Any:
        pixels, facts = read_atlas(self.finished.images[0])
        return pixels.astype(np.float32), facts

    @cached_property
    def _layers(self) -> LayeredAtlas:
        return read_layered(self.sidecar)[0]

    def inside(self, camera: Camera) -> Mask:
        """Pixels whose middle shows the head, (H, W)."""
        return self.buffer(camera).inside

    def eroded(self, camera: Camera) -> Mask:
        """The same without its outermost pixels, where programs may disagree about the edge."""
        return self.buffer(camera).eroded


def steady_picture(atlas: LayeredAtlas, buffer: GBuffer, at: Fragments, steady: float = STEADY) -> Picture:
    """What the reference sampler sees at fragments, which are a G-buffer's, a ray for each pixel: (H, W, 3).

    Lobes widen as normals do within pixels.
    """
    normal = buffer.spread(shading_normal(look_at(atlas, at), at))
    spread = steady * squared_steps(normal, buffer.hit, buffer.pixels)[buffer.hit]
    return buffer.resolve(buffer.spread(sample_layered(atlas, replace(at, spread=spread.astype(np.float32)))))


@dataclass(frozen=True, eq=False)
class Exhibit:
    """The bakes, made when they are first asked for; and from where they are looked at."""

    folder: Path
    cameras: tuple[Camera, ...] = CAMERAS

    @cached_property
    def plain(self) -> Bake:
        return self._baked(Form.PLAIN)

    @cached_property
    def layered(self) -> Bake:
        """Of two materials."""
        return self._baked(Form.LAYERED)

    def _baked(self, form: Form) -> Bake:
        """Bake in a process of its own: the file that is open here stays as it is."""
        folder = self.folder / form
        command = [sys.executable, "-m", "tests.real.exhibit", form, str(folder)]
        ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=1200)
        assert ended.returncode == 0, ended.stderr
        return Bake(folder)


def decibels(picture: Picture, reference: Picture, mask: Mask) -> float:
    """PSNR of display values (clipped, gamma 2.2) of two linear pictures, inside the mask."""
    return psnr(picture, reference, mask)


def small_unless_kept() -> None:
    """Let layered bakes of this process take small pictures of the surroundings, unless ours are for docs."""
    if not FIGURES:
        surroundings.make_small(pytest.MonkeyPatch())


def _paint_upper_half(head: Any) -> None:
    """Give the faces above the middle a second material: blue paint, duller than the gold."""
    paint = head.active_material.copy()
    shader = next(node for node in paint.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    for name, value in (("Base Color", (0.05, 0.1, 0.5, 1.0)), ("Metallic", 0.0), ("Roughness", 0.4)):
        for link in shader.inputs[name].links:
            paint.node_tree.links.remove(link)
        shader.inputs[name].default_value = value
    head.data.materials.append(paint)
    for face in head.data.polygons:
        face.material_index = int(face.center.z > 0)


def head_stage() -> tuple[bpy.types.Scene, Any]:
    """Open the scene of the head; both, the head at its place."""
    scene = build_demo_scene()
    head: Any = bpy.data.objects[OBJECT]
    head.matrix_world = PLACE
    head.modifiers[0].levels = head.modifiers[0].render_levels = SUBDIVISIONS
    return scene, head


def stage(form: Form) -> bpy.types.Scene:
    """Open the head's scene, to be baked in a form."""
    scene, head = head_stage()
    gold = next(node for node in head.active_material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    gold.inputs["Metallic"].default_value = 0.6
    if form is Form.LAYERED:
        _paint_upper_half(head)
    return scene


def main(form: Form, folder: Path) -> None:
    """Bake the head in one form, with its preview."""
    small_unless_kept()
    bake_object(stage(form), OBJECT, form.spec, folder, preview=Filter.QUADRILINEAR, overwrite=True)


if __name__ == "__main__":
    main(Form(sys.argv[1]), Path(sys.argv[2]))
