# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The specification of an export: the target, and how its textures are stored; and its progress."""

from __future__ import annotations

from dataclasses import dataclass, fields
from enum import StrEnum
from math import inf
from typing import Any

from ..bake.layers import Layer
from ..core.errors import InputError
from ..core.messages import Setting, do, leave_out
from ..formats.json_reader import Facts
from ..settings.choices import parse_layer
from ..settings.spec import as_json
from ..settings.targets import MOST_PIXELS, MeshPacking, Target, TextureFormat

__all__ = [
    "Arrangement",
    "ExportSpec",
    "ExportStep",
    "ExportTask",
    "MeshPacking",
    "Target",
    "TextureFormat",
    "export_facts",
    "export_spec_in",
]


class Arrangement(StrEnum):
    """How buckets lie in a texture: the paper's matrix, or an array with a layer for each cell."""

    MATRIX = "matrix"
    SLICES = "slices"


LEAST_PIXELS = 16
MOST_LEVELS = 15
IMAGE_LIMIT = 2048  # pixels along a side


@dataclass(frozen=True)
class ExportSpec:
    """The settings of one export. Raises InputError for invalid ones.

    `levels` is the number of mip levels, None for as many as fit; `limit` the most pixels along a texture's
    side, None for the target's default. `layers` of the bake are exported in addition to the whole, each
    once. An export that takes more than `memory_mb`, beside Blender, is refused. `mirror` adds a moving
    mirror ball; `sky` is the linear colour that it shows where a ray meets nothing, None for the default.
    `image_limit` is the most pixels along a side of the images that materials are shown by; with 0 the bake's
    own maps show them. `mesh` is how the .glb stores its vertices and triangles.
    """

    target: Target
    format: TextureFormat = TextureFormat.AUTO
    zstd: bool = True
    arrangement: Arrangement = Arrangement.MATRIX
    levels: int | None = None
    limit: int | None = None
    layers: tuple[Layer, ...] = ()
    memory_mb: int | None = None
    mirror: bool = False
    sky: tuple[float, float, float] | None = None
    image_limit: int = IMAGE_LIMIT
    mesh: MeshPacking = MeshPacking.AUTO

    def __post_init__(self) -> None:
        object.__setattr__(self, "layers", tuple(dict.fromkeys(map(parse_layer, self.layers or ()))))
        taken = self.target.traits.formats
        if self.format not in taken:
            words = ", ".join(form for form in TextureFormat if form in taken)
            raise InputError(
                f"format {self.format}: {self.target} does not read it",
                do(f"choose from {words}", Setting.FORMAT),
            )
        if self.levels is not None and not 1 <= self.levels <= MOST_LEVELS:
            raise InputError(f"levels {self.levels}: give a whole number from 1 to {MOST_LEVELS}")
        if self.mirror and not self.target.traits.mirror:
            words = ", ".join(target for target in Target if target.traits.mirror)
            raise InputError(f"a mirror ball for {self.target}: choose from {words}")
        if self.mirror and self.arrangement is Arrangement.SLICES:
            raise InputError("a mirror ball reads no slices", leave_out(Setting.ARRANGEMENT))
        if self.sky is not None and not all(0 <= value < inf for value in self.sky):
            raise InputError(f"mirror's sky {self.sky}: give three numbers of 0 or more")
        if self.limit is not None and self.limit < LEAST_PIXELS:
            raise InputError(f"limit {self.limit}: a texture needs {LEAST_PIXELS} pixels at least")

        meshes = self.target.traits.meshes
        if self.mesh not in (MeshPacking.AUTO, *meshes):
            takers = ", ".join(target for target in Target if self.mesh in target.traits.meshes)
            raise InputError(
                f"mesh {self.mesh}: {self.target} does not read it, {takers} do", leave_out(Setting.MESH)
            )
        if self.image_limit and not LEAST_PIXELS <= self.image_limit <= MOST_PIXELS:
            raise InputError(
                f"{self.image_limit} pixels for images: give 0, or {LEAST_PIXELS} to {MOST_PIXELS}"
            )

    @property
    def shows_images(self) -> bool:
        """Whether materials are shown by their own images, whose coordinates a mirror ball does not know."""
        return self.target.traits.images and self.image_limit > 0 and not self.mirror

    @property
    def compressed(self) -> bool:
        """Whether the .glb's mesh is compressed by EXT_meshopt_compression."""
        meshes = self.target.traits.meshes
        return (meshes[0] if self.mesh is MeshPacking.AUTO else self.mesh) is MeshPacking.MESHOPT

    @property
    def most_pixels(self) -> int:
        """The most pixels along a texture's side."""
        return self.limit or self.target.traits.most_pixels


def export_facts(spec: ExportSpec) -> dict[str, Any]:
    """The specification as JSON's types: the inverse of `export_spec_in`."""
    return {field.name: as_json(getattr(spec, field.name)) for field in fields(ExportSpec)}


def export_spec_in(facts: Facts) -> ExportSpec:
    """The specification in a JSON object. Raises FormatError, and InputError for one that is invalid."""

    def number(key: str, least: int, otherwise: int | None = None) -> int | None:
        return otherwise if facts.values.get(key) is None else facts.whole_number(key, least)

    image_limit = number("image_limit", 0, IMAGE_LIMIT)
    assert image_limit is not None
    sky: Any = None if facts.values.get("sky") is None else tuple(facts.numbers("sky", 3))
    return ExportSpec(
        target=Target(facts.choice("target", tuple(Target))),
        format=TextureFormat(facts.choice("format", tuple(TextureFormat))),
        zstd=facts.truth("zstd"),
        arrangement=Arrangement(facts.choice("arrangement", tuple(Arrangement))),
        levels=number("levels", 1),
        limit=number("limit", 1),
        layers=tuple(map(Layer, facts.choices("layers", tuple(Layer)))),
        memory_mb=number("memory_mb", 1),
        mirror="mirror" in facts.values and facts.truth("mirror"),
        sky=sky,
        image_limit=image_limit,
        mesh=MeshPacking(facts.choice("mesh", tuple(MeshPacking)) if "mesh" in facts.values else "auto"),
    )


class ExportTask(StrEnum):
    """The tasks of an export, in order."""

    TEXTURES = "textures"
    FLAT = "flat"
    MESH = "mesh"
    PACK = "pack"


@dataclass(frozen=True)
class ExportStep:
    """`done` of `total` units of a task are finished."""

    stage: ExportTask
    done: int
    total: int
