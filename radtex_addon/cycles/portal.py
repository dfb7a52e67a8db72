# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The fast capture: one orthographic camera looks at a plane of Ray Portals, and a tile is one render call.

The plane's material turns its own position into texel and cell, looks the texel's frame up in float images,
and sends the camera's ray to P and I. To Cycles it still is a camera ray. Light kinds must see lamps, which
Cycles hides from camera rays: there the camera looks at a sharp mirror, and portals above it catch the glossy
rays.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from pathlib import Path

import bpy
import numpy as np

from ..bake.plan import MIN_IMAGE_SIDE, CapturePlan, Tile
from ..bake.spec import Kind
from ..core.arrays import Floats
from ..core.errors import BakeError
from ..core.hemisphere import cell_centres
from ..core.ray_offset import GRAZING, ray_offset
from ..scene.nodes import NodeBuilder, Socket, open_material
from .apparatus import (
    Extent,
    above_everything,
    camera_above,
    float_image,
    mirror_material,
    plane,
    render_layers,
)
from .settings import allow_more_bounces, apply_capture_settings, keep_passes, look_at_centres


@dataclass(frozen=True, eq=False)
class Aim:
    """Rays aimed at one known point of every cell, and the passes that are kept of them.

    `shift` (K, 2): where in its cells each of the plan's texels aims, from 0 to 1 along both sides. `passes`
    are attributes of a view layer. With light kinds, rays whose passes are kept do not see lamps.
    """

    shift: Floats
    passes: tuple[str, ...] = ()

    def square(self, bucket: int) -> Floats:
        """Bucket coordinates B of all rays, (K, n * n, 2) float32."""
        centres = cell_centres(bucket).reshape(1, -1, 2)
        aimed: Floats = (centres + (2 * self.shift[:, None] - 1) / bucket).astype(np.float32)
        return aimed

    def offset(self, plan: CapturePlan) -> Floats:
        """From a cell's centre to its point, in buckets, as the plan's fields lie: (rows, columns, 3)."""
        offset = np.zeros((plan.rows * plan.columns, 3), dtype=np.float32)
        offset[: len(self.shift), :2] = (self.shift - 0.5) / plan.layout.bucket
        return offset.reshape(plan.rows, plan.columns, 3)


_LIGHT = (Kind.INCIDENT, Kind.REFLECTION)  # what arrives, from lamps too
_OCCLUSION = (Kind.SHADOW, Kind.AO)  # what is in the way
_GAP = 0.01  # between camera and plane: in a world volume, light must not be lost on the way


