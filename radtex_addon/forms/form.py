# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What every form of a bake can do."""

from __future__ import annotations

from collections.abc import Callable, Collection, Generator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, TypeAlias

import bpy

from ..bake.forms import FormTraits
from ..bake.progress import Progress
from ..bake.spec import BakeSpec, Compression
from ..core.arrays import Floats
from ..core.sampler import Filter
from ..core.surface import SurfaceMesh
from ..formats.condensed_sizes import Shapes
from ..formats.json_reader import Facts
from ..formats.sidecar import Sidecar
from ..textures.entry import TextureEntry
from ..textures.godot_shader import GodotShader
from ..textures.progress import Step
from ..textures.spec import ExportSpec, Target
from .bake_job import BakeJob
from .outcome import Outcome

# Light (N, 3), linear, of N fragments: uv (N, 2), normal (N, 3) and direction to the viewer (N, 3) in world
# space, and that direction in the fragment's frame (N, 3).
Lookup: TypeAlias = Callable[[Floats, Floats, Floats, Floats], Floats]


@dataclass(frozen=True, eq=False)
class Opened:
    """A finished bake, read: its sidecar, its images, and the light in them.

    `texels` (H, W, K) are what each texel has of its own, as it is stored. `compression` is None for one that
    RadTex does not write, and for textures. `loss` is how far two of `texels` may be apart that were the same
    before they were packed, over the larger. `budget` is how many bytes a condensed bake's textures take on a
    GPU, None for another.
    """

    sidecar: Sidecar
    images: tuple[Path, ...]
    lookup: Lookup
    texels: Floats
    compression: Compression | None
    loss: float = 0.0
    budget: int | None = None


@dataclass(frozen=True)
class PreviewOf:
    """What a preview's material is made for; a `hull` shows its front alone."""

    title: str
    spec: BakeSpec
    sidecar: Path
    uv_layer: str
    scene: bpy.types.Scene
    filter: Filter
    hull: bool


class Form(Protocol):
    """A way to hold a bake. `sidecar` is the path of the bake's sidecar, an absolute one for previews."""

    @property
    def traits(self) -> FormTraits:
        """What a specification knows of the form."""
        ...

    # A bake to be made

    def images(self, spec: BakeSpec, sidecar: Path) -> tuple[Path, ...]:
        """All images that such a bake can write."""
        ...

    def bake(self, job: BakeJob) -> Generator[Progress, None, Outcome]:
        """Bake, and write the files.

        Raises InputError for what cannot be baked, BakeError for what fails.
        """
        ...

    def check_size(self, spec: BakeSpec, width: int, height: int) -> None:
        """Raise InputError where `width` x `height` texels cannot be held as the specification wants."""
        ...

    def check_previewable(self, spec: BakeSpec) -> None:
        """Raise InputError where no GPU takes the images of a square atlas."""
        ...

    def material(self, of: PreviewOf) -> bpy.types.Material:
        """The material that shows a bake on its baked copy."""
        ...

    # A bake that is there

    def holds(self, facts: Facts) -> bool:
        """Whether a sidecar with the form's layout is of this form."""
        ...

    def is_of(self, facts: Facts, spec: BakeSpec) -> bool:
        """Whether a sidecar of this form is of a bake with these layers, cells and samples."""
        ...

    def read_sidecar(self, sidecar: Path) -> Sidecar:
        """What all forms' sidecars tell. Raises FormatError."""
        ...

    def open(self, sidecar: Path) -> Opened:
        """Read a bake. Raises FormatError for files that are missing, damaged, or of different bakes."""
        ...

    def shapes(self, sidecar: Path, texels: int = 1, cells: int = 1) -> Shapes:
        """Width, height and channels of each image in `Opened.images`, by layer.

        With `texels` and `cells` times as many along a side.
        """
        ...

    def expanded_bytes(self, sidecar: Path) -> int:
        """Memory that reading takes beside the images' own pixels."""
        ...

    # An export of it

    def export_bytes(self, sidecar: Path) -> int:
        """The most memory that an export takes beside what any does."""
        ...

    def textures_of(self, facts: Facts, present: Collection[str]) -> tuple[str, ...]:
        """The names of an exported bake's textures, of which layers that are not `present` may be absent."""
        ...

    def flat(self, sidecar: Path, surface: SurfaceMesh) -> Generator[Step, None, Floats]:
        """The flat lightmap (H, W, 3 or 4): see `textures.flat`."""
        ...

    def write_textures(self, sidecar: Path, spec: ExportSpec, folder: Path) -> dict[str, TextureEntry]:
        """Write the bake's textures into `folder`, called as its images but for the ending; entries by layer.

        Raises InputError for what the bake or the format cannot be, FormatError, with the path, for files
        that are missing, damaged or of different bakes, BakeError where the system refuses.
        """
        ...

    def includes(self, bake: Mapping[str, Any]) -> tuple[str, ...]:
        """The stems of the shader includes that look a bake up, by its sidecar's JSON."""
        ...

    def usage(
        self, bake: Mapping[str, Any], textures: Mapping[str, TextureEntry], target: Target
    ) -> list[str]:
        """Lines that say how the lookup is called for these very textures."""
        ...

    def godot_shader(
        self, bake: Mapping[str, Any], textures: Mapping[str, TextureEntry], baked: Floats
    ) -> GodotShader:
        """The shader in Godot; `baked` (3, 3) turns the mesh's directions into those of Blender's world."""
        ...
