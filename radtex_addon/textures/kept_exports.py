# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports that a .blend keeps, to be made again whenever their bakes are."""

from __future__ import annotations

import logging
import os
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy

from ..core.errors import RadTexError
from ..formats.json_reader import Facts, json_text
from .export_spec import ExportSpec, export_facts, export_spec_in

KEPT = "radtex_exports"  # the scene's property
_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class KeptExport:
    """An export of one bake, by its sidecar, or of several as the `scene` of that name, into `out`."""

    name: str
    sidecars: tuple[Path, ...]
    out: Path
    spec: ExportSpec
    scene: str | None = None

    @classmethod
    def of(cls, row: Any) -> KeptExport | None:
        """The export in a row of the scene's property, a mapping.

        None if its settings cannot be read, as those of a later version. A path that begins with `//` is
        relative to the open .blend.
        """
        name = row.get("name", "")
        try:
            facts = Facts.parse(row.get("spec", ""), f"the export of {name}", "settings of an export")
            spec = export_spec_in(facts)
        except RadTexError:
            return None
        sidecars = tuple(Path(bpy.path.abspath(line)) for line in row.get("sidecars", "").splitlines())
        out = Path(os.path.normpath(bpy.path.abspath(row.get("folder", ""))))
        return cls(name, sidecars, out, spec, row.get("scene_name") or None)

    def row(self) -> dict[str, str]:
        """The export as `of` reads it, with absolute paths."""
        return {
            "name": self.name,
            "sidecars": "\n".join(str(path.absolute()) for path in self.sidecars),
            "folder": str(self.out.absolute()),
            "scene_name": self.scene or "",
            "spec": json_text(export_facts(self.spec)),
        }

    @property
    def key(self) -> tuple[object, ...]:
        """Of each bake, and of each exported scene, one export is kept for each target."""
        bakes = tuple(map(real, self.sidecars)) if self.scene is None else ()
        return self.spec.target, self.scene, bakes

    def is_of(self, sidecars: Collection[Path]) -> bool:
        """Whether one of these bakes is in it; the paths are `real` ones."""
        return any(real(path) in sidecars for path in self.sidecars)


def real(path: Path | str) -> Path:
    """The path as it is compared with others: without links and `..`."""
    return Path(os.path.realpath(path))


def kept_exports(scene: bpy.types.Scene) -> tuple[KeptExport, ...]:
    """The exports that the scene keeps, whether RadTex is enabled in this Blender or not.

    Those whose settings cannot be read are warned of, and left out.
    """
    stored: Any = scene
    if bpy.app.version >= (5, 0, 0):  # it keeps properties of add-ons apart from the user's
        stored = stored.bl_system_properties_get()
    rows: Iterable[Any] = () if stored is None else stored.get(KEPT, ())
    found = [KeptExport.of(row) for row in rows]
    if lost := found.count(None):
        _log.warning("%d exports after each bake have settings of another version: export them again", lost)
    return tuple(each for each in found if each is not None)
