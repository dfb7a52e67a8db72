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
from ..formats.sidecar import Sidecar
from ..formats.sidecar_file import read_facts
from ..forms.outcome import Outcome
from .output_files import OutputFiles


@dataclass(frozen=True)
class BakeOutput:
    """The result of a bake: its `files` on disk, and what it cost.

    Its UV layer has so many `islands`, which cover a share of it, the `coverage`; `wasteful` says why the map
    wastes its atlas, empty if it does not. `density` is the texels per metre that it has, if its size follows
    from a density.
    """

    files: OutputFiles
    layout: AtlasLayout
    covered_texels: int
    paths: int
    clamped: int
    device: str = ""
    islands: int | None = None
    density: float | None = None
    coverage: float | None = None
    wasteful: str = ""

    @classmethod
    def by(cls, outcome: Outcome, files: OutputFiles, device: str, facts: Sidecar) -> BakeOutput:
        """From a form's `outcome`, which says which of the images in `files` were written."""
        density = facts.texel_density
        return cls(
            files=replace(files, images=outcome.images),
            layout=outcome.layout,
            covered_texels=outcome.covered_texels,
            paths=outcome.paths,
            clamped=outcome.clamped,
            device=device,
            islands=facts.islands,
            density=None if density is None else density.reached,
            coverage=facts.coverage,
            wasteful=facts.wasteful,
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
            "coverage": self.coverage,
            "wasteful": self.wasteful,
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
                coverage=None if told.get("coverage") is None else float(told["coverage"]),
                wasteful=str(told.get("wasteful", "")),
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
        return cls(
            files=replace(files, images=images),
            layout=layout,
            covered_texels=0,
            paths=0,
            clamped=facts.whole_number("clamped", 0),
            islands=facts.whole_number("islands", 0) if "islands" in facts.values else None,
            coverage=facts.number("coverage") if "coverage" in facts.values else None,
            wasteful=facts.text("wasteful") if "wasteful" in facts.values else "",
        )
