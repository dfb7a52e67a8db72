# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The result of a bake of any form, and its JSON for the key of an unfinished bake."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from ..core.atlas import AtlasLayout
from ..core.errors import InputError, ShapeError
from ..core.messages import Setting, do
from ..formats.sidecar import TexelDensity
from ..formats.sidecar_file import read_facts
from ..forms.outcome import Outcome
from .output_files import OutputFiles


@dataclass(frozen=True)
class BakeOutput:
    """The result of a bake: its `files` on disk, and what it cost.

    `density` is the texels per metre that it has, if its size follows from a density.
    """

    files: OutputFiles
    layout: AtlasLayout
    covered_texels: int
    paths: int
    clamped: int
    device: str = ""
    islands: int | None = None
    density: float | None = None

    @classmethod
    def by(
        cls,
        outcome: Outcome,
        files: OutputFiles,
        device: str,
        islands: int | None,
        density: TexelDensity | None,
    ) -> BakeOutput:
        """From a form's `outcome`, which says which of the images in `files` were written."""
        return cls(
            files=replace(files, images=outcome.images),
            layout=outcome.layout,
            covered_texels=outcome.covered_texels,
            paths=outcome.paths,
            clamped=outcome.clamped,
            device=device,
            islands=islands,
            density=None if density is None else density.reached,
        )

    @property
    def outcome(self) -> Outcome:
        """The result of the form's bake alone."""
        return Outcome(
            images=self.files.images,
            layout=self.layout,
            covered_texels=self.covered_texels,
            paths=self.paths,
            clamped=self.clamped,
        )

    def told(self, earlier: Collection[Path] = ()) -> dict[str, Any]:
        """The result as JSON values: of `files` and the `earlier` bake's images only the names."""
        return {
            "replaced": sorted(path.name for path in earlier),
            "images": [path.name for path in self.files.images],
            "layout": asdict(self.layout),
            "covered_texels": self.covered_texels,
            "paths": self.paths,
            "clamped": self.clamped,
            "device": self.device,
            "islands": self.islands,
            "density": self.density,
        }

    @staticmethod
    def replaced(told: Mapping[str, Any], files: OutputFiles) -> frozenset[Path]:
        """The earlier bake's images in `told`, to be deleted once this bake's files have their final names.

        Names that no image of this bake could have are ignored.
        """
        names = told.get("replaced")
        stem = f"{files.sidecar.stem}."
        return frozenset(
            files.sidecar.with_name(name)
            for name in (names if isinstance(names, list) else ())
            if isinstance(name, str) and name.startswith(stem) and not {"/", "\\", "\0"} & set(name)
        )

    @classmethod
    def of(cls, told: Mapping[str, Any], files: OutputFiles) -> BakeOutput:
        """Inverse of `told`, for a bake with these `files`. Raises InputError for malformed values."""
        try:
            layout = told["layout"]
            return cls(
                files=replace(files, images=tuple(files.sidecar.with_name(name) for name in told["images"])),
                layout=AtlasLayout(int(layout["width"]), int(layout["height"]), int(layout["bucket"])),
                covered_texels=int(told["covered_texels"]),
                paths=int(told["paths"]),
                clamped=int(told["clamped"]),
                device=str(told["device"]),
                islands=None if told["islands"] is None else int(told["islands"]),
                density=None if told.get("density") is None else float(told["density"]),
            )
        except (IndexError, KeyError, TypeError, ValueError, ShapeError) as error:
            raise InputError(
                f"{files.unfinished} is damaged",
                do("begin anew", Setting.OVERWRITE, without=(Setting.RESUME,)),
            ) from error

    @classmethod
    def known(cls, files: OutputFiles) -> BakeOutput:
        """The result of a bake that was finished earlier, by its sidecar; paths and covered texels are 0.

        Raises FormatError as `read_facts` does.
        """
        facts = read_facts(files.sidecar)
        images = tuple(path for path in files.images if path.is_file())
        layout = AtlasLayout(*facts.size("texels"), facts.whole_number("bucket", 1))
        return cls(replace(files, images=images), layout, 0, 0, facts.whole_number("clamped", 0))
