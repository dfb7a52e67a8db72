# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What to bake, and how: checked once, where it is made, and true from then on."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

from ..formats.exr import Compression
from .choices import (
    ARRIVING,
    LEAVING,
    OCCLUSION,
    SOURCED,
    CaptureMethod,
    Kind,
    Layout,
    Unwrap,
    View,
    parse_capture,
    parse_compression,
    parse_kind,
    parse_layer,
    parse_layout,
    parse_split,
    parse_unwrap,
    parse_view,
)
from .layers import OF_LAYER, WHOLE, Layer, captured
from .parts import Split
from .plan import SHEET
from .rays import Rays
from .spec_checks import check
from .transfer_views import views_along

__all__ = [
    "ARRIVING",
    "LEAVING",
    "OCCLUSION",
    "SOURCED",
    "BakeSpec",
    "CaptureMethod",
    "Compression",
    "Kind",
    "Layer",
    "Layout",
    "Split",
    "Unwrap",
    "View",
    "parse_capture",
    "parse_compression",
    "parse_kind",
    "parse_layer",
    "parse_layout",
    "parse_split",
    "parse_unwrap",
    "parse_view",
]

_BYTES_PER_CHANNEL = 8  # float32, twice: cells by texel are joined to an image (measured: RGBA 33 to 35)
_BYTES_PER_TEXEL = 256  # points and frames, once as a map and once packed (measured: 180 to 240)
_BYTES_OF_BANDS = 160 << 20  # cells in hand while an atlas is written, and what writes it (measured)
_TILE_MB = 1024  # what one render may take at most
_BYTES_PER_SHARED_PIXEL = 240  # both lobes' ten channels in float32, three times: fitted, as images, stored
_BYTES_PER_RAY = 48  # single paths in float16, their directions, and what the fit makes of them

_CONDENSED_CELLS = 14  # with its border a bucket is 16 pixels wide: whole blocks of a compressed texture
_TRANSFER_CELLS = 9  # an odd number: then the creases of octahedral maps run through cells' middles


