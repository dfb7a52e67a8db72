# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake leaves: its files and the facts in them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import bpy

from ..bake.spec import BakeSpec, Layout
from ..core.shared import Axis
from ..formats.packing import layer_names
from ..formats.shared_files import layer_path, texture_path
from ..formats.sidecar import Part, Sidecar, Source, file_name
from ..version import VERSION


@dataclass(frozen=True)
class OutputFiles:
    """Where a bake goes; `preview` is None if none is wanted.

    `images` are the plain layout's atlas and its layers, or all that the shared layout can have, condensed or
    not. The preview is the bake's own but where parts have one in common.
    """

    images: tuple[Path, ...]
    sidecar: Path
    preview: Path | None
    preview_is_own: bool = True

    @classmethod
    def of(cls, object_name: str, spec: BakeSpec, folder: Path, preview: bool) -> OutputFiles:
        """The names of the contract, DESIGN.md section 3, below `folder`; a frame's have its number.

        Parts have a preview in common, which shows all that there are.
        """
        if spec.frame is not None:
            object_name = f"{object_name}-{spec.frame:04d}"
        if spec.lights:
            object_name = f"{object_name}-{'+'.join(spec.lights)}"
        atlas, sidecar = (
            folder / file_name(object_name, spec.kind, ending, part=spec.part) for ending in ("exr", "json")
        )
        images: tuple[Path, ...] = (atlas, *(layer_path(sidecar, layer) for layer in spec.layers))
        if spec.layout is Layout.SHARED:
            images = (
                *(layer_path(sidecar, layer) for layer in layer_names(Axis)),
                *(texture_path(sidecar, layer) for layer in layer_names(Axis, condensed=True)),
            )
        shown = folder / file_name(object_name, "preview", "blend", part=spec.split)
        return cls(images, sidecar, shown if preview else None, spec.split is None)

    @property
    def unfinished(self) -> Path:
        """The folder where finished pieces lie while the bake is not: `<name>.<kind>.radtex-unfinished`."""
        return self.sidecar.with_suffix(".radtex-unfinished")

    def export(self, target: str) -> Path:
        """The folder of an export of this bake for `target`, unless another is given: `<name>.<target>`."""
        return self.sidecar.with_suffix("").with_suffix(f".{target}")

    @property
    def atlas(self) -> Path:
        """The plain layout's image; the shared layout's first."""
        return self.images[0]

    @property
    def own(self) -> tuple[Path, ...]:
        """All that no other bake writes, too."""
        return self.all if self.preview_is_own else (*self.images, self.sidecar)

    @property
    def all(self) -> tuple[Path, ...]:
        return (*self.images, self.sidecar, *((self.preview,) if self.preview else ()))


def facts_of(
    name: str,
    spec: BakeSpec,
    width: int,
    height: int,
    uv_layer: str,
    mesh: str = "",
    source: Source | None = None,
    part: Part | None = None,
) -> Sidecar:
    """What the sidecar says of a bake called `name`, `width` x `height` texels large."""
    return Sidecar(
        object_name=name,
        kind=spec.kind,
        width=width,
        height=height,
        bucket=spec.bucket,
        uv_map=uv_layer,
        samples=spec.samples,
        seed=spec.seed,
        capture=spec.capture,
        tool=f"RadTex {VERSION}",
        blender=bpy.app.version_string,
        mesh=mesh,
        source=source,
        frame=spec.frame,
        lights=spec.lights,
        objects=spec.objects,
        part=part,
    )
