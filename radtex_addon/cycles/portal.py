# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The fast capture: one orthographic camera looks at a plane of Ray Portals, and a tile is one render call.

The plane's material computes texel and cell from the position on the plane, looks the texel's frame up in
float images, and sends the camera's ray on, towards P or outwards from P in the cell's direction. To Cycles
it is still a camera ray. Light kinds must see lamps, which Cycles hides from camera rays: for them the camera
looks at a sharp mirror, and portals above it catch the glossy rays.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import isqrt, pi
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ..bake.computed_rows import computed
from ..bake.plan import MIN_IMAGE_SIDE, CapturePlan, Tile, sheet_seed
from ..core import large_arrays
from ..core.arrays import Floats, blocks
from ..core.errors import BakeError
from ..core.hemisphere import cell_centres
from ..core.surface import GRAZING, ray_offset
from ..formats.disk.path_checks import render_path
from ..scene.nodes import NodeBuilder, Socket, open_material
from ..settings.kinds import Kind, Light, Rays
from .building_blocks import (
    Extent,
    above_everything,
    camera_above,
    float_image,
    mirror_material,
    plane,
    render_layers,
)
from .capture_settings import allow_more_bounces, apply_capture_settings, keep_passes, look_at_centres
from .passes import Passes, finite_light


@dataclass(frozen=True, eq=False)
class Aim:
    """Aim rays at one known point of every cell, and keep some of their passes.

    `shift` (K, 2): this point in the cells of each of the plan's texels, from 0 to 1 along both sides.
    `passes` are attributes of a view layer. If there are any, rays of light kinds do not see lamps.
    `starts` (K, m * m, 3): where a texel's rays start, in equal shares, if not at its own point; its bucket
    has one cell then, and m is a whole number.
    """

    shift: Floats
    passes: tuple[str, ...] = ()
    starts: Floats | None = None

    @property
    def parts(self) -> int:
        """How many parts a pixel has along each side, of which each has a start of its own."""
        return 1 if self.starts is None else isqrt(self.starts.shape[1])

    def square(self, bucket: int) -> Floats:
        """Bucket coordinates B of all rays, (K, n * n, 2) float32."""
        centres = cell_centres(bucket).reshape(-1, 2).T[:, None]
        aimed: Floats = (centres + (2 * self.shift.T[..., None] - 1) / bucket).astype(np.float32)
        return np.moveaxis(aimed, 0, -1)  # lie apart in memory: NumPy is fast along a long axis only

    def squares(self, bucket: int) -> Floats:
        """The same, computed where some texels' rays are read."""
        return computed(
            (len(self.shift), bucket * bucket, 2), lambda some: Aim(self.shift[some]).square(bucket)
        )

    def offset(self, plan: CapturePlan) -> Floats:
        """Offsets from a cell's centre to its point, in units of a bucket's side.

        Packed like the plan's fields: (rows, columns, 3).
        """
        offset = large_arrays.zeros((plan.rows * plan.columns, 3))
        for some in blocks(len(self.shift)):
            offset[some, :2] = (self.shift[some] - 0.5) / plan.layout.bucket
        return offset.reshape(plan.rows, plan.columns, 3)

    def packed_starts(self, plan: CapturePlan) -> Floats:
        """The starts of each pixel, packed like the plan's fields: (rows, columns, m * m * 3)."""
        if self.starts is None:
            return plan.position
        count = len(self.starts)
        rows = np.minimum(np.arange(plan.rows * plan.columns), count - 1)
        return large_arrays.taken(self.starts, rows).reshape(plan.rows, plan.columns, -1)


FIRST_ROW = "RadTex first row"  # label of the node with the sheet's first row in the images, plus 0.5
_FRAME = ("position", "tangent", "bitangent", "normal", "facet")
_GAP = 0.01  # between camera and plane: short, so that a world volume absorbs no light on the way


