# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A project for Godot with a moving mirror, and pictures of it as it runs.

    python -m tests.real.godot_demo PROJECT                      # bakes a stage and writes the project
    python -m tests.real.godot_demo PROJECT --pictures FOLDER    # and twelve pictures of the ball's way round

The pictures come from Godot in the root of `tests.real.root`; `strip.png` has them side by side.
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
from collections import deque
from pathlib import Path

import numpy as np
from PIL import Image

from radtex_addon.export.exporting import export_steps
from radtex_addon.report.finished_bake import find_bake
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.real.exhibit import Form
from tests.real.godot import ALL_RENDERERS, imported, run_godot
from tests.real.mirror_scene import bake_stage
from tests.real.root import PROGRAMS, Root, ready_root

FRAMES = 12  # one a second: mirror.gd's ball goes round in twelve
_BLACK = 8  # of 255: what the background is at most


def write_project(project: Path, form: Form = Form.LAYERED) -> None:
    """Bake the stage, and export it with its mirror. Raises InputError where `project` is another folder."""
    with tempfile.TemporaryDirectory() as folder:
        bake_stage(form, Path(folder))
        spec = ExportSpec(Target.GODOT, mirror=True)
        deque(export_steps(find_bake(Path(folder), None).path, spec, project, overwrite=True), maxlen=0)


def run_of(root: Root, project: Path, renderer: str, folder: Path) -> list[Path]:
    """Pictures of a project as Godot runs it, one a second, in `folder`."""
    place, inside = imported(root, project)
    (place / "frames").mkdir()
    movie = [
        "--write-movie",
        f"{inside}/frames/frame.png",
        "--fixed-fps",
        "1",
        "--quit-after",
        f"{FRAMES + 1}",
    ]
    run_godot(root, ["--path", inside, *ALL_RENDERERS[renderer], *movie], timeout=600)
    taken = sorted((place / "frames").glob("*.png"))[-FRAMES:]
    folder.mkdir(parents=True, exist_ok=True)
    found = [folder / f"{number:02}.png" for number in range(len(taken))]
    for source, path in zip(taken, found, strict=True):
        shutil.copy(source, path)
    return found


def side_by_side(pictures: list[Path], path: Path) -> None:
    """Four pictures a row, in one, each cut to what is not black in any of them."""
    images = []
    for picture in pictures:
        with Image.open(picture) as image:
            images.append(np.asarray(image.convert("RGB")))
    shown = np.stack(images).max(axis=(0, 3)) > _BLACK
    (top, *_, bottom), (left, *_, right) = (
        np.flatnonzero(shown.any(axis=1)),
        np.flatnonzero(shown.any(axis=0)),
    )
    images = [np.pad(each[top : bottom + 1, left : right + 1], ((8, 8), (8, 8), (0, 0))) for each in images]
    rows = [np.concatenate(images[first : first + 4], axis=1) for first in range(0, len(images), 4)]
    whole = Image.fromarray(np.concatenate(rows))
    whole.quantize(192, dither=Image.Dither.NONE).save(path, optimize=True)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("project", type=Path)
    parser.add_argument("--pictures", type=Path)
    parser.add_argument("--renderer", choices=ALL_RENDERERS, default="Forward+")
    given = parser.parse_args()
    write_project(given.project)
    if given.pictures:
        path, _ = ready_root(PROGRAMS)
        with tempfile.TemporaryDirectory() as shared:
            taken = run_of(Root(path, Path(shared)), given.project, given.renderer, given.pictures)
        side_by_side(taken, given.pictures / "strip.png")


if __name__ == "__main__":
    main()
