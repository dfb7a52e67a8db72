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
    """The paths of a bake's files; `preview` is None if none is wanted.

    `images` are all images that a bake of the specification's form can write. `preview_is_own` is False if
    the parts of an object share one preview.
    """

    images: tuple[Path, ...]
    sidecar: Path
    preview: Path | None
    preview_is_own: bool = True

    @classmethod
    def of(cls, object_name: str, spec: BakeSpec, folder: Path, preview: bool) -> OutputFiles:
        """The files of a bake in `folder`, named as in docs/format.md, plus its frame and lamps.

        All parts of an object share one preview.
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
        """The folder of the checkpoint while the bake is unfinished: `<name>.<kind>.radtex-unfinished`."""
        return self.sidecar.with_suffix(".radtex-unfinished")

    def export(self, target: str) -> Path:
        """The default folder of this bake's export for `target`: `<name>.<target>`."""
        return self.sidecar.with_suffix("").with_suffix(f".{target}")

    @property
    def atlas(self) -> Path:
        """The image of the plain layout, or the first one of the layered layout."""
        return self.images[0]

    @property
    def own(self) -> tuple[Path, ...]:
        """The files that only this bake writes: all, except for a preview that parts share."""
        return self.all if self.preview_is_own else (*self.images, self.sidecar)

    @property
    def all(self) -> tuple[Path, ...]:
        return (*self.images, self.sidecar, *((self.preview,) if self.preview else ()))