class PortalCapture:
    """Captures `radiance`, `incident` and `reflection` in a scratch scene, tile by tile.

    For `shadow` and `ao` it only sends the rays, as camera rays that see no lamps; rays below the facet are
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
        whole: bool = False,
    ) -> None:
        """`scene` is a scratch scene, which is changed; `folder` is for the temporary files of tiles.

        `first` is the number of the first of `samples`, if earlier ones were already taken. With `whole` the
        float images hold all sheets: the scene then renders any of them, depending on its seed and the node
        FIRST_ROW, but `render` must not be called.
        """
        self._scene, self._plan, self._seed, self._sheet = scene, plan, seed, 0
        self._file = folder / "tile.exr"
        apply_capture_settings(scene, samples, seed, first)
        if aim is not None:
            if aim.parts == 1:
                look_at_centres(scene)
            keep_passes(scene, aim.passes)
        size = (plan.columns * plan.layout.bucket, plan.sheet_rows * plan.layout.bucket)
        scene.render.resolution_x, scene.render.resolution_y = size
        scene.render.filepath = render_path(self._file)
        scene.render.use_border = scene.render.use_crop_to_border = True
        extent = Extent.of_pixels(*size)
        height = above_everything(scene)
        gap = max(_GAP, 1e-5 * height)
        light = kind.traits.light is Light.ARRIVING and (aim is None or not aim.passes)
        allow_more_bounces(scene, transparent=1, glossy=int(light))
        self._fields = _Fields(plan, aim, whole)
        material = _portal_material(plan, kind, extent, 4 * gap, self._fields)
        if light:
            scene.render.film_transparent = False
            plane(scene, "RadTex mirror", extent, height, mirror_material(), visible="camera")
            plane(scene, "RadTex portals", extent, height + 3 * gap, material, visible="glossy")
        else:
            plane(scene, "RadTex portals", extent, height, material, visible="camera")
        scene.camera = camera_above(scene, extent, height + gap, gap)

    def render(self, tile: Tile) -> Floats:
        """Cells of the tile's texels: see `Capture.render`."""
        return self.render_passes(tile).whole

    def render_passes(self, tile: Tile) -> Passes:
        """Render a tile, and return every pass that is kept: each (k, n, n, C), [texel, q, p]."""
        return _joined([self._render_part(sheet, part) for sheet, part in self._plan.in_sheets(tile)])

    def _render_part(self, sheet: int, tile: Tile) -> Passes:
        """Like `render_passes`, for a tile that lies in one sheet."""
        plan, n, height = self._plan, self._plan.layout.bucket, self._plan.sheet_rows
        self._show(sheet)
        first, rows = rendered_rows(plan, tile)
        render = self._scene.render
        # Row 0 of the packed image is at the bottom; a quarter of a pixel keeps rounding safe.
        total = height * n
        render.border_min_x, render.border_max_x = 0.0, 1.0
        render.border_min_y = (first * n + 0.25) / total if first else 0.0
        render.border_max_y = min(1.0, ((first + rows) * n + 0.25) / total)
        return _passes_of_rows(plan, sheet, tile, render_layers(self._scene, self._file))

    def reseed(self, seed: int) -> None:
        """Set the seed of the next renders, for different noise."""
        self._seed = seed
        cast(Any, self._scene).cycles.seed = sheet_seed(seed, self._sheet)

    def _show(self, sheet: int) -> None:
        """Set the sheet of the next renders."""
        if sheet == self._sheet:
            return
        self._sheet = sheet
        self.reseed(self._seed)
        self._fields.show(sheet)


class SheetCapture:
    """Takes tiles from pictures of whole sheets, which were rendered by a scene that is `whole`.

    Cycles seeds its rays by pixel: a tile has the same bits in a picture of its sheet as in one of its own.
    """

    def __init__(self, plan: CapturePlan, sheet: Callable[[int], Passes]) -> None:
        """`sheet` gives a sheet's passes, each (H, W, C), by its number."""
        self._plan, self._sheet = plan, sheet

    def render_passes(self, tile: Tile) -> Passes:
        """As of a `PortalCapture`."""
        return _joined([self._part(sheet, part) for sheet, part in self._plan.in_sheets(tile)])

    def _part(self, sheet: int, tile: Tile) -> Passes:
        n = self._plan.layout.bucket
        first, rows = rendered_rows(self._plan, tile)
        rendered = self._sheet(sheet).mapped(lambda image: image[first * n : (first + rows) * n])
        return _passes_of_rows(self._plan, sheet, tile, rendered)


