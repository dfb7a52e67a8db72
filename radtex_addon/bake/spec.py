# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What to bake, and how: checked once, where it is made, and true from then on."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import cast

from ..core.errors import InputError
from ..formats.exr import Compression
from ..formats.memory import physical_memory, readable_size
from .choices import (
    ARRIVING,
    LEAVING,
    OCCLUSION,
    SOURCED,
    CaptureMethod,
    Kind,
    Layout,
    Unwrap,
    parse_capture,
    parse_compression,
    parse_kind,
    parse_layer,
    parse_layout,
    parse_unwrap,
)
from .layers import OF_LAYER, WHOLE, Layer, captured
from .plan import MAX_IMAGE_SIDE
from .rays import Rays

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
    "Unwrap",
    "parse_capture",
    "parse_compression",
    "parse_kind",
    "parse_layer",
    "parse_layout",
    "parse_unwrap",
]

_BYTES_PER_CHANNEL = 8  # float32, twice: cells by texel are joined to an image (measured: RGBA 33 to 35)
_BYTES_PER_SHARED_PIXEL = 240  # both lobes' ten channels in float32, three times: fitted, as images, stored
_BYTES_PER_RAY = 48  # single paths in float16, their directions, and what the fit makes of them

_MOST_SHARED_SAMPLES = 2**12  # 177 thousand paths a texel
_CONDENSED_CELLS = 14  # with its border a bucket is 16 pixels wide: whole blocks of a compressed texture
_TRANSFER_CELLS = 9  # an odd number: then the creases of octahedral maps run through cells' middles
_TARGETS = (10.0, 60.0)  # dB; textures of 8 bits come no nearer

# What a whole number may be; Cycles's own bounds for samples and seed.
_LIMITS = {
    "texels": (1, MAX_IMAGE_SIDE),
    "bucket": (2, 256),
    "samples": (1, 2**24),
    "seed": (0, 2**31 - 1),
    "padding": (0, 256),
    "memory_mb": (16, 2**24),
    "budget": (1, 2**40),
    "frame": (0, 1048574),
    "unwrap_at": (0, 1048574),
}
_OPTIONAL = ("budget", "frame", "unwrap_at")


