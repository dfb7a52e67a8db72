# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What every layout's bake hands back, and how the key of an unfinished one tells it."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from ..core.atlas import AtlasLayout
from ..core.errors import InputError, ShapeError
from ..formats.sidecar import read_facts
from ..forms.outcome import Condensed, Outcome
from .files import OutputFiles


@dataclass(frozen=True)
class BakeOutput:
    """An atlas on disk: the `files` that there are, what it took, and how it was `condensed`, if it was."""

    files: OutputFiles
    layout: AtlasLayout
    covered_texels: int
    paths: int
    clamped: int
    fireflies: float = 0.0
    condensed: Condensed | None = None
    device: str = ""
    islands: int | None = None

    @classmethod
    def by(cls, outcome: Outcome, files: OutputFiles, device: str, islands: int | None) -> BakeOutput:
        """What a form's bake came to, of whose `files` it has written some images."""
        return cls(
            files=replace(files, images=outcome.images),
            layout=outcome.layout,
            covered_texels=outcome.covered_texels,
            paths=outcome.paths,
            clamped=outcome.clamped,
            fireflies=outcome.fireflies,
            condensed=outcome.condensed,
            device=device,
            islands=islands,
        )

    @property
    def outcome(self) -> Outcome:
        """What the form's bake came to."""
        return Outcome(
            images=self.files.images,
            layout=self.layout,
            covered_texels=self.covered_texels,
            paths=self.paths,
            clamped=self.clamped,
            fireflies=self.fireflies,
            condensed=self.condensed,
        )

    def told(self, earlier: Collection[Path] = ()) -> dict[str, Any]:
        """All of it as JSON takes it, of the files the images' names; and of the `earlier` bake's images."""
        return {
            "replaced": sorted(path.name for path in earlier),
            "images": [path.name for path in self.files.images],
            "layout": asdict(self.layout),
            "covered_texels": self.covered_texels,
            "paths": self.paths,
            "clamped": self.clamped,
            "fireflies": self.fireflies,
            "condensed": None if self.condensed is None else asdict(self.condensed),
            "device": self.device,
            "islands": self.islands,
        }

    @staticmethod
    def replaced(told: Mapping[str, Any], files: OutputFiles) -> frozenset[Path]:
        """The earlier bake's images, which go when this one has its places; foreign names are left out."""
        names = told.get("replaced")
        stem = f"{files.sidecar.stem}."
        return frozenset(
            files.sidecar.with_name(name)
            for name in (names if isinstance(names, list) else ())
            if isinstance(name, str) and name.startswith(stem) and not {"/", "\\", "\0"} & set(name)
        )

    @classmethod
    def of(cls, told: Mapping[str, Any], files: OutputFiles) -> BakeOutput:
        """What was `told` of a bake that has some of these `files`.

        Raises InputError for what `told` did not write.
        """
        try:
            condensed, layout = told["condensed"], told["layout"]
            return cls(
                files=replace(files, images=tuple(files.sidecar.with_name(name) for name in told["images"])),
                layout=AtlasLayout(int(layout["width"]), int(layout["height"]), int(layout["bucket"])),
                covered_texels=int(told["covered_texels"]),
                paths=int(told["paths"]),
                clamped=int(told["clamped"]),
                fireflies=float(told["fireflies"]),
                condensed=None if condensed is None else _condensed(condensed),
                device=str(told["device"]),
                islands=None if told["islands"] is None else int(told["islands"]),
            )
        except (IndexError, KeyError, TypeError, ValueError, ShapeError) as error:
            raise InputError(
                f"{files.unfinished} is damaged: begin anew (--overwrite, without --resume)"
            ) from error

    @classmethod
    def known(cls, files: OutputFiles) -> BakeOutput:
        """Of a bake that was finished some time ago: its sidecar tells of no paths and covered texels.

        Raises FormatError as `read_facts` does.
        """
        facts = read_facts(files.sidecar)
        images = tuple(path for path in files.images if path.is_file())
        layout = AtlasLayout(*facts.size("texels"), facts.whole_number("bucket", 1))
        lost = facts.positive("fireflies") if "fireflies" in facts.values else 0.0
        return cls(replace(files, images=images), layout, 0, 0, facts.whole_number("clamped", 0), lost)


def _condensed(told: Mapping[str, Any]) -> Condensed:
    return Condensed(
        clusters=tuple(int(count) for count in told["clusters"]),
        colour=(int(told["colour"][0]), int(told["colour"][1])),
        surroundings=int(told["surroundings"]),
        bytes=int(told["bytes"]),
        agreement=float(told["agreement"]),
    )
