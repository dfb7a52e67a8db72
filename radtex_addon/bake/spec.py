# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What to bake, and how: checked once, when it is made, and valid from then on."""

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

_BYTES_PER_CHANNEL = 8  # float32, twice: as cells, and joined to an image (measured: RGBA 33 to 35)
_BYTES_PER_TEXEL = 256  # points and frames, once as a map and once packed (measured: 180 to 240)
_BYTES_OF_BANDS = 160 << 20  # cells in memory while an atlas is written, and the writer (measured)
_TILE_MB = 1024  # the most that one render may take
_BYTES_PER_SHARED_PIXEL = 240  # both lobes' ten channels in float32, three times: fitted, as images, stored
_BYTES_PER_RAY = 48  # single paths in float16, their directions, and the fit's arrays

_CONDENSED_CELLS = 14  # with its border a bucket is 16 pixels wide: whole blocks of a compressed texture
_TRANSFER_CELLS = 9  # odd, so that the creases of octahedral maps run through the middles of cells


@dataclass(frozen=True)
class BakeSpec:
    """One bake: `texels` on the atlas's longer side, `bucket` cells on a bucket's side, `samples` per cell.

    Enums may be given as text. Raises InputError for what cannot be baked.

    * `layout`: in the shared layout, which bakes radiance by the portal, buckets are octahedral, and a texel
      takes about 64 paths per sample, however many cells it has (`Rays.of`). Default of `bucket`:
      `layout.cells`, but 14 if condensed, and 9 for kind `transfer`.
    * `uv_layer`: the object's layer to bake on; without one, `unwrap` makes a layer, with `padding` texels
      between islands. `device`: see `cycles.device.use_device`. `memory_mb`: limit for the bake's memory,
      without the scene's. `half`, `compression`: the format of the files.
    * `layers`: parts of the radiance that become atlases beside it. `content`: what a proxy shows, a
      collection's name, "*" for everything, or None for what lies inside it.
    * `accumulate` adds the samples to the existing atlas; `refresh` bakes only its changed texels again, with
      as many samples as it has; `where` limits both to the faces of a vertex group, a boolean face attribute
      or a material.
    * `budget` (bytes of its textures on a GPU) or `target` (accuracy against the fit, in dB): condense a bake
      in the shared layout (`core.condensed`).
    * `source`: the atlas holds what this other object shows, found along the baked object's normals; the
      baked object itself is invisible. `extrusion`: how far it is searched for, in scene units; None for a
      few per cent of the size. `cage`: an object with the same vertices and faces further out; the search
      starts there and goes as far inwards.
    * Kind `transfer`: buckets are octahedral maps of directions to the light; each of the bucket² suns that
      it is captured under takes `samples` paths per texel and `view`.
    * Kind `ao`: what is farther than `ao_distance`, in scene units, counts as open.
    * `frame`: the frame at which the scene is baked; `unwrap_at`: the frame at which its mesh is unwrapped.
    * `lights`: names of lamps, and of collections with lamps, that alone are lit; "world" is all light that
      comes from no lamp.
    * `objects`: two or more that share the atlas; the bake's name is then only the atlas's. `split`: the
      atlas is of one `part`, a material's name or a UDIM tile's number; None for an atlas of each.
    * `sheet`: cells of the plain layout are rendered in sheets of about `sheet`² pixels, each with its seed.
    """

    kind: Kind = Kind.RADIANCE
    texels: int = 128
    bucket: int = cast(int, None)  # None only until __post_init__ sets the default
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
        if self.kind is Kind.SHADOW:  # always one ray per cell
            object.__setattr__(self, "samples", 1)

    def _suited_bucket(self) -> int:
        if parse_kind(self.kind) is Kind.TRANSFER:
            return _TRANSFER_CELLS
        return _CONDENSED_CELLS if self.condensed else self.layout.cells

    @property
    def condensed(self) -> bool:
        """Whether the files hold mixtures of a few buckets per cluster, as compressed textures."""
        return self.budget is not None or self.target is not None

    @property
    def channels(self) -> int:
        """Channels of a cell while it is baked: four and three for each captured layer; one for occlusion."""
        if self.kind in OCCLUSION:
            return 1
        return WHOLE + OF_LAYER * len(captured(self.layers))

    @property
    def rays(self) -> Rays:
        """The numbers of paths in the shared layout."""
        return Rays.of(self.samples)

    @property
    def pixels_a_side(self) -> int:
        """Pixels of the atlas's longer side; in the shared layout buckets have a border of one cell."""
        border = 2 if self.layout is Layout.SHARED else 0
        return self.texels * views_along(self.view) * (self.bucket + border)

    @property
    def pixel_count(self) -> int:
        """The most pixels that the atlas can have: those of a square one."""
        return self.pixels_a_side**2

    @property
    def path_count(self) -> int:
        """The most camera paths that the bake can take."""
        if self.layout is Layout.SHARED:
            return self.rays.most(self.texels**2)
        return self.pixel_count * self.samples

    @property
    def streams(self) -> bool:
        """Whether cells are on disk during the bake, with only bands of the atlas in memory."""
        whole = self.kind is Kind.TRANSFER or self.accumulate or self.refresh
        return self.layout is Layout.BUCKETS and not whole

    @property
    def tile_mb(self) -> int:
        """MiB that one render may take: the allowed memory minus the atlas's."""
        if self.memory_mb is None:
            return _TILE_MB
        return max(1, min(_TILE_MB, self.memory_mb - self.atlas_bytes // 2**20))

    @property
    def atlas_bytes(self) -> int:
        """The most memory that the atlas can take during the bake, in bytes."""
        if self.streams:
            of_bands = min(_BYTES_OF_BANDS, 2 * _BYTES_PER_CHANNEL * self.pixel_count * self.channels)
            return self.texels**2 * (_BYTES_PER_TEXEL + self.bucket**2 // 8) + of_bands
        if self.layout is Layout.SHARED:
            return shared_bytes(self.texels, self.bucket, self.samples)
        return self.pixel_count * self.channels * _BYTES_PER_CHANNEL


def shared_bytes(texels: int, cells: int, samples: int) -> int:
    """The most memory that an atlas in the shared layout can take during the bake, in bytes."""
    of_texel = (cells + 2) ** 2 * _BYTES_PER_SHARED_PIXEL + Rays.of(samples).of_texel * _BYTES_PER_RAY
    return texels**2 * of_texel
