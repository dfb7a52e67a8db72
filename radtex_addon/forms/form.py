# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The interface of all forms."""

from __future__ import annotations

from collections.abc import Callable, Collection, Generator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, TypeAlias

import bpy

from ..bake.progress import Progress
from ..core.arrays import Floats
from ..core.fragments import Fragments
from ..core.sampler import Filter
from ..core.surface import SurfaceMesh
from ..formats.image_files import Shapes
from ..formats.json_reader import Facts
from ..formats.sidecar import Sidecar
from ..formats.sidecar_file import SidecarFile
from ..scene.image_materials import ImageMaterial
from ..settings.cost import Cost
from ..settings.forms import FormTraits
from ..settings.spec import BakeSpec, Compression
from ..textures.entry import TextureEntry
from ..textures.export_spec import ExportSpec, ExportStep, Target
from .bake_job import BakeJob
from .hlsl_lookup import HlslLookup
from .outcome import Outcome

Lookup: TypeAlias = Callable[[Fragments], Floats]  # the linear light (N, 3) of N fragments
Alpha: TypeAlias = Callable[[Floats], Floats]  # what texture coordinates (N, 2) hide of what is behind, (N,)


@dataclass(frozen=True, eq=False)
class Opened:
    """A finished bake, read: its sidecar, its images' paths, and a `lookup` of the light in them.

    `texels` (H, W, K) are the stored values that belong to single texels, of the atlas's or of fewer; of
    buckets (H, W, G, K), some of their cells.
    `compression` is None if RadTex does not write it. `loss` is the largest relative
    difference between two of `texels` that were equal before lossy compression. `alpha` is None if the
    surface hides all that is behind it.
    """

    sidecar: Sidecar
    images: tuple[Path, ...]
    lookup: Lookup
    texels: Floats
    compression: Compression | None
    loss: float = 0.0
    alpha: Alpha | None = None


@dataclass(frozen=True)
class PreviewOf:
    """The input of a preview's material: `sidecar` is an absolute path; a `hull` shows only its front."""

    title: str
    spec: BakeSpec
    sidecar: Path
    uv_layer: str
    scene: bpy.types.Scene
    filter: Filter
    hull: bool


class Form(Protocol):
    """A way to store a bake.

    `sidecar` is the path of the sidecar if the bake is still to be made, else the file, already read.
    """

    @property
    def traits(self) -> FormTraits:
        """The form's row in `settings.forms`."""
        ...

    # For a bake that is to be made

    def images(self, spec: BakeSpec, sidecar: Path) -> tuple[Path, ...]:
        """The paths of all images that such a bake can write."""
        ...

    def bake(self, job: BakeJob) -> Generator[Progress, None, Outcome]:
        """Bake, and write the files.

        Raises InputError for what cannot be baked, BakeError for what fails.
        """
        ...

    def cost(self, spec: BakeSpec) -> Cost:
        """The most that such a bake costs."""
        ...

    def check_size(self, spec: BakeSpec, width: int, height: int) -> None:
        """Raise InputError if `width` x `height` texels cannot be stored as specified."""
        ...

    def check_previewable(self, spec: BakeSpec) -> None:
        """Raise InputError if the images of a square atlas are too large for GPUs."""
        ...

    def material(self, of: PreviewOf) -> bpy.types.Material:
        """The material that shows a bake on its baked copy."""
        ...

    def materials(self, of: PreviewOf, images: Mapping[int, ImageMaterial]) -> dict[int, bpy.types.Material]:
        """Materials by number that show a bake by the object's own `images`; the others have `material`."""
        ...

    def script_node(self, tree: bpy.types.NodeTree, sidecar: SidecarFile) -> bpy.types.Node:
        """Add a Script node (OSL) that looks a finished bake up, with the sockets of the material's group.

        Raises FormatError as the form's readers do, InputError where OSL cannot be used: see `preview.osl`.
        """
        ...

    # For a finished bake

    def holds(self, facts: Facts) -> bool:
        """Whether a sidecar with the form's layout is of this form."""
        ...

    def is_of(self, facts: Facts, spec: BakeSpec) -> bool:
        """Whether a sidecar of this form is of a bake with these layers, cells and samples."""
        ...

    def read_sidecar(self, sidecar: SidecarFile) -> Sidecar:
        """Read the facts that the sidecars of all forms have. Raises FormatError."""
        ...

    def open(self, sidecar: SidecarFile) -> Opened:
        """Read a bake. Raises FormatError for files that are missing, damaged, or of different bakes."""
        ...

    def shapes(self, sidecar: SidecarFile, texels: int = 1, cells: int = 1) -> Shapes:
        """Width, height and channels of each image in `Opened.images`, by layer.

        For a bake with `texels` times as many texels along a side, and `cells` times as many cells.
        """
        ...

    # For its export

    def export_bytes(self, sidecar: SidecarFile) -> int:
        """The most bytes of memory that an export needs in addition to what every export needs."""
        ...

    def own_images(self, sidecar: SidecarFile) -> tuple[int, ...]:
        """The numbers of the materials that can be shown by their own images."""
        ...

    def material_count(self, sidecar: SidecarFile) -> int:
        """How many materials shaders tell apart."""
        ...

    def textures_of(self, facts: Facts, present: Collection[str]) -> tuple[str, ...]:
        """The names of an exported bake's textures; optional layers only if they are `present`."""
        ...

    def flat(self, sidecar: SidecarFile, surface: SurfaceMesh) -> Generator[ExportStep, None, Floats]:
        """The flat lightmap (H, W, 3 or 4): see `textures.flat_lightmap`."""
        ...

    def check_textures(self, sidecar: SidecarFile, spec: ExportSpec) -> None:
        """Raise InputError for options that `write_textures` would refuse, as far as the sidecar tells."""
        ...

    def write_textures(
        self, sidecar: SidecarFile, spec: ExportSpec, folder: Path, images: bool = False
    ) -> dict[str, TextureEntry]:
        """Write the bake's textures into `folder`, named as its images with other suffixes; entries by layer.

        With `images` those are left out in whose place all materials have images of their own.
        Raises InputError for options that the bake or the format does not support, FormatError, with the
        path, for files that are missing, damaged or of different bakes, BakeError where the system refuses.
        """
        ...

    def includes(self, bake: Mapping[str, Any]) -> tuple[str, ...]:
        """The stems of the shader includes that look up a `bake`, which is its sidecar's JSON."""
        ...

    def usage(self, bake: Mapping[str, Any], textures: Mapping[str, TextureEntry]) -> list[str]:
        """Lines that show how a shader calls the lookup for these textures."""
        ...

    def shader_facts(
        self, bake: Mapping[str, Any], textures: Mapping[str, TextureEntry], images: bool = False
    ) -> dict[str, Any] | None:
        """What shaders must be told of an exported bake besides its sidecar, as JSON; None if nothing.

        With `images` materials are shown by their own images where they can be.
        """
        ...

    def hlsl(
        self,
        bake: Mapping[str, Any],
        textures: Mapping[str, TextureEntry],
        target: Target,
        images: bool = False,
    ) -> HlslLookup:
        """The lookup in HLSL of an exported bake with this sidecar's JSON; `images` as in `shader_facts`."""
        ...