@dataclass(frozen=True)
class BakeSpec:
    """One bake: `texels` on the atlas's longer side, `bucket` cells on a bucket's side, `samples` per cell.

    In the shared `layout`, which takes radiance by the portal, buckets are octahedral, and a texel spends
    about 64 paths for each of `samples`, however many cells there are (`Rays.of`). Without `bucket` it has
    `layout.cells`. `uv_layer` names a layer of the object to bake on; without one, `unwrap` makes a layer,
    with `padding` texels between islands. `device` is a wish that Cycles answers. `half` and `compression`
    shape the files; `memory_mb` bounds a tile, not the atlas. `layers` are parts of a radiance that become
    atlases beside it. `content` is what a proxy shows: a collection's name, "*" for everything, or what lies
    inside it. To `accumulate` is to fold the samples into the atlas that is there, to `refresh` is to bake
    again only what has changed of it, with the samples that it has. Enums may be given as text. With a
    `budget`, the bytes that its textures may take on a GPU, or a `target`, how near they are to come to what
    was fitted, in dB, a bake in the shared layout is condensed (`core.condensed`). With a `source` the atlas
    holds what that object shows, found along the normals of this one, which is not seen itself, within an
    `extrusion` in scene units, or where that is None within a few per cent of its size.
    Of kind `transfer`, buckets are octahedral maps of directions to the light, and each of the bucket² suns
    that it is captured under costs `samples` paths a texel; without `bucket` there are 9 x 9 cells.
    Where there is a `frame`, the scene is baked as it is then, on the unwrap that the mesh has at the frame
    `unwrap_at`, or its own.
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
    memory_mb: int = 1024
    layout: Layout = Layout.BUCKETS
    budget: int | None = None
    target: float | None = None
    layers: tuple[Layer, ...] = ()
    content: str | None = None
    accumulate: bool = False
    refresh: bool = False
    source: str | None = None
    extrusion: float | None = None
    frame: int | None = None
    unwrap_at: int | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "layout", parse_layout(self.layout))
        if cast(int | None, self.bucket) is None:
            object.__setattr__(self, "bucket", self._suited_bucket())
        object.__setattr__(self, "kind", parse_kind(self.kind))
        object.__setattr__(self, "capture", parse_capture(self.capture))
        object.__setattr__(self, "compression", parse_compression(self.compression))
        object.__setattr__(self, "unwrap", parse_unwrap(self.unwrap))
        object.__setattr__(self, "layers", tuple(dict.fromkeys(map(parse_layer, self.layers))))
        for name, (least, most) in _LIMITS.items():
            if name not in _OPTIONAL or getattr(self, name) is not None:
                _check_whole_number(name, getattr(self, name), least, most)
        if self.unwrap_at is not None and (self.frame is None or self.uv_layer is not None):
            raise InputError(
                f"unwrap at frame {self.unwrap_at} is for frames without a UV layer: leave it out"
            )
        if self.uv_layer == "":
            raise InputError("the UV layer's name is empty: name one of the object's, or none to unwrap anew")
        self._check_kind()
        if self.layout is Layout.SHARED:
            self._check_shared()
        if self.condensed:
            self._check_condensed()
        self._check_size()

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
        return self.texels * (self.bucket + border)

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
    def atlas_bytes(self) -> int:
        """Most memory that the atlas can take while it is baked."""
        if self.layout is Layout.SHARED:
            of_rays = self.texels**2 * self.rays.of_texel * _BYTES_PER_RAY
            return self.pixel_count * _BYTES_PER_SHARED_PIXEL + of_rays
        return self.pixel_count * self.channels * _BYTES_PER_CHANNEL

    def _check_kind(self) -> None:
        if self.capture is CaptureMethod.PANORAMIC and self.kind in LEAVING:
            raise InputError(
                f"capture panoramic only looks outwards and cannot bake {self.kind}: "
                "capture by portal, or bake incident or reflection"
            )
        if self.layers and self.kind not in LEAVING:
            raise InputError(f"{self.kind} has no layers: bake radiance, or leave the layers out")
        if self.accumulate or self.refresh:
            self._check_earlier()
        if self.content is not None and self.kind is not Kind.PROXY:
            raise InputError(f"{self.kind} shows the object itself: bake a proxy, or leave the content out")
        if self.kind is Kind.TRANSFER:
            self._check_transfer()
        self._check_source()
        if self.kind in OCCLUSION:
            self._check_occlusion()

    def _check_source(self) -> None:
        if self.source is None:
            if self.extrusion is not None:
                raise InputError(
                    f"extrusion {self.extrusion:g} is for what another object shows: name that one (--from), "
                    "or leave the extrusion out"
                )
            return
        if not self.source:
            raise InputError("the name of the object to bake from is empty: name one, or none")
        if self.kind not in SOURCED:
            raise InputError(f"{self.kind} is not baked from another object: leave --from out")
        if self.layout is not Layout.BUCKETS:
            raise InputError("the shared layout is not baked from another object: choose layout buckets")
        if self.capture is not CaptureMethod.PORTAL:
            raise InputError(f"capture {self.capture} bakes from no other object: capture by portal")
        if self.extrusion is not None and not 0 < self.extrusion < inf:
            raise InputError(f"extrusion {self.extrusion:g}: give a distance above 0, in scene units")

    def _check_transfer(self) -> None:
        for asked, wrong, remedy in (
            ("shared layout", self.layout is not Layout.BUCKETS, "choose layout buckets"),
            ("capture panoramic", self.capture is not CaptureMethod.PORTAL, "capture by portal"),
            ("budget or target", self.condensed, "leave it out"),
        ):
            if wrong:
                raise InputError(f"kind transfer knows no {asked}: {remedy}")

    def _check_occlusion(self) -> None:
        """A shadow sends one ray a cell, whatever `samples` says."""
        kind = self.kind
        if self.layout is not Layout.BUCKETS:
            raise InputError(f"the shared layout holds light, not {kind}: choose layout buckets")
        if self.capture is not CaptureMethod.PORTAL:
            raise InputError(f"capture {self.capture} cannot bake {kind}: capture by portal")
        if self.compression is Compression.DWAA:
            raise InputError(f"compression dwaa is for light and spoils {kind}: choose zip or piz")
        if kind is Kind.SHADOW:
            if not self.half:
                raise InputError("shadow holds bits, not floats: leave 32-bit floats (--float) out")
            object.__setattr__(self, "samples", 1)

    def _check_earlier(self) -> None:
        if self.accumulate and self.refresh:
            raise InputError("to accumulate and to refresh contradict each other: choose one of them")
        done = "accumulated" if self.accumulate else "refreshed"
        for asked, wrong, remedy in (
            (f"kind {self.kind}", self.kind not in (*LEAVING, *ARRIVING), "bake it anew"),
            ("the shared layout", self.layout is not Layout.BUCKETS, "choose layout buckets"),
            ("layers", bool(self.layers), "leave the layers out"),
            ("capture panoramic", self.capture is not CaptureMethod.PORTAL, "capture by portal"),
        ):
            if wrong:
                raise InputError(f"{asked} cannot be {done}: {remedy}")

    def _check_shared(self) -> None:
        for name, found, only in (
            ("kind", self.kind, Kind.RADIANCE),
            ("capture", self.capture, CaptureMethod.PORTAL),
        ):
            if found is not only:
                raise InputError(
                    f"the shared layout knows {name} {only} only, not {found}: bake that in layout buckets"
                )
        if self.layers:
            raise InputError("the shared layout has no layers: bake those in layout buckets")
        _check_whole_number("samples in the shared layout", self.samples, 1, _MOST_SHARED_SAMPLES)

    def _check_condensed(self) -> None:
        asked = "a budget" if self.target is None else "a target"
        if self.layout is not Layout.SHARED:
            raise InputError(f"{asked} needs the shared layout: choose --layout shared, or leave it out")
        if self.budget is not None and self.target is not None:
            raise InputError("a budget and a target contradict each other: give one of them")
        if not self.half or self.compression is not Compression.ZIP:
            raise InputError(f"{asked} makes textures of one format: leave --float and --compression out")
        least, most = _TARGETS
        if self.target is not None and not least <= self.target <= most:
            raise InputError(f"target {self.target:g} dB: give {least:g} to {most:g} dB")
        if self.bucket % 4 != 2:
            raise InputError(
                f"bucket {self.bucket} with {asked}: give 6, 10, 14 or 18 cells, which with their border "
                "fill the blocks of compressed textures"
            )

    def _check_size(self) -> None:
        asked = f"texels {self.texels} with bucket {self.bucket}"
        if self.pixels_a_side > MAX_IMAGE_SIDE:
            side = self.pixels_a_side
            raise InputError(f"{asked} makes {side} pixels a side, {MAX_IMAGE_SIDE} is the most: lower one")
        memory = physical_memory()
        if memory is not None and self.atlas_bytes > memory:
            needed, present = readable_size(self.atlas_bytes), readable_size(memory)
            raise InputError(f"{asked} needs {needed} of memory, this machine has {present}: lower one")


def _check_whole_number(name: str, value: object, least: int, most: int) -> None:
    if isinstance(value, int) and not isinstance(value, bool) and least <= value <= most:
        return
    raise InputError(f"{name} {value}: give a whole number from {least} to {most}")