def rendered_rows(plan: CapturePlan, tile: Tile) -> tuple[int, int]:
    """The first row, and the number of rows, that are rendered for a tile of a sheet."""
    rows = max(tile.rows, -(-MIN_IMAGE_SIDE // plan.layout.bucket))  # Blender renders no lower picture
    return min(tile.first_row, plan.sheet_rows - rows), rows


def _joined(parts: list[Passes]) -> Passes:
    if len(parts) == 1:
        return parts[0]
    joined = {name: np.concatenate([part.raw[name] for part in parts]) for name in parts[0].raw}
    return replace(parts[0], raw=joined)


def _passes_of_rows(plan: CapturePlan, sheet: int, tile: Tile, rendered: Passes) -> Passes:
    """A tile's passes, each (k, n, n, C), of a picture of the rows that were rendered for it."""
    n = plan.layout.bucket
    first, rows = rendered_rows(plan, tile)
    expected = (rows * n, plan.columns * n)
    texels = plan.texels_of(Tile(sheet * plan.sheet_rows + tile.first_row, tile.rows))

    def cells_of(image: Floats) -> Floats:
        if image.shape[:2] != expected:
            raise BakeError(f"Cycles returned a tile of {image.shape[:2]}, expected {expected}")
        cells = image.reshape(rows, n, plan.columns, n, -1).transpose(0, 2, 1, 3, 4)
        return cells[tile.first_row - first :].reshape(-1, n, n, image.shape[2])[: len(texels)]

    finite_light(rendered.raw_whole)
    return rendered.mapped(cells_of)


class _Fields:
    """The float images with rays' starts and buckets' orientation: of one sheet, or if `whole` of all."""

    def __init__(self, plan: CapturePlan, aim: Aim | None, whole: bool) -> None:
        self._plan, self._whole = plan, whole
        self._of = {name: getattr(plan, name) for name in _FRAME}
        self.parts = 1 if aim is None else aim.parts
        if aim is not None:
            self._of["shift"] = aim.offset(plan)
            self._of["position"] = aim.packed_starts(plan)
        if plan.own_offset is not None:
            self._of["offset"] = np.repeat(plan.own_offset, 3, axis=2)
        self.images = self._images(0)

    def show(self, sheet: int) -> None:
        """Replace the image data-blocks by the sheet's: Cycles caches images by identity."""
        before, self.images = self.images, self._images(sheet)
        for name, image in before.items():
            image.user_remap(self.images[name])
            bpy.data.images.remove(image)

    @property
    def rows(self) -> int:
        """The number of rows of the images."""
        return self._plan.rows if self._whole else self._plan.sheet_rows

    def _images(self, sheet: int) -> dict[str, bpy.types.Image]:
        fields = {
            name: field if self._whole else self._plan.window(field, sheet)
            for name, field in self._of.items()
        }
        fields["position"] = _apart(fields["position"], self.parts)
        return {name: float_image(f"RadTex {name}", field) for name, field in fields.items()}


def _apart(packed: Floats, parts: int) -> Floats:
    """Values (R, C, m * m * 3) of so many `parts` m of pixels along each side, as pixels: (R m, C m, 3)."""
    rows, columns = packed.shape[:2]
    apart = packed.reshape(rows, columns, parts, parts, 3).transpose(0, 2, 1, 3, 4)
    return apart.reshape(rows * parts, columns * parts, 3)


def _portal_material(
    plan: CapturePlan, kind: Kind, extent: Extent, reach: float, fields: _Fields
) -> bpy.types.Material:
    """Ray Portals for rays shorter than `reach`, sent on as `kind` needs; longer rays pass through."""
    material, build = open_material("RadTex portals")
    uv = build.vector(
        "MULTIPLY_ADD",
        build.geometry("Position"),
        (1 / extent.width, 1 / extent.height, 0.0),
        (0.5, 0.5, 0.0),
    )
    bucket, lookup, in_parts = _texel_and_cell(build, plan, uv, fields.rows, fields.parts)
    images = {
        name: build.image(image, in_parts if name == "position" else lookup)[0]
        for name, image in fields.images.items()
    }
    position, tangent, bitangent, normal, facet = (images[name] for name in _FRAME)
    if fields.parts > 1:
        bucket = build.combine(0.5, 0.5)
    if "shift" in images:
        bucket = build.vector("ADD", bucket, images["shift"])
    x, y, i_z = _local_direction(build, bucket, kind)
    direction = build.vector("SCALE", tangent, x)
    direction = build.vector("ADD", direction, build.vector("SCALE", bitangent, y))
    direction = build.vector("ADD", direction, build.vector("SCALE", normal, i_z))
    height = build.vector("DOT_PRODUCT", direction, facet)
    inwards = kind.traits.rays is Rays.INWARDS
    direction = _above_facet(build, direction, facet, height, GRAZING if inwards else 0.0)
    lift = direction if inwards else facet
    offset = images.get("offset", (float(ray_offset(plan.position)),) * 3)
    start = build.vector("MULTIPLY_ADD", lift, offset, position)
    way = build.vector("SCALE", direction, -1.0) if inwards else direction
    portal = build.node("ShaderNodeBsdfRayPortal")
    build.feed(portal.inputs["Position"], start)
    build.feed(portal.inputs["Direction"], way)
    surface = portal.outputs[0]
    if kind.traits.light is Light.OCCLUSION:
        black = build.node("ShaderNodeEmission", (0.0, 0.0, 0.0, 1.0), 0.0).outputs[0]
        surface = build.node(
            "ShaderNodeMixShader", build.math("LESS_THAN", height, 0.0), surface, black
        ).outputs[0]
    clear = build.node("ShaderNodeBsdfTransparent").outputs[0]
    length = build.node("ShaderNodeLightPath").outputs["Ray Length"]
    ours = build.node("ShaderNodeMixShader", build.math("LESS_THAN", length, reach), clear, surface)
    build.node("ShaderNodeOutputMaterial", ours.outputs[0])
    return material


def _texel_and_cell(
    build: NodeBuilder, plan: CapturePlan, uv: Socket, rows: int, parts: int
) -> tuple[Socket, Socket, Socket]:
    """The place in the bucket, 0 to 1 along both sides, and the texel's UV in images with `rows` rows.

    The last is the UV in an image in which each texel has so many `parts` along each side. All use the same
    rounded texel, so that a ray on a texel's edge does not mix two texels.
    """
    size = (float(plan.columns), float(plan.sheet_rows), 1.0)
    place = build.vector("MULTIPLY", uv, size)
    texel = build.vector("FLOOR", place)
    texel = build.vector("MAXIMUM", texel, (0.0, 0.0, 0.0))
    texel = build.vector("MINIMUM", texel, (size[0] - 1, size[1] - 1, 0.0))
    bucket = build.vector("SUBTRACT", place, texel)
    whole = (size[0], float(rows), 1.0)
    middle = build.vector("ADD", texel, build.combine(0.5, build.value(0.5, FIRST_ROW)))
    lookup = build.vector("DIVIDE", middle, whole)
    if parts == 1:
        return bucket, lookup, lookup
    part = build.vector("FLOOR", build.vector("SCALE", bucket, float(parts)))
    part = build.vector("MINIMUM", part, (parts - 1.0, parts - 1.0, 0.0))
    step = build.vector("MULTIPLY_ADD", part, (1 / parts, 1 / parts, 0.0), (0.5 / parts - 0.5,) * 3)
    return bucket, lookup, build.vector("DIVIDE", build.vector("ADD", middle, step), whole)


def _local_direction(build: NodeBuilder, bucket: Socket, kind: Kind) -> tuple[Socket, Socket, Socket]:
    """A ray's direction in the frame, for a place in the bucket, 0 to 1 along both sides."""
    if kind.traits.rays is Rays.COSINE:
        return _cosine_direction(build, bucket)
    a, i_z, q = _inverse_projection(build, bucket)
    mirrored = kind.traits.rays is Rays.MIRRORED
    across = build.vector("SCALE", a, build.math("MULTIPLY", q, -1.0) if mirrored else q)
    x, y, _ = build.separate(across)
    return x, y, i_z


def _cosine_direction(build: NodeBuilder, bucket: Socket) -> tuple[Socket, Socket, Socket]:
    """Like `_local_direction`, but distributed by the cosine: `core.hemisphere.square_to_cosine`."""
    b = build.vector("MULTIPLY_ADD", bucket, (2.0, 2.0, 0.0), (-1.0, -1.0, 0.0))
    x, y, _ = build.separate(b)
    wide, high, _ = build.separate(build.vector("ABSOLUTE", b))
    radius = build.math("MAXIMUM", wide, high)
    ratio = build.math("DIVIDE", build.math("MINIMUM", wide, high), radius)  # in nodes, 0 / 0 is 0
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
    """Lift directions that lie below the facet: a smooth normal's hemisphere reaches below its horizon.

    `height` is the cosine between direction and facet normal, `least` the smallest allowed cosine.
    """
    sunk = build.math("SUBTRACT", least, height)
    lift = build.vector("SCALE", facet, build.math("MAXIMUM", sunk, 0.0))
    return build.vector("NORMALIZE", build.vector("ADD", direction, lift))
