# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What follows from the options of a bake: sizes, paths and memory."""

from __future__ import annotations

from math import ceil, sqrt

from .denoising import denoising_bytes
from .forms import FormTraits
from .kinds import Light, form_of
from .layers import OF_LAYER, WHOLE, captured
from .options import MARKED, BakeOptions
from .plan import MAX_IMAGE_SIDE
from .rays import CLEAR_SAMPLES, LayeredRays, coarser, finer
from .texel_density import MOST_TEXELS, STEP
from .transfer_buckets import views_along

_BYTES_PER_CHANNEL = 8  # float32, twice: as cells, and joined to an image (measured: RGBA 33 to 35)
_BYTES_PER_TEXEL = 256  # points and frames, once as a map and once packed (measured: 180 to 240)
_BYTES_OF_BANDS = 160 << 20  # cells in memory while an atlas is written, and the writer (measured)
_TILE_MB = 1024  # the most that one render may take
_BYTES_OF_PANORAMAS = 800 << 20  # a layered bake's renders, of panoramas or of tiles (measured)
_BYTES_PER_FINER_TEXEL = 100  # of the layered layout's maps of the material (measured)
_BYTES_PER_BUCKET = 11_000  # of the layered layout's, while they are fitted (measured)
_BYTES_PER_EARLIER_TEXEL, _BYTES_PER_EARLIER_BUCKET = 40, 4_000  # of a bake to accumulate on, float32
_BYTES_PER_LAYERED_RAY = 20  # single paths in float16, and what the fit says of them; 60 % of texels covered


class SpecFields(BakeOptions):
    """The options of a bake with what follows from them; `BakeSpec` checks them."""

    @property
    def form(self) -> FormTraits:
        """How the atlas is stored."""
        return form_of(self.kind, self.layout)

    @property
    def marks(self) -> tuple[str, ...]:
        """The options that its sidecar names because they are on."""
        return tuple(name for name in MARKED if getattr(self, name))

    @property
    def channels(self) -> int:
        """Channels of a cell while it is baked: four and three for each captured layer; one for occlusion."""
        if self.form.channels is not None:
            return self.form.channels
        return WHOLE + OF_LAYER * len(captured(self.layers))

    @property
    def layered_rays(self) -> LayeredRays:
        """The numbers of paths in the layered layout."""
        return LayeredRays.of(self.samples)

    def most_paths(self, texels: int) -> int:
        """The most camera paths of a bake by paths that covers so many texels."""
        return self.layered_rays.most(texels)

    @property
    def pixels_a_side(self) -> int:
        """Pixels of the atlas's longer side."""
        return self.texels * views_along(self.view) * self.bucket

    @property
    def most_texels(self) -> int:
        """The most texels along a side that a density may ask for: a multiple of `STEP`."""
        storable = MAX_IMAGE_SIDE // (views_along(self.view) * self.bucket)
        return min(MOST_TEXELS, max(storable // STEP, 1) * STEP)

    @property
    def pixel_count(self) -> int:
        """The most pixels that the atlas can have: those of a square one."""
        return self.pixels_a_side**2

    @property
    def path_count(self) -> int:
        """The most camera paths that the bake can take."""
        if self.form.by_paths:
            return self.most_paths(self.texels**2)
        return self.pixel_count * self._rays_of_cell

    @property
    def _rays_of_cell(self) -> int:
        """The most rays of a cell; with a distance they are a square number."""
        if not self.kind.traits.samples:
            return CLEAR_SAMPLES
        return self.samples if self.ao_distance is None else ceil(sqrt(self.samples)) ** 2

    @property
    def streams(self) -> bool:
        """Whether cells are on disk during the bake, with only bands of the atlas in memory."""
        return self.form.streams and not (self.accumulate or self.refresh)

    @property
    def can_denoise(self) -> bool:
        """Whether the bake is of light in buckets, and traced anew."""
        new = not (self.accumulate or self.refresh)
        return new and not self.form.by_paths and self.kind.traits.light is not Light.OCCLUSION

    @property
    def tile_mb(self) -> int:
        """MiB that one render may take: the allowed memory minus the atlas's."""
        if self.memory_mb is None:
            return _TILE_MB
        return max(1, min(_TILE_MB, self.memory_mb - self.atlas_bytes // 2**20))

    @property
    def atlas_bytes(self) -> int:
        """The most memory that the atlas can take during the bake, in bytes.

        In the layered layout what a bake takes beside the scene, of an object that covers about 60 % of the
        texels.
        """
        if self.streams:
            of_bands = min(_BYTES_OF_BANDS, 2 * _BYTES_PER_CHANNEL * self.pixel_count * self.channels)
            if self.denoise:
                of_bands = max(of_bands, denoising_bytes(self.texels, self.bucket, self.channels))
            return self.texels**2 * (_BYTES_PER_TEXEL + self.bucket**2 // 8) + of_bands
        if self.form.by_paths:
            fine, buckets = self.texels * finer(self.texels), self.texels / coarser(self.texels)
            of_maps = fine**2 * _BYTES_PER_FINER_TEXEL + buckets**2 * _BYTES_PER_BUCKET
            if self.accumulate:
                of_maps += fine**2 * _BYTES_PER_EARLIER_TEXEL + buckets**2 * _BYTES_PER_EARLIER_BUCKET
            of_rays = self.texels**2 * self.layered_rays.of_texel * _BYTES_PER_LAYERED_RAY
            return _BYTES_OF_PANORAMAS + int(of_maps) + of_rays
        return self.pixel_count * self.channels * _BYTES_PER_CHANNEL
