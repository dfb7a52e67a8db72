# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What an earlier export left in a folder: whether it is there, and whether it still shows the bake."""

from __future__ import annotations

from pathlib import Path

from ..core.errors import FormatError
from ..version import VERSION
from .export_manifest import EXTENSION, Manifest, read_manifest
from .exporting import ExportSource
from .folder import LIST, is_whole


def is_export(out: Path) -> bool:
    """Whether an earlier export wrote this folder."""
    return (out / LIST).is_file()


def current_manifest(bake: ExportSource, out: Path) -> Manifest | None:
    """The manifest of a whole export of this very bake by this version of RadTex; None if there is none."""
    manifest = earlier_manifest(bake, out)
    if manifest is None or not is_whole(out) or manifest.tool != f"RadTex {VERSION}":
        return None
    same = manifest.bake == bake.sidecar.facts.values
    return manifest if same and _modified(_path(bake, out)) >= _modified(bake.sidecar.path) else None


def earlier_manifest(bake: ExportSource, out: Path) -> Manifest | None:
    """The manifest of an export of any bake by this name; None if there is none."""
    try:
        return read_manifest(_path(bake, out)) if is_export(out) else None
    except FormatError:
        return None


def _path(bake: ExportSource, out: Path) -> Path:
    return out / f"{bake.name}.{EXTENSION}"


def _modified(path: Path) -> float:
    try:
        return path.stat().st_mtime
    except OSError:
        return 0.0
