# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings made into what the library takes: checked, and no longer Blender's."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import bpy

from ..bake.spec import BakeSpec, Compression, Layer, Layout, parse_kind, parse_layout
from ..core.errors import InputError
from ..export.spec import Target
from ..scene.enclosed import EVERYTHING
from .choices import ACCUMULATED, BUCKETS_ONLY, LAYERED, SOURCED
from .preferences import preferred
from .settings import NAMES, BakeSettings

if TYPE_CHECKING:
    from ..job.foresight import Foresight

_MEGABYTE = 1e6


@dataclass(frozen=True)
class BakeRequest:
    """A bake as it was asked for: what, how, and where to."""

    spec: BakeSpec
    folder: Path
    preview: bool
    overwrite: bool
    resume: bool
    targets: tuple[Target, ...]

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> BakeRequest:
        """What `values`, by the names of the settings, ask for. Raises InputError for what cannot be."""
        spec = spec_of(values)
        targets = tuple(target for target in Target if target.value in values["export_targets"])
        if targets and not values["preview"]:
            raise InputError("an export is made from the preview: switch Preview on, or the export off")
        return cls(
            spec=spec,
            folder=output_folder(values["directory"], preferred().output),
            preview=values["preview"],
            overwrite=values["overwrite"],
            resume=values["resume"],
            targets=targets,
        )

    def foreseen(self, scene: bpy.types.Scene, names: Iterable[str], patience: float) -> Foresight:
        """What can be said of baking these objects beforehand; `patience` is in seconds."""
        from ..job.foresight import foresee

        return foresee(
            scene,
            names,
            self.spec,
            self.folder,
            preview=self.preview,
            overwrite=self.overwrite,
            resume=self.resume,
            targets=self.targets,
            patience=patience,
        )

    def remedies(self, scene: bpy.types.Scene, names: Sequence[str], patience: float) -> dict[str, int]:
        """Settings that, switched, would leave fewer errors than are foreseen now, and how many."""
        present = self._errors_with((), scene, names, patience)
        for ways in ((("overwrite",), ("resume",)), (("overwrite", "resume"),)):
            left = {way: self._errors_with(way, scene, names, patience) for way in ways}
            found = {name: count for way, count in left.items() for name in way if count < present}
            if found:
                return found
        return {}

    def forgets(self, scene: bpy.types.Scene, names: Sequence[str], patience: float) -> bool:
        """Whether it would throw away an unfinished bake that one could go on with."""
        from ..bake.checkpoint import is_unfinished
        from ..job.files import OutputFiles

        if self.resume or not self.overwrite:
            return False
        files = [OutputFiles.of(name, self.spec, self.folder, self.preview) for name in names]
        if not any(is_unfinished(one.unfinished) for one in files):
            return False
        return self._errors_with(("resume",), scene, names, patience) == 0

    def _errors_with(
        self, switched: Sequence[str], scene: bpy.types.Scene, names: Sequence[str], patience: float
    ) -> int:
        values: dict[str, Any] = {name: not getattr(self, name) for name in switched}
        return len(replace(self, **values).foreseen(scene, names, patience).errors)


def values_of(settings: BakeSettings) -> dict[str, Any]:
    """A scene's settings by name."""
    return {name: getattr(settings, name) for name in NAMES}


def values_with(settings: BakeSettings, arguments: BakeSettings, given: Iterable[str]) -> dict[str, Any]:
    """A scene's settings, but for the `arguments` that were `given`; a layout brings its cells."""
    named = set(given)
    values = values_of(settings) | {name: getattr(arguments, name) for name in NAMES if name in named}
    if "bucket" not in named and named & {"kind", "atlas_layout", "limit"}:
        values["bucket"] = suited_bucket(values["kind"], values["atlas_layout"], values["limit"])
    return values


def suited_bucket(kind: str, layout: str, limit: str) -> int:
    """Cells along a bucket's side where nobody says."""
    if kind in BUCKETS_ONLY:
        return BakeSpec(texels=1, kind=parse_kind(kind)).bucket
    chosen = parse_layout(layout)
    condensed = chosen is Layout.SHARED and limit != "none"
    return BakeSpec(texels=1, layout=chosen, target=40.0 if condensed else None).bucket


def output_folder(directory: str, instead: Path | None) -> Path:
    """The folder that `directory` names; `instead` is for files that were never saved.

    Raises InputError where there is none.
    """
    if directory.strip() and (bpy.data.filepath or not directory.startswith("//")):
        return Path(bpy.path.abspath(directory))
    if instead is not None:
        return instead
    if not directory.strip():
        raise InputError("no output folder is chosen: choose one")
    raise InputError("this file was never saved: save it, or choose a folder for its bakes")


def has_folder(values: Mapping[str, Any]) -> bool:
    """Whether bakes asked for by `values` have a place to go to."""
    try:
        output_folder(values["directory"], preferred().output)
    except InputError:
        return False
    return True


def spec_of(values: Mapping[str, Any]) -> BakeSpec:
    """What to bake, without where to. Raises InputError for what cannot be."""
    wishes = preferred()
    layout = Layout.BUCKETS if values["kind"] in BUCKETS_ONLY else parse_layout(values["atlas_layout"])
    plain = layout is Layout.BUCKETS
    lasting = plain and values["kind"] in ACCUMULATED
    layered = plain and values["kind"] in LAYERED
    sourced = layout is Layout.BUCKETS and values["kind"] in SOURCED and values["source"]
    limit = values["limit"] if layout is Layout.SHARED else "none"
    return BakeSpec(
        kind=values["kind"],
        layout=layout,
        texels=values["texels"],
        bucket=values["bucket"],
        samples=values["samples"],
        seed=values["seed"],
        uv_layer=values["uv_layer"] or None,
        unwrap=values["unwrap"],
        padding=values["padding"],
        device=wishes.device,
        memory_mb=wishes.memory_mb,
        budget=round(values["budget"] * _MEGABYTE) if limit == "budget" else None,
        target=values["target"] if limit == "target" else None,
        half=limit != "none" or values["kind"] == "shadow" or not values["full_floats"],
        compression=Compression.ZIP if limit != "none" else values["compression"],
        layers=tuple(layer for layer in Layer if layer.value in values["layers"]) if layered else (),
        accumulate=values["accumulate"] and lasting,
        refresh=values["refresh"] and lasting,
        content=_content_of(values) if values["kind"] == "proxy" else None,
        source=values["source"] if sourced else None,
        extrusion=values["extrusion"] or None if sourced else None,
    )


def _content_of(values: Mapping[str, Any]) -> str | None:
    if values["content"] == "all":
        return EVERYTHING
    if values["content"] == "inside":
        return None
    if not values["content_collection"]:
        raise InputError("which collection does the hull show? choose it below Content")
    name: str = values["content_collection"]
    return name
