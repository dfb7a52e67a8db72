# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes, one of which moves in every way, and farms of them; nodes that know nothing of RadTex."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any, cast

import bpy
import OpenEXR

from radtex_addon.bake.progress import finished
from radtex_addon.core.sampler import Filter
from radtex_addon.farm.assemble_farm import Assembled, assemble_steps
from radtex_addon.farm.prepare_farm import Farm, prepare_steps
from radtex_addon.farm.run_task import task_steps
from radtex_addon.farm.tasks import TaskFarm
from radtex_addon.settings.spec import BakeSpec, Layout
from tests.blender import stage

BOX = "Box"
FRAME = 7  # the scene's
LAYERED = BakeSpec(layout=Layout.LAYERED, texels=12, samples=1, seed=3)
BALL, PLATE = "Ball", "Plate"


def build_moving_scene(folder: Path) -> bpy.types.Scene:
    """A box to bake among things that keyframes, a driver, a wave, cloth and an image sequence change."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    sky = next(node for node in stage.world((0.3, 0.4, 0.5)).node_tree.nodes if node.type == "BACKGROUND")
    sky.inputs["Strength"].driver_add("default_value").driver.expression = "frame / 5"
    bpy.ops.object.light_add(type="AREA", location=(1, 0.5, 2), rotation=(0.2, 0.4, 0))
    lamp = bpy.context.object.data
    lamp.driver_add("energy").driver.expression = "frame * 10"
    _wall(folder)
    bpy.ops.mesh.primitive_cube_add(size=1, location=(1.2, 0, 0))
    mover = bpy.context.object
    mover.name = "Mover"
    glossy = stage.material("glossy", "ShaderNodeBsdfAnisotropic", Roughness=0.1)
    mover.data.materials.append(glossy)
    rough = next(node for node in glossy.node_tree.nodes if "Roughness" in node.inputs).inputs["Roughness"]
    for frame, place, value in ((1, 1.0, 0.1), (20, 2.0, 0.6)):
        mover.location.x, rough.default_value = place, value
        mover.keyframe_insert("location", frame=frame)
        rough.keyframe_insert("default_value", frame=frame)
    moves: Any = mover.animation_data
    moves.nla_tracks.new().strips.new("moves", 1, moves.action)
    moves.action = None
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=8, y_subdivisions=8, size=1, location=(-1, 0, 1))
    bpy.context.object.name = "Cloth"
    bpy.context.object.modifiers.new("cloth", "CLOTH")
    bpy.ops.mesh.primitive_cube_add(size=1.2)
    box = bpy.context.object
    box.name = BOX
    box.modifiers.new("wave", "WAVE").height = 0.1
    box.data.materials.append(stage.material("box", "ShaderNodeBsdfAnisotropic", Roughness=0.3))
    scene: Any = bpy.context.scene
    scene.frame_set(FRAME)
    return cast(bpy.types.Scene, scene)


def _wall(folder: Path) -> None:
    """A plane that shows another picture at every frame."""
    for number in range(1, 10):
        picture: Any = bpy.data.images.new("picture", 2, 2)
        picture.pixels = [0.1 * number, 0.5, 1 - 0.1 * number, 1] * 4
        picture.filepath_raw, picture.file_format = str(folder / f"wall{number:02d}.png"), "PNG"
        picture.save()
        bpy.data.images.remove(picture)
    bpy.ops.mesh.primitive_plane_add(size=9, location=(0, 0, -1))
    wall = stage.material("wall", "ShaderNodeBsdfDiffuse")
    bpy.context.object.data.materials.append(wall)
    shown = wall.node_tree.nodes.new("ShaderNodeTexImage")
    shown.image = bpy.data.images.load(str(folder / "wall01.png"))
    shown.image.source = "SEQUENCE"
    shown.image_user.frame_duration, shown.image_user.use_auto_refresh = 9, True
    diffuse = next(node for node in wall.node_tree.nodes if node.type == "BSDF_DIFFUSE")
    wall.node_tree.links.new(shown.outputs["Color"], diffuse.inputs["Color"])


def build(folder: Path) -> bpy.types.Scene:
    """A glass ball above a plate with a picture, under lamps."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    stage.world((0.3, 0.4, 0.5))
    stage.lamps()
    bpy.ops.mesh.primitive_uv_sphere_add(segments=12, ring_count=8, radius=0.5, location=(0, 0, 0.8))
    bpy.context.object.name = BALL
    glass = stage.material("glass", "ShaderNodeBsdfGlass", Roughness=0.0)
    bpy.context.object.data.materials.append(glass)
    bpy.ops.mesh.primitive_cube_add(size=1)
    plate = bpy.context.object
    plate.name, plate.scale = PLATE, (1.5, 1.5, 0.1)
    picture: Any = bpy.data.images.new("picture", 4, 4)
    picture.pixels = [0.8, 0.5, 0.2, 1, 0.1, 0.4, 0.9, 1] * 8
    picture.filepath_raw, picture.file_format = str(folder / "picture.png"), "PNG"
    picture.save()
    shown = stage.material("painted", "ShaderNodeBsdfDiffuse")
    node = shown.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = picture
    diffuse = next(each for each in shown.node_tree.nodes if each.type == "BSDF_DIFFUSE")
    shown.node_tree.links.new(node.outputs["Color"], diffuse.inputs["Color"])
    plate.data.materials.append(shown)
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "things.blend"))
    return cast(bpy.types.Scene, bpy.context.scene)


def do(farm: TaskFarm, names: Sequence[str]) -> None:
    """Do tasks by name."""
    for name in names:
        finished(task_steps(farm, name))


def prepared(scene: bpy.types.Scene, spec: BakeSpec, out: Path, preview: bool = False) -> Farm:
    """The farm of the box; the session is empty afterwards."""
    wanted = Filter.QUADRILINEAR if preview else None
    return finished(prepare_steps(scene, BOX, spec, out, preview=wanted))


def render(folder: Path, frames: str) -> None:
    """Render frames with the bpy module, which sees none of our modules and no user's settings."""
    command = [sys.executable, "-I", str(folder / "render_frames.py"), "-f", frames]
    subprocess.run(command, check=True, capture_output=True, timeout=120, cwd=folder)


def assembled(folder: Path, out: Path | None = None) -> Assembled:
    """What the frames become."""
    return finished(assemble_steps(folder, out))


def rewrite_frame(frame: Path, rows: int | None = None, value: float | None = None, **words: str) -> None:
    """Write a frame again: its first rows alone, another value in its first pixel, other words."""
    parts = OpenEXR.File(str(frame), separate_channels=True).parts
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    header |= {name: parts[0].header.get(name, "") for name in ("Note", "Frame")} | words
    channels = {}
    for name, channel in ((name, channel) for part in parts for name, channel in part.channels.items()):
        pixels = channel.pixels[:rows].copy()
        if value is not None and not name.endswith("A"):
            pixels[0, 0] = value
        channels[name] = pixels
    OpenEXR.File(header, channels).write(str(frame))