class PortalCapture:
    """Captures `radiance`, `incident` and `reflection` in a scratch scene, tile by tile.

    Of `shadow` and `ao` it sends the rays, as camera rays that see no lamps; what goes below the facet is
    black and opaque.
    """

    def __init__(
        self,
        scene: bpy.types.Scene,
        plan: CapturePlan,
        kind: Kind,
        samples: int,
        seed: int,
        folder: Path,
        aim: Aim | None = None,
        first: int = 0,
    ) -> None:
        """`scene` is a scratch scene, written freely; `folder` takes the files that tiles pass through.

        `first` is the number of the first of `samples`, where others were taken before.
        """
        self._scene, self._plan = scene, plan
        self._file = folder / "tile.exr"
        apply_capture_settings(scene, samples, seed, first)
        if aim is not None:
            look_at_centres(scene)
            keep_passes(scene, aim.passes)
        size = (plan.columns * plan.layout.bucket, plan.rows * plan.layout.bucket)
        scene.render.resolution_x, scene.render.resolution_y = size
        scene.render.filepath = str(self._file)
        scene.render.use_border = scene.render.use_crop_to_border = True
        extent = Extent.of_pixels(*size)
        height = above_everything(scene)
        gap = max(_GAP, 1e-5 * height)
        light = kind in _LIGHT and (aim is None or not aim.passes)
        allow_more_bounces(scene, transparent=1, glossy=int(light))
        material = _portal_material(plan, kind, extent, 4 * gap, aim)
        if light:
            scene.render.film_transparent = False
            plane(scene, "RadTex mirror", extent, height, mirror_material(), visible="camera")
            plane(scene, "RadTex portals", extent, height + 3 * gap, material, visible="glossy")
        else:
            plane(scene, "RadTex portals", extent, height, material, visible="camera")
        scene.camera = camera_above(scene, extent, height + gap, gap)

    def render(self, tile: Tile) -> Floats:
        """Cells of the tile's texels: see `Capture.render`."""
        return next(iter(self.render_passes(tile).values()))

    def render_passes(self, tile: Tile) -> dict[str, Floats]:
        """Every pass that is kept, by its name, the combined one first: each (k, n, n, C), [texel, q, p]."""
        plan, n = self._plan, self._plan.layout.bucket
        rows = max(tile.rows, -(-MIN_IMAGE_SIDE // n))  # a lower picture is not to be had
        first = min(tile.first_row, plan.rows - rows)
        render = self._scene.render
        # The packed image's row 0 is its bottom one; a quarter of a pixel keeps rounding honest.
        total = plan.rows * n
        render.border_min_x, render.border_max_x = 0.0, 1.0
        render.border_min_y = (first * n + 0.25) / total if first else 0.0
        render.border_max_y = min(1.0, ((first + rows) * n + 0.25) / total)
        expected = (rows * n, plan.columns * n)
        passes = {}
        for name, image in render_layers(self._scene, self._file).items():
            if image.shape[:2] != expected:
                raise BakeError(f"Cycles returned a tile of {image.shape[:2]}, expected {expected}")
            cells = image.reshape(rows, n, plan.columns, n, -1).transpose(0, 2, 1, 3, 4)
            texels = cells[tile.first_row - first :].reshape(-1, n, n, image.shape[2])
            passes[name] = texels[: len(plan.texels_of(tile))]
        return passes


def _portal_material(
    plan: CapturePlan, kind: Kind, extent: Extent, reach: float, aim: Aim | None
) -> bpy.types.Material:
    """Ray Portals that start rays of `kind` for rays from within `reach`; clear to the scene's own."""
    material, build = open_material("RadTex portals")
    uv = build.vector(
        "MULTIPLY_ADD",
        build.geometry("Position"),
        (1 / extent.width, 1 / extent.height, 0.0),
        (0.5, 0.5, 0.0),
    )
    fields = ("position", "tangent", "bitangent", "normal", "facet")
    position, tangent, bitangent, normal, facet = (
        build.image(float_image(f"RadTex {name}", getattr(plan, name)), uv)[0] for name in fields
    )
    bucket = build.vector("FRACTION", build.vector("MULTIPLY", uv, (plan.columns, plan.rows, 0.0)))
    if aim is not None:
        bucket = build.vector(
            "ADD", bucket, build.image(float_image("RadTex shift", aim.offset(plan)), uv)[0]
        )
    x, y, i_z = _local_direction(build, bucket, kind)
    direction = build.vector("SCALE", tangent, x)
    direction = build.vector("ADD", direction, build.vector("SCALE", bitangent, y))
    direction = build.vector("ADD", direction, build.vector("SCALE", normal, i_z))
    height = build.vector("DOT_PRODUCT", direction, facet)
    direction = _above_facet(build, direction, facet, height, GRAZING if kind is Kind.RADIANCE else 0.0)
    lift = direction if kind is Kind.RADIANCE else facet
    start = build.vector("MULTIPLY_ADD", lift, _offset(build, plan, uv), position)
    way = build.vector("SCALE", direction, -1.0) if kind is Kind.RADIANCE else direction
    portal = build.node("ShaderNodeBsdfRayPortal")
    build.feed(portal.inputs["Position"], start)
    build.feed(portal.inputs["Direction"], way)
    surface = portal.outputs[0]
    if kind in _OCCLUSION:
        black = build.node("ShaderNodeEmission", (0.0, 0.0, 0.0, 1.0), 0.0).outputs[0]
        surface = build.node(
            "ShaderNodeMixShader", build.math("LESS_THAN", height, 0.0), surface, black
        ).outputs[0]
    clear = build.node("ShaderNodeBsdfTransparent").outputs[0]
    length = build.node("ShaderNodeLightPath").outputs["Ray Length"]
    ours = build.node("ShaderNodeMixShader", build.math("LESS_THAN", length, reach), clear, surface)
    build.node("ShaderNodeOutputMaterial", ours.outputs[0])
    return material


def _offset(
    build: NodeBuilder, plan: CapturePlan, uv: bpy.types.NodeSocket
) -> bpy.types.NodeSocket | tuple[float, float, float]:
    """How far from the surface rays start, thrice."""
    if plan.own_offset is None:
        return (float(ray_offset(plan.position)),) * 3
    spread = np.repeat(plan.own_offset, 3, axis=2)
    return build.image(float_image("RadTex offset", spread), uv)[0]


def _local_direction(build: NodeBuilder, bucket: Socket, kind: Kind) -> tuple[Socket, Socket, Socket]:
    """Where a ray of `kind` goes in the frame, from a place in the bucket, 0 to 1 along both sides."""
    if kind is Kind.AO:
        return _cosine_direction(build, bucket)
    a, i_z, q = _inverse_projection(build, bucket)
    across = build.vector("SCALE", a, build.math("MULTIPLY", q, -1.0) if kind is Kind.REFLECTION else q)
    x, y, _ = build.separate(across)
    return x, y, i_z


def _cosine_direction(build: NodeBuilder, bucket: Socket) -> tuple[Socket, Socket, Socket]:
    """The same spread by the cosine: `core.occlusion.square_to_cosine`."""
    b = build.vector("MULTIPLY_ADD", bucket, (2.0, 2.0, 0.0), (-1.0, -1.0, 0.0))
    x, y, _ = build.separate(b)
    wide, high, _ = build.separate(build.vector("ABSOLUTE", b))
    radius = build.math("MAXIMUM", wide, high)
    ratio = build.math("DIVIDE", build.math("MINIMUM", wide, high), radius)  # nodes have 0 for 0 / 0
    near = build.math("MULTIPLY", ratio, pi / 4)
    along = build.math("MULTIPLY", radius, build.math("COSINE", near))
    across = build.math("MULTIPLY", radius, build.math("SINE", near))
    steep = build.math("GREATER_THAN", high, wide)
    to_x, to_y = (
        build.math("MULTIPLY", build.mix(steep, *pair, "FLOAT"), build.math("SIGN", axis))
        for axis, pair in ((x, (along, across)), (y, (across, along)))
    )
    squared = build.math("MULTIPLY", radius, radius)
    up = build.math("SQRT", build.math("MAXIMUM", build.math("SUBTRACT", 1.0, squared), 0.0))
    return to_x, to_y, up


def _inverse_projection(build: NodeBuilder, bucket: Socket) -> tuple[Socket, Socket, Socket]:
    """A, I.z and q of a place in the bucket, 0 to 1 along both sides.

    B = 2 place - 1, A = B max|B| / |B|, I.z = 1 - |A|^2, q = sqrt(2 - |A|^2).
    """
    b = build.vector("MULTIPLY_ADD", bucket, (2.0, 2.0, 0.0), (-1.0, -1.0, 0.0))
    x, y, _ = build.separate(build.vector("ABSOLUTE", b))
    a = build.vector("SCALE", b, build.math("DIVIDE", build.math("MAXIMUM", x, y), build.vector("LENGTH", b)))
    squared = build.vector("DOT_PRODUCT", a, a)
    return a, build.math("SUBTRACT", 1.0, squared), build.math("SQRT", build.math("SUBTRACT", 2.0, squared))


def _above_facet(
    build: NodeBuilder, direction: Socket, facet: Socket, height: Socket, least: float
) -> Socket:
    """A smooth normal's hemisphere dips below the facet: such a ray is lifted to the facet's own horizon.

    `height` is the direction's above the facet.
    """
    sunk = build.math("SUBTRACT", least, height)
    lift = build.vector("SCALE", facet, build.math("MAXIMUM", sunk, 0.0))
    return build.vector("NORMALIZE", build.vector("ADD", direction, lift))
