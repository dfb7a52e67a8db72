# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A saved preview as Cycles or Eevee shows it to some cameras, one ray through each pixel's middle.

    python -m tests.real.preview_shot PREVIEW.blend OBJECT cycles FOLDER 1     writes FOLDER/front.exr …

The cameras are those of FOLDER/cameras.json; 1 is Eevee's samples.
In a process of its own, for it opens the .blend; the object stands alone before black.
"""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from radtex_addon.formats.containers.exr import read_render
from radtex_addon.report.metrics import Picture
from radtex_addon.scene.demo import OBJECT
from tests.blender.lookup_stage import set_up_render
from tests.real.exhibit import ROOT, Camera

EEVEE = "BLENDER_EEVEE" if bpy.app.version >= (5, 0) else "BLENDER_EEVEE_NEXT"
_CAMERAS = "cameras.json"
ENGINES = {"cycles": "CYCLES", "eevee": EEVEE}


@dataclass(frozen=True)
class Shots:
    """Pictures of a preview's object `name` by `engine`, rendered when they are asked for; "" is all of them.

    Eevee dithers what one sees through, so that it needs more than one of its `samples` there.
    """

    preview: Path
    engine: str
    folder: Path
    name: str = OBJECT
    samples: int = 1

    def pictures(self, cameras: tuple[Camera, ...]) -> list[Picture]:
        """Linear light (H, W, 3) for each camera, rows from the top."""
        return [picture[..., :3] for picture in self.layers(cameras)]

    def layers(self, cameras: tuple[Camera, ...]) -> list[Picture]:
        """The same with alpha, (H, W, 4), premultiplied."""
        self.folder.mkdir(parents=True, exist_ok=True)
        described = json.dumps([asdict(camera) for camera in cameras])
        (self.folder / _CAMERAS).write_text(described, encoding="utf-8")
        command = [sys.executable, "-m", "tests.real.preview_shot"]
        command += map(str, (self.preview, self.name, self.engine, self.folder, self.samples))
        ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=1200)
        assert ended.returncode == 0, ended.stderr
        return [self._read(camera.name) for camera in cameras]

    def _read(self, name: str) -> Picture:
        (image,) = read_render(self.folder / f"{name}.exr").values()
        picture: Picture = image[::-1].astype(np.float64)
        return picture


def main(preview: str, name: str, engine: str, folder: str, samples: str) -> None:
    """Open the preview and render the object alone."""
    bpy.ops.wm.open_mainfile(filepath=preview, load_ui=False, use_scripts=False)
    scene: Any = bpy.context.scene
    _stand_alone(scene, name)
    set_up_render(scene, ENGINES[engine])
    scene.eevee.taa_render_samples = int(samples)
    scene.render.resolution_percentage = 100
    for described in json.loads(Path(folder, _CAMERAS).read_text(encoding="utf-8")):
        camera = Camera(**described)
        scene.camera = _placed(scene, camera)
        scene.render.resolution_x = scene.render.resolution_y = camera.pixels
        scene.render.filepath = str(Path(folder, f"{camera.name}.exr"))
        bpy.ops.render.render(write_still=True)


def _stand_alone(scene: Any, name: str) -> None:
    for item in scene.objects:
        item.hide_render = name not in (item.name, "")
    scene.world = bpy.data.worlds.new("Black")
    scene.world.color = (0, 0, 0)
    if scene.world.node_tree is not None:
        scene.world.node_tree.nodes.clear()


def _placed(scene: Any, camera: Camera) -> Any:
    data = bpy.data.cameras.new(camera.name)
    data.sensor_fit, data.angle = "HORIZONTAL", np.radians(camera.fovy)
    data.clip_start = 1e-3  # of close-ups
    item = bpy.data.objects.new(camera.name, data)
    item.matrix_world = camera.matrix
    scene.collection.objects.link(item)
    return item


if __name__ == "__main__":
    main(*sys.argv[1:])
