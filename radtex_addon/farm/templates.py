# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Write the files beside a farm's .blend: templates for OpenJD and Flamenco, a Makefile, a runner for bpy."""

from __future__ import annotations

from pathlib import Path

from ..core.quoting import in_comment, yaml_string
from .farm_files import FarmFiles
from .farm_manifest import FarmManifest
from .tasks import TaskFarm

_FOLDER = Path(__file__).parent / "templates"
OPENJD, FLAMENCO, MAKEFILE = "openjd.yaml", "radtex_farm.js", "Makefile"
_NAME_MOST = 100  # OpenJD's limit is 128


def write_templates(files: FarmFiles, manifest: FarmManifest) -> None:
    """Write the templates into the farm's folder, with the farm's frame numbers."""
    name = yaml_string(in_comment(f"RadTex {manifest.name[:_NAME_MOST]} {manifest.spec.kind}"))
    frames = f"1-{manifest.sheets}" if manifest.sheets > 1 else "1"
    for source in (OPENJD, FLAMENCO, files.runner.name):
        text = (_FOLDER / source).read_text(encoding="utf-8")
        text = text.replace("@NAME@", name).replace("@FRAMES@", frames)
        (files.folder / source).write_text(text, encoding="utf-8", newline="\n")


def write_task_templates(farm: TaskFarm) -> None:
    """Write what does a farm's tasks, each after those that it needs, into its folder."""
    rules = [
        f"done/{task.name}.json: |{''.join(f' done/{need}.json' for need in task.needs)}\n"
        f"\t$(WORK) . {task.name}\n"
        for task in farm.tasks
    ]
    last = " ".join(f"done/{task.name}.json" for task in farm.tasks if task.is_last)
    text = (_FOLDER / MAKEFILE).read_text(encoding="utf-8")
    text = text.replace("@LAST@", last) + "\n" + "\n".join(rules)
    (farm.folder / MAKEFILE).write_text(text, encoding="utf-8", newline="\n")
