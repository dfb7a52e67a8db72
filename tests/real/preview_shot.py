# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A saved preview as Cycles or Eevee shows it to the exhibit's cameras, one ray through each pixel's middle.

    python -m tests.real.preview_shot PREVIEW.blend cycles FOLDER front left     writes FOLDER/front.exr …

In a process of its own, for it opens the .blend; the object stands alone before black.
"""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from radtex_addon.formats.containers.exr import read_render
from radtex_addon.report.metrics import Picture
from radtex_addon.scene.demo import OBJECT
from tests.blender.lookup_stage import set_up_render
from tests.real.exhibit import CAMERAS, ROOT, Camera

EEVEE = "BLENDER_EEVEE" if bpy.app.version >= (5, 0) else "BLENDER_EEVEE_NEXT"
ENGINES = {"cycles": "CYCLES", "eevee": EEVEE}


@dataclass(frozen=True)
class Shots:
    """Pictures of a preview by `engine`, one for each camera; they are rendered when they are asked for."""

    preview: Path
    engine: str
    folder: Path

    def pictures(self, cameras: tuple[Camera, ...]) -> list[Picture]:
        """Linear light (H, W, 3), rows from the top."""
        self.folder.mkdir(parents=True, exist_ok=True)
        names = [camera.name for camera in cameras]
        command = [sys.executable, "-m", "tests.real.preview_shot", self.preview, self.engine, self.folder]
        ended = subprocess.run(
            [*map(str, command), *names], cwd=ROOT, capture_output=True, text=True, check=False, timeout=1200
        )
        assert ended.returncode == 0, ended.stderr
        return [self._read(name) for name in names]

    def _read(self, name: str) -> Picture:
        (image,) = read_render(self.folder / f"{name}.exr").values()
        picture: Picture = image[::-1, :, :3].astype(np.float64)
        return picture


def main(preview: str, engine: str, folder: str, names: list[str]) -> None:
    """Open the preview and render it."""
    bpy.ops.wm.open_mainfile(filepath=preview, load_ui=False, use_scripts=False)
    scene: Any = bpy.context.scene
    _stand_alone(scene)
    set_up_render(scene, ENGINES[engine])
    scene.render.resolution_percentage = 100
    for camera in CAMERAS:
        if camera.name in names:
            scene.camera = _placed(scene, camera)
            scene.render.resolution_x = scene.render.resolution_y = camera.pixels
            scene.render.filepath = str(Path(folder, f"{camera.name}.exr"))
            bpy.ops.render.render(write_still=True)


def _stand_alone(scene: Any) -> None:
    for item in scene.objects:
        item.hide_render = item.name != OBJECT
    scene.world = bpy.data.worlds.new("Black")
    scene.world.color = (0, 0, 0)
    if scene.world.node_tree is not None:
        scene.world.node_tree.nodes.clear()


def _placed(scene: Any, camera: Camera) -> Any:
    data = bpy.data.cameras.new(camera.name)
    data.sensor_fit, data.angle = "HORIZONTAL", np.radians(camera.fovy)
    item = bpy.data.objects.new(camera.name, data)
    item.matrix_world = camera.matrix
    scene.collection.objects.link(item)
    return item


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], sys.argv[3], sys.argv[4:])
