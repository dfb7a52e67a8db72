# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's capture, to the letter: at every texel a fisheye-equisolid camera of 180 degrees.

It looks along the normal, outwards only. It is slow; the portal capture is tested against it. The camera's
disc is resampled to the square, uniformly in B. Cycles hides lamps from camera rays, so the camera is
in a tiny box whose walls mirror each camera ray straight back, which makes it a glossy ray; for glossy rays
the opposite wall is a portal, which turns the ray round again and lets it out.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
from mathutils import Matrix

from ..bake.plan import MIN_IMAGE_SIDE, CapturePlan, Tile
from ..core.arrays import Floats, Ints
from ..core.errors import InputError
from ..core.hemisphere import square_to_disc
from ..core.messages import Setting, do
from ..formats.disk.path_checks import render_path
from ..scene.nodes import open_material
from ..settings.kinds import Kind, Rays
from .building_blocks import box, mirror, render_image
from .capture_settings import allow_more_bounces, apply_capture_settings

_SENSOR = 36.0  # mm; any size works
_FINEST = 64  # disc pixels along a cell's side, at most; up to that, each pixel takes one sample
_RIM_STEPS = 32  # steps of the integral over a pixel on the disc's rim


class PanoramicCapture:
    """Captures `incident` and `reflection` in a scratch scene, texel by texel."""

    def __init__(
        self, scene: bpy.types.Scene, plan: CapturePlan, kind: Kind, samples: int, seed: int, folder: Path
    ) -> None:
        """Arguments as for `PortalCapture`.

        A cell's `samples` are spread over its disc pixels, at least one each. Raises InputError for
        `radiance`, which a camera on the surface cannot see.
        """
        if kind.traits.rays is Rays.INWARDS:
            raise InputError(
                "the panoramic capture looks outwards only",
                do("bake radiance by portal", Setting.CAPTURE, value="portal"),
            )
        self._scene, self._plan, self._seed = scene, plan, seed
        self._file = folder / "texel.exr"
        finest = min(round(sqrt(samples * 4 / pi)), _FINEST)
        coarsest = -(-MIN_IMAGE_SIDE // plan.layout.bucket)
        self._side = plan.layout.bucket * max(finest, coarsest)
        per_pixel = samples / (pi / 4 * (self._side / plan.layout.bucket) ** 2)
        apply_capture_settings(scene, max(1, round(per_pixel)), seed)
        scene.render.film_transparent = False
        scene.render.resolution_x = scene.render.resolution_y = self._side
        scene.render.filepath = render_path(self._file)
        allow_more_bounces(scene, transparent=1, glossy=1)
        self._offset = float(plan.offset.min())
        self._camera = _camera(scene, self._offset)
        self._box = _box(scene, self._offset / 4)
        scene.camera = self._camera
        turned = kind.traits.rays is Rays.MIRRORED
        self._resampling = _resampling(plan.layout.bucket, self._side, turned)

    def render(self, tile: Tile) -> Floats:
        """Cells of the tile's texels: see `Capture.render`."""
        first, n = tile.first_row * self._plan.columns, self._plan.layout.bucket
        cells = np.empty((len(self._plan.texels_of(tile)), n, n, 4), dtype=np.float32)
        for k in range(len(cells)):
            cells[k] = self._render_texel(first + k)
        return cells

    def _render_texel(self, k: int) -> Floats:
        plan = self._plan
        normal, bitangent, tangent, facet, position = (
            field.reshape(-1, 3)[k]
            for field in (plan.normal, plan.bitangent, plan.tangent, plan.facet, plan.position)
        )
        # A camera looks along -z; with y along Bt, its x is -T if the frame is right-handed.
        x = np.cross(bitangent, -normal)
        place = position + facet * self._offset
        matrix = np.eye(4)
        matrix[:3] = np.stack([x, bitangent, -normal, place], axis=1)
        self._camera.matrix_world = Matrix(matrix.tolist())
        self._box.location = place.tolist()
        cast(Any, self._scene).cycles.seed = (self._seed + int(plan.texel[k]) * 7919) % 2**31
        disc = render_image(self._scene, self._file)
        if x @ tangent < 0:
            disc = disc[:, ::-1]
        n = plan.layout.bucket
        return self._resampling.cells(disc.reshape(-1, 4)).reshape(n, n, 4)


def _camera(scene: bpy.types.Scene, offset: float) -> bpy.types.Object:
    data = bpy.data.cameras.new("RadTex camera")
    data.type, data.panorama_type = "PANO", "FISHEYE_EQUISOLID"
    data.fisheye_fov = pi
    data.sensor_fit = "HORIZONTAL"
    data.sensor_width = data.sensor_height = _SENSOR
    data.fisheye_lens = _SENSOR / (2 * sqrt(2))  # |A| = sqrt(2) sin(theta / 2): the disc touches the edges
    data.clip_start, data.clip_end = offset / 100, 1e9  # a ray starts at clip_start
    camera = bpy.data.objects.new("RadTex camera", data)
    scene.collection.objects.link(camera)
    return camera


def _box(scene: bpy.types.Scene, half: float) -> bpy.types.Object:
    """The box around the camera: a mirror facing each camera ray, and a portal out for glossy rays."""
    material, build = open_material("RadTex box")
    back = build.geometry("Incoming")
    reflect = mirror(build)
    build.feed(reflect.node.inputs["Normal"], back)
    portal = build.node("ShaderNodeBsdfRayPortal")
    centre = build.node("ShaderNodeObjectInfo").outputs["Location"]
    build.feed(portal.inputs["Position"], build.vector("MULTIPLY_ADD", back, (3 * half,) * 3, centre))
    build.feed(portal.inputs["Direction"], back)
    path = build.node("ShaderNodeLightPath")
    ours = build.math("LESS_THAN", path.outputs["Ray Length"], 4 * half)
    clear = build.node("ShaderNodeBsdfTransparent").outputs[0]
    glossy = build.node("ShaderNodeMixShader", ours, clear, portal.outputs[0])
    either = build.node("ShaderNodeMixShader", path.outputs["Is Camera Ray"], glossy.outputs[0], reflect)
    build.node("ShaderNodeOutputMaterial", either.outputs[0])
    return box(scene, "RadTex box", half, material, {"camera", "glossy"})


@dataclass(frozen=True)
class _Resampling:
    """The disc pixels of each cell and their weights: entries sorted by cell, `first` of each cell."""

    pixel: Ints
    weight: Floats
    first: Ints

    def cells(self, disc: Floats) -> Floats:
        """Means over the cells (n*n, 4) of a disc image's pixels (side*side, 4)."""
        means: Floats = np.add.reduceat(disc[self.pixel] * self.weight[:, None], self.first, axis=0)
        means[:, 3] = 1  # Cycles calls even the outside of the disc opaque
        return means


def _resampling(bucket: int, side: int, turned: bool) -> _Resampling:
    """The weights for means uniform in B, by counting sub-samples on a fine grid in every cell.

    `turned` is for the mirror direction, which is half a turn about the normal away.
    """
    fine = 8 * -(-side // bucket)  # sub-samples per cell's side
    b = (2 * np.arange(bucket * fine) + 1 - bucket * fine) / (bucket * fine)
    entries, counts = [], []
    for q in range(bucket):  # a row of cells at a time, or the grid would take gigabytes
        disc = square_to_disc(np.stack(np.meshgrid(b, b[q * fine : (q + 1) * fine]), axis=-1))
        if turned:
            disc = -disc
        column, row = np.moveaxis(np.clip((disc + 1) / 2 * side, 0, side - 1).astype(np.intp), -1, 0)
        cell = q * bucket + np.arange(bucket * fine) // fine
        entry, count = np.unique((cell * side + row) * side + column, return_counts=True)
        entries.append(entry)
        counts.append(count)
    entry, count = np.concatenate(entries), np.concatenate(counts)
    first = np.searchsorted(entry, np.arange(bucket * bucket) * side * side)
    pixel = entry % (side * side)
    inside = _share_inside_disc(side)[pixel]
    weight = np.divide(count, inside, out=np.zeros(len(entry)), where=inside > 1e-3)
    weight /= np.repeat(np.add.reduceat(weight * inside, first), np.diff(first, append=len(entry)))
    return _Resampling(pixel, weight, first)


def _share_inside_disc(side: int) -> Floats:
    """The share of each pixel that lies in the unit disc, (side*side): pixels on the rim are partly black."""
    edge = (2 * np.arange(side + 1) - side) / side
    low, high = edge[:-1, None, None], edge[1:, None, None]
    steps = side * _RIM_STEPS
    x = ((2 * np.arange(steps) + 1 - steps) / steps).reshape(side, _RIM_STEPS)
    reach = np.sqrt(1 - x**2)  # the disc spans -reach … reach at x
    height = np.clip(np.minimum(high, reach) - np.maximum(low, -reach), 0, None)
    share: Floats = height.mean(axis=2).ravel() * side / 2
    return share
