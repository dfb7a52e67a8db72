# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Projects for Godot: a moving mirror, or shadows on and under a bake; and pictures of them as they run.

    python -m tests.real.godot_demo PROJECT                      # bakes a stage and writes the project
    python -m tests.real.godot_demo PROJECT --pictures FOLDER    # and twelve pictures of the ball's way round
    python -m tests.real.godot_demo PROJECT --shadows --pictures FOLDER   # a head: a picture by each renderer

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
from tests.real.exhibit import Exhibit, Form
from tests.real.godot import ALL_RENDERERS, imported, run_godot
from tests.real.mirror_scene import bake_stage
from tests.real.root import PROGRAMS, Root, ready_root

FRAMES = 12  # one a second: mirror.gd's ball goes round in twelve
SHADOWS = Path(__file__).parent / "inside" / "godot" / "shadows.tscn"
_BLACK = 8  # of 255: what the background is at most


def write_project(project: Path, form: Form = Form.LAYERED) -> None:
    """Bake the stage, and export it with its mirror. Raises InputError where `project` is another folder."""
    with tempfile.TemporaryDirectory() as folder:
        bake_stage(form, Path(folder))
        spec = ExportSpec(Target.GODOT, mirror=True)
        deque(export_steps(find_bake(Path(folder), None).path, spec, project, overwrite=True), maxlen=0)


def write_shadows(sidecar: Path, project: Path) -> None:
    """Export the exhibit's head into a project whose scene has a sun, a floor, and a ball before the sun."""
    deque(export_steps(sidecar, ExportSpec(Target.GODOT), project, overwrite=True), maxlen=0)
    (mesh,) = project.glob("*.glb")
    scene = SHADOWS.read_text(encoding="utf-8").replace("Suzanne.glb", mesh.name)
    (project / "main.tscn").write_text(scene, encoding="utf-8")


def pictures_of_shadows(root: Root, project: Path, folder: Path) -> list[Path]:
    """A picture of that scene by each renderer, in `folder`."""
    place, inside = imported(root, project)
    folder.mkdir(parents=True, exist_ok=True)
    found: list[Path] = []
    for renderer, arguments in ALL_RENDERERS.items():
        frames = place / f"frames-{len(found)}"
        frames.mkdir()
        movie = [
            "--write-movie",
            f"{inside}/{frames.name}/frame.png",
            "--fixed-fps",
            "1",
            "--quit-after",
            "3",
        ]
        run_godot(root, ["--path", inside, *arguments, "--resolution", "640x480", *movie], timeout=600)
        found.append(folder / f"{renderer.removesuffix('+').lower()}.png")
        shutil.copy(max(frames.glob("*.png")), found[-1])
    return found


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
    parser.add_argument("--shadows", action="store_true", help="of a head on a floor, without a mirror")
    given = parser.parse_args()
    if given.shadows:
        with tempfile.TemporaryDirectory() as folder:
            write_shadows(Exhibit(Path(folder)).plain.sidecar, given.project)
    else:
        write_project(given.project)
    if given.pictures:
        path, _ = ready_root(PROGRAMS)
        with tempfile.TemporaryDirectory() as shared:
            root = Root(path, Path(shared))
            if given.shadows:
                taken = pictures_of_shadows(root, given.project, given.pictures)
            else:
                taken = run_of(root, given.project, given.renderer, given.pictures)
            root.end_servers()
        side_by_side(taken, given.pictures / "strip.png")


if __name__ == "__main__":
    main()
