# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The files that a bake writes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..bake.spec import BakeSpec
from ..formats.sidecar import file_name
from ..forms import form_for


@dataclass(frozen=True)
class OutputFiles:
    """Where a bake goes; `preview` is None if none is wanted.

    `images` are all that a bake in the specification's layout can write. The preview is the bake's own but
    where parts have one in common.
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
        sidecar = folder / file_name(object_name, spec.kind, "json", part=spec.part)
        images = form_for(spec).images(spec, sidecar)
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
