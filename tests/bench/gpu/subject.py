# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An object as `bakes` left it: its mesh, its view, and its textures, at the size of larger bakes too."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.formats.containers.texture import (
    PixelFormat,
    Texture,
    TextureShape,
    decode_texture,
    encode_texture,
)
from radtex_addon.formats.containers.unit_blocks import CHANNELS, decode_units, encode_units

from ..drawing import Model, View

DATA = Path(__file__).parent / "data"
TEXELS = 64  # of the bakes
CUBE, CUBE_LEVELS = 128, 6  # pixels along a face of the probe; its levels' roughness grows evenly from 0 to 1
_TILES = ("own", "rest")


class Image:
    """A texture with its levels: in blocks, as a card takes them, and as a filter finds them.

    `format` is of the blocks. An array's levels are (layers, H, W, C) float32, others (H, W, C).
    """

    def __init__(self, form: TextureShape, blocks: Texture | None, levels: tuple[Floats, ...]) -> None:
        self._form, self._blocks, self._levels = form, blocks, levels

    @classmethod
    def of_blocks(cls, blocks: Texture) -> Image:
        return cls(blocks.form, blocks, ())

    @classmethod
    def of(cls, levels: Sequence[Floats], kind: PixelFormat, is_array: bool = False) -> Image:
        *layers, height, width, _ = levels[0].shape
        form = TextureShape(kind, width, height, layers[0] if is_array else 1, len(levels), is_array)
        return cls(form, None, tuple(levels))

    @property
    def format(self) -> PixelFormat:
        return self._form.format

    @property
    def nbytes(self) -> int:
        """Bytes of the blocks."""
        return sum(self._form.nbytes(level) for level in range(self._form.levels))

    @property
    def blocks(self) -> Texture:
        if self._blocks is None:
            if self.format in CHANNELS:
                self._blocks = encode_units(self._levels, self.format)
            else:
                layers = [level if self._form.is_array else level[None] for level in self._levels]
                self._blocks = encode_texture(layers, self.format, self._form.is_array)
        return self._blocks

    @property
    def levels(self) -> tuple[Floats, ...]:
        if not self._levels and self._blocks is not None:
            if self.format in CHANNELS:
                self._levels = decode_units(self._blocks)
            else:
                found = decode_texture(self._blocks)
                self._levels = tuple(level if self._form.is_array else level[0] for level in found)
        return self._levels


@dataclass(frozen=True, eq=False)
class Subject:
    """An object's bakes as ones of `times` as many texels would lie in memory, their values interpolated."""

    name: str
    facts: dict[str, Any]
    arrays: dict[str, Any]
    times: int
    _made: dict[str, Image] = field(default_factory=dict)

    @classmethod
    def read(cls, name: str, times: int = 1) -> Subject:
        """One of `names()`. Raises ValueError for any other."""
        if name not in names():
            raise ValueError(f"{name}: no such object, choose {', '.join(names())}")
        with np.load(DATA / f"{name}.npz") as file:
            arrays = dict(file)
        return cls(name, json.loads(arrays.pop("facts").tobytes()), arrays, times)

    def model(self, form: str) -> Model:
        """The mesh with the texture coordinates of the "layered" bake, or of that in "buckets"."""
        corners = self.arrays[f"{form} points"][self.arrays[f"{form} index"]]
        return Model.of(corners, self.facts[f"{form} parts"])

    def view(self, size: tuple[int, int]) -> View:
        """Where it is seen from, in a picture of that width and height."""
        view = self.facts["view"]
        return View(np.array(view["place"]), np.array(view["target"]), view["half"], size[0] / size[1])

    def image(self, name: str) -> Image:
        """The texture of a layer of the layered bake, of the "buckets", or of the "probe"."""
        if name not in self._made:
            self._made[name] = self._image(name)
        return self._made[name]

    def _image(self, name: str) -> Image:
        facts = self.facts["textures"][name]
        (width, height), count = facts["size"], facts["levels"]
        blocks = tuple(self.arrays[f"{name} {number}"] for number in range(count))
        kept = Image.of_blocks(
            Texture(PixelFormat(facts["format"]), width, height, blocks, is_array=len(blocks[0]) > 1)
        )
        if facts.get("halved"):
            return Image.of((_enlarged(kept.levels[0], 2, from_edges=True), *kept.levels), kept.format)
        if self.times == 1 or name in ("distances", "probe"):  # as large in every bake
            return kept
        (image,), cells, times = kept.levels, facts["cells"], self.times
        rows, columns = (side // cells for side in image.shape[:2])
        if name == "buckets":  # by texel, and in each by cell; else the other way round
            parts, back = (
                image.reshape(rows, cells, columns, cells, -1).transpose(1, 3, 0, 2, 4),
                (2, 0, 3, 1, 4),
            )
        else:
            parts, back = (
                image.reshape(cells, rows, cells, columns, -1).transpose(0, 2, 1, 3, 4),
                (0, 2, 1, 3, 4),
            )
        larger = _enlarged(parts, times).transpose(back)
        return Image.of((larger.reshape(times * rows * cells, times * columns * cells, -1),), kept.format)

    def values(self, variant: dict[str, Any]) -> dict[str, Any]:
        """A layered lookup's uniforms that are the same for all materials."""
        found = dict(variant["values"])
        for name in _TILES:
            if f"radtex_{name}_tile" in found:
                *share, across, up = found[f"radtex_{name}_tile"]
                found[f"radtex_{name}_tile"] = [*share, across / self.times, up / self.times]
        return found


def names() -> list[str]:
    """All objects."""
    return sorted(path.stem for path in DATA.glob("*.npz"))


def cube_directions(size: int) -> Floats:
    """Directions through the middles of a cube's pixels, (6, size, size, 3), as OpenGL numbers its faces."""
    across, down = np.meshgrid(*[(2 * np.arange(size) + 1) / size - 1] * 2)
    one = np.ones_like(across)
    faces = (
        (one, -down, -across),
        (-one, -down, across),
        (across, one, down),
        (across, -one, -down),
        (across, -down, one),
        (-across, -down, -one),
    )
    found: Floats = np.stack([np.stack(face, axis=-1) for face in faces]).astype(np.float32)
    return found


def _enlarged(image: Floats, times: int, from_edges: bool = False) -> Floats:
    """An image (..., H, W, C) with as many more rows and columns, linearly between the given ones.

    With `from_edges` the outermost pixels' centres lie on the image's edge, before and after.
    """
    for axis in (-3, -2):
        count = image.shape[axis]
        place = (np.arange(times * count) + 0.5) / times - 0.5
        if from_edges:
            place = np.linspace(0, count - 1, times * count)
        low = np.clip(np.floor(place).astype(int), 0, count - 2)
        share = np.clip(place - low, 0, 1).astype(np.float32)
        share = share.reshape([-1] + [1] * (-1 - axis))
        image = image.take(low, axis) * (1 - share) + image.take(low + 1, axis) * share
    return image
