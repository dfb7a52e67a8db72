# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Write the files beside a farm's .blend: templates for OpenJD and Flamenco, and a runner for bpy."""

from __future__ import annotations

from pathlib import Path

from ..core.quoting import in_comment, yaml_string
from .farm_files import FarmFiles
from .farm_manifest import FarmManifest

_FOLDER = Path(__file__).parent / "templates"
OPENJD, FLAMENCO = "openjd.yaml", "radtex_farm.js"
_NAME_MOST = 100  # OpenJD's limit is 128


def write_templates(files: FarmFiles, manifest: FarmManifest) -> None:
    """Write the templates into the farm's folder, with the farm's frame numbers."""
    name = yaml_string(in_comment(f"RadTex {manifest.name[:_NAME_MOST]} {manifest.spec.kind}"))
    frames = f"1-{manifest.sheets}" if manifest.sheets > 1 else "1"
    for source in (OPENJD, FLAMENCO, files.runner.name):
        text = (_FOLDER / source).read_text(encoding="utf-8")
        text = text.replace("@NAME@", name).replace("@FRAMES@", frames)
        (files.folder / source).write_text(text, encoding="utf-8", newline="\n")
