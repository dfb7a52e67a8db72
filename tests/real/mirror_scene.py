# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A baked stage under a sky, and Cycles' pictures of it with a chrome ball at places along its way.

    python -m tests.real.mirror_scene layered FOLDER        bakes and renders it; or: plain FOLDER

The camera alone sees the ball, so that it neither darkens the stage nor shows in it.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
from PIL import Image

from radtex_addon.core.sampler import Filter
from radtex_addon.job import bake_object
from radtex_addon.report.gbuffer import Array, eroded
from radtex_addon.report.metrics import Mask, Picture, display
from radtex_addon.scene.nodes import open_world
from radtex_addon.settings.spec import BakeSpec
from tests.bench.gallery import looking
from tests.bench.gallery.looking import PIXELS, Place, added, empty_scene, principled, rendered, tiles
from tests.real.exhibit import FIGURES, ROOT, Bake, Camera, Form, small_unless_kept

NAME = "Stage"
CAMERA = Camera("above", (1.9, -2.6, 1.5), target=(0.0, 0.1, 0.35), fovy=46.0, pixels=PIXELS)
PLACES: tuple[Place, ...] = ((-0.45, -0.35, 0.5), (0.05, -0.45, 0.55), (0.6, -0.2, 0.75))
RADIUS = 0.3
CHROME = (0.9, 0.92, 0.95)  # seen straight on
SKY = (0.45, 0.55, 0.7)  # of the plain bake
TEXELS, SAMPLES = (128, 32) if FIGURES else (96, 16)
LEAST = 28.0  # decibels in the ball


@dataclass(frozen=True, eq=False)
class Stage:
    """A bake of the stage, and `pictures` (places, PIXELS, PIXELS, 3) by Cycles."""

    bake: Bake
    pictures: Array

    @classmethod
    def made(cls, form: Form, folder: Path) -> Stage:
        """Bake and render it in a process of its own."""
        command = [sys.executable, "-m", "tests.real.mirror_scene", form, str(folder)]
        ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=1200)
        assert ended.returncode == 0, ended.stderr
        return cls.read(folder)

    @classmethod
    def read(cls, folder: Path) -> Stage:
        return cls(Bake(folder), np.load(folder / "pictures.npy"))

    @cached_property
    def inside(self) -> tuple[Mask, ...]:
        """Pixels that show the ball alone, but for its outermost ones."""
        return tuple(eroded(silhouette(place)) for place in PLACES)

    def reference(self, number: int) -> Picture:
        picture: Picture = self.pictures[number]
        return picture


def keep_row(name: str, truth: Sequence[Picture], ours: Sequence[Picture]) -> None:
    """Save pictures, path traced above ours, if somebody asked for them."""
    if FIGURES:
        rows = [np.concatenate([display(picture) for picture in row], axis=1) for row in (truth, ours)]
        image = Image.fromarray((np.concatenate(rows) * 255 + 0.5).astype(np.uint8))
        image.quantize(128, dither=Image.Dither.NONE).save(Path(FIGURES, f"{name}.png"), optimize=True)


def silhouette(place: Place) -> Mask:
    """Pixels that the ball fills at a place, where nothing is before it."""
    rays = CAMERA.rays
    away = np.array(CAMERA.place) - np.array(place)
    along = rays.away @ away
    hit: Mask = (along**2 - (away @ away - RADIUS**2) > 0).reshape(PIXELS, PIXELS)
    return hit


def stage(form: Form) -> Any:
    """The stage, one object of four materials, and its sky, of one colour if plain; returns the scene."""
    scene = empty_scene(SKY)
    if form is Form.LAYERED:
        scene.world = gradient()
    scene.cycles.max_bounces = 3
    floor = added("plane", "Floor", tiles(2.5, 0.8), size=2.4)
    box = added("cube", "Box", principled("Red", (0.75, 0.12, 0.08), Roughness=0.8), size=0.5)
    box.location, box.rotation_euler = (-0.7, 0.6, 0.25), (0, 0, 0.5)
    ring = added(
        "torus", "Ring", principled("Green", (0.1, 0.5, 0.2), Roughness=0.7),
        major_radius=0.35, minor_radius=0.13, major_segments=32, minor_segments=12,
    )  # fmt: skip
    ring.location, ring.rotation_euler = (0.25, 0.75, 0.47), (1.3, 0.2, 0.5)
    column = added("cylinder", "Column", principled("Ivory", (0.8, 0.75, 0.6), Roughness=0.9), radius=0.16)
    column.location, column.scale = (0.95, 0.55, 0.45), (1, 1, 0.45)
    for item in (box, ring, column, floor):
        item.select_set(True)
    floor.name = NAME
    cast(Any, bpy.context).view_layer.objects.active = floor
    bpy.ops.object.join()
    return scene


def gradient() -> bpy.types.World:
    """A sky that is warm at the horizon and blue above."""
    world, build = open_world("Gradient")
    upwards = build.node("ShaderNodeSeparateXYZ", build.node("ShaderNodeTexCoord").outputs["Generated"])
    sky = build.node("ShaderNodeValToRGB", upwards.outputs["Z"])
    ramp = cast(Any, sky).color_ramp.elements
    ramp[0].color, ramp[1].color = (0.9, 0.75, 0.6, 1), (0.15, 0.3, 0.7, 1)
    build.node("ShaderNodeOutputWorld", build.node("ShaderNodeBackground", sky.outputs[0]).outputs[0])
    return world


def bake_stage(form: Form, folder: Path) -> None:
    """Bake the stage in one form, with its preview; it is the open scene then."""
    scene = stage(form)
    samples = 4 if form is Form.LAYERED else 8
    layout = {"layout": form.spec.layout} if form is Form.LAYERED else {"bucket": 8}
    spec = BakeSpec(texels=TEXELS, samples=samples, **layout)
    bake_object(scene, NAME, spec, folder, preview=Filter.QUADRILINEAR, overwrite=True)


def main(form: Form, folder: Path) -> None:
    """Bake the stage in one form, with its preview, and render it with the ball."""
    small_unless_kept()
    bake_stage(form, folder)
    chrome = principled("Chrome", CHROME, Metallic=1.0, Roughness=0.0)
    ball = added("uv_sphere", "Ball", chrome, segments=128, ring_count=64, radius=RADIUS)
    ball.visible_diffuse = ball.visible_glossy = ball.visible_shadow = False
    seen = looking.Camera(CAMERA.place, CAMERA.target, lens=18 / np.tan(np.radians(CAMERA.fovy) / 2))
    pictures = []
    for place in PLACES:
        ball.location = place
        pictures.append(rendered(seen, SAMPLES)[..., :3])
    np.save(folder / "pictures.npy", np.stack(pictures))


if __name__ == "__main__":
    main(Form(sys.argv[1]), Path(sys.argv[2]))