@dataclass(frozen=True)
class BakeSpec:
    """One bake: `texels` on the atlas's longer side, `bucket` cells on a bucket's side, `samples` per cell.

    In the shared `layout`, which takes radiance by the portal, buckets are octahedral, and a texel spends
    about 64 paths for each of `samples`, however many cells there are (`Rays.of`). Without `bucket` it has
    `layout.cells`. `uv_layer` names a layer of the object to bake on; without one, `unwrap` makes a layer,
    with `padding` texels between islands. `device` is a wish that Cycles answers. `half` and `compression`
    shape the files; `memory_mb` bounds what the bake takes beside the scene. `layers` are parts of a radiance
    that become atlases beside it. `content` is what a proxy shows: a collection's name, "*" for everything,
    or what lies inside it. To `accumulate` is to fold the samples into the atlas that is there, to `refresh`
    is to bake again only what has changed of it, with the samples that it has; `where` names a vertex group,
    a boolean attribute of faces or a material whose faces alone that is done to. Enums may be given as text.
    With a `budget`, the bytes that its textures may take on a GPU, or a `target`, how near they are to come
    to what was fitted, in dB, a bake in the shared layout is condensed (`core.condensed`). With a `source`
    the atlas holds what that object shows, found along the normals of this one, which is not seen itself,
    within an `extrusion` in scene units, or where that is None within a few per cent of its size; with a
    `cage`, an object with the same vertices and faces further out, from there on and as far inwards.
    Of kind `transfer`, buckets are octahedral maps of directions to the light, and each of the bucket² suns
    that it is captured under costs `samples` paths a texel from each `view`; without `bucket` there are 9 x 9
    cells.
    Of kind `ao`, what is farther than `ao_distance`, in scene units, counts as open.
    Where there is a `frame`, the scene is baked as it is then, on the unwrap that the mesh has at the frame
    `unwrap_at`, or its own.
    With `lights`, names of lamps and of collections with some, these alone are lit; "world" is the light of
    no lamp.
    With `objects`, which are at least two, the atlas is of them all, and not of the one that it is called
    after. With a `split` it is of a `part` of the surface alone: a material's, by that one's name, or a UDIM
    tile's, by its number; without the part, what is meant is one atlas for each.
    Cells of the plain layout are rendered in sheets of about `sheet`² pixels, each with a seed of its own.
    Raises InputError for what cannot be baked.
    """

    kind: Kind = Kind.RADIANCE
    texels: int = 128
    bucket: int = cast(int, None)  # the layout's, from __post_init__ on
    samples: int = 16
    uv_layer: str | None = None
    capture: CaptureMethod = CaptureMethod.PORTAL
    seed: int = 0
    device: str = "auto"
    half: bool = True
    compression: Compression = Compression.ZIP
    unwrap: Unwrap = Unwrap.XATLAS
    padding: int = 2
    memory_mb: int | None = None
    layout: Layout = Layout.BUCKETS
    budget: int | None = None
    target: float | None = None
    layers: tuple[Layer, ...] = ()
    content: str | None = None
    accumulate: bool = False
    refresh: bool = False
    source: str | None = None
    extrusion: float | None = None
    view: View = View.NORMAL
    frame: int | None = None
    unwrap_at: int | None = None
    cage: str | None = None
    lights: tuple[str, ...] = ()
    objects: tuple[str, ...] = ()
    split: Split | None = None
    part: str | None = None
    ao_distance: float | None = None
    where: str | None = None
    sheet: int = SHEET

    def __post_init__(self) -> None:
        object.__setattr__(self, "layout", parse_layout(self.layout))
        if cast(int | None, self.bucket) is None:
            object.__setattr__(self, "bucket", self._suited_bucket())
        object.__setattr__(self, "kind", parse_kind(self.kind))
        object.__setattr__(self, "capture", parse_capture(self.capture))
        object.__setattr__(self, "compression", parse_compression(self.compression))
        object.__setattr__(self, "unwrap", parse_unwrap(self.unwrap))
        object.__setattr__(self, "view", parse_view(self.view))
        if self.split is not None:
            object.__setattr__(self, "split", parse_split(self.split))
        object.__setattr__(self, "layers", tuple(dict.fromkeys(map(parse_layer, self.layers))))
        for name in ("lights", "objects"):
            object.__setattr__(self, name, tuple(dict.fromkeys(getattr(self, name))))
        check(self)
        if self.kind is Kind.SHADOW:  # one ray a cell, whatever is asked for
            object.__setattr__(self, "samples", 1)

    def _suited_bucket(self) -> int:
        if parse_kind(self.kind) is Kind.TRANSFER:
            return _TRANSFER_CELLS
        return _CONDENSED_CELLS if self.condensed else self.layout.cells

    @property
    def condensed(self) -> bool:
        """Whether the files hold mixtures of a few buckets, as compressed textures."""
        return self.budget is not None or self.target is not None

    @property
    def channels(self) -> int:
        """Of a cell, while it is baked: the whole's four, and its layers'; what is seen or not is one."""
        if self.kind in OCCLUSION:
            return 1
        return WHOLE + OF_LAYER * len(captured(self.layers))

    @property
    def rays(self) -> Rays:
        """What the shared layout spends."""
        return Rays.of(self.samples)

    @property
    def pixels_a_side(self) -> int:
        """Of the atlas's longer side; octahedral buckets have a border of one cell."""
        border = 2 if self.layout is Layout.SHARED else 0
        return self.texels * views_along(self.view) * (self.bucket + border)

    @property
    def pixel_count(self) -> int:
        """Most pixels that the atlas can have: a square one's."""
        return self.pixels_a_side**2

    @property
    def path_count(self) -> int:
        """Most camera paths that the bake can take."""
        if self.layout is Layout.SHARED:
            return self.rays.most(self.texels**2)
        return self.pixel_count * self.samples

    @property
    def streams(self) -> bool:
        """Whether cells lie on the disk while it bakes, and only bands of the atlas are in memory."""
        whole = self.kind is Kind.TRANSFER or self.accumulate or self.refresh
        return self.layout is Layout.BUCKETS and not whole

    @property
    def tile_mb(self) -> int:
        """What one render may take: of the memory that is allowed, what the atlas leaves."""
        if self.memory_mb is None:
            return _TILE_MB
        return max(1, min(_TILE_MB, self.memory_mb - self.atlas_bytes // 2**20))

    @property
    def atlas_bytes(self) -> int:
        """Most memory that the atlas can take while it is baked."""
        if self.streams:
            of_bands = min(_BYTES_OF_BANDS, 2 * _BYTES_PER_CHANNEL * self.pixel_count * self.channels)
            return self.texels**2 * (_BYTES_PER_TEXEL + self.bucket**2 // 8) + of_bands
        if self.layout is Layout.SHARED:
            return shared_bytes(self.texels, self.bucket, self.samples)
        return self.pixel_count * self.channels * _BYTES_PER_CHANNEL


def shared_bytes(texels: int, cells: int, samples: int) -> int:
    """Most memory that an atlas in the shared layout can take while it is baked."""
    of_texel = (cells + 2) ** 2 * _BYTES_PER_SHARED_PIXEL + Rays.of(samples).of_texel * _BYTES_PER_RAY
    return texels**2 * of_texel
