# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How large is what is saved to preview the bakes of a scene of ten objects?

    python -m tests.bench.preview_size

The objects have modifiers and an image texture each; a 2k HDRI lights them; a hidden sculpt, a second scene
and pictures of an earlier comparison are in the file, too. Bakes every object, with the images packed into
the .blend and beside it, and prints the size of the user's file as saved whole, of a preview (smallest and
largest), and of all of them with the images that they share.
"""

from __future__ import annotations

import argparse
import importlib
import statistics
import tempfile
from pathlib import Path
from time import perf_counter
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.core.sampler import Filter
from radtex_addon.job import bake_object
from radtex_addon.scene.nodes import open_material, open_world
from radtex_addon.settings.spec import BakeSpec, Layout

OBJECTS = 10
SPEC = BakeSpec(layout=Layout.BUCKETS, texels=32, bucket=4, samples=1)


def main() -> None:
    """Bake, and print a line for each way to keep the images."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, help="folder to keep the files in")
    options = parser.parse_args()
    print("images   user's file   a preview        all previews   with shared images   time to save one")
    for packed in (True, False):
        with tempfile.TemporaryDirectory() as temporary:
            folder = (options.out or Path(temporary)) / ("packed" if packed else "linked")
            print(_measured(folder, packed))


def _measured(folder: Path, packed: bool) -> str:
    folder.mkdir(parents=True)
    build_scene(folder, packed)
    user = folder / "user.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(user))
    seconds = _saves_timed()
    out = folder / "out"
    for number in range(OBJECTS):
        bake_object(cast(Any, bpy.context.scene), f"Object {number}", SPEC, out, preview=Filter.QUADRILINEAR)
    sizes = [path.stat().st_size for path in out.glob("*.preview.blend")]
    assert len(sizes) == OBJECTS
    shared = sum(path.stat().st_size for path in out.glob("preview-images/*"))
    return (
        f"{'packed' if packed else 'linked'}   {_mb(user.stat().st_size)}   "
        f"{_mb(min(sizes))} to {_mb(max(sizes))}   {_mb(sum(sizes))}   {_mb(sum(sizes) + shared)}   "
        f"{statistics.median(seconds):.2f} s"
    )


def _saves_timed() -> list[float]:
    """The seconds that each later save of a preview takes; filled by the bakes."""
    seconds: list[float] = []
    baking: Any = importlib.import_module("radtex_addon.job.baking")
    save: Any = getattr(baking.save_preview_of, "__wrapped__", baking.save_preview_of)

    def timed(*given: Any) -> None:
        since = perf_counter()
        save(*given)
        seconds.append(perf_counter() - since)

    cast(Any, timed).__wrapped__ = save
    baking.save_preview_of = timed
    return seconds


def build_scene(folder: Path, packed: bool) -> None:
    """Open a scene of OBJECTS objects, whose images are in `folder`, and packed if wanted."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    random = np.random.default_rng(0)
    scene = cast(Any, bpy.context.scene)
    for number in range(OBJECTS):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24, location=(3 * number, 0, 0))
        item = cast(Any, bpy.context.object)
        item.name = f"Object {number}"
        item.modifiers.new("cut", "BEVEL").segments = 2
        item.modifiers.new("wave", "WAVE")
        item.data.materials.append(_textured(_image(random, f"wood {number}", 512, "PNG", folder)))
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=300, y_subdivisions=300)
    sculpt = cast(Any, bpy.context.object)
    sculpt.name, sculpt.hide_render, sculpt.hide_viewport = "Sculpt", True, True
    other = cast(Any, bpy.data.scenes.new("Other"))
    other.collection.objects.link(bpy.data.objects.new("Elsewhere", sculpt.data.copy()))
    for name in ("Path Traced", "Baked", "Difference"):
        picture = _image(random, f"RadTex {name}", 256, "OPEN_EXR", folder)
        picture.use_fake_user = True
    world, build = open_world("Outside")
    sky = build.node("ShaderNodeTexEnvironment", image=_image(random, "sky", 2048, "HDR", folder))
    build.node("ShaderNodeOutputWorld", build.node("ShaderNodeBackground", sky.outputs[0]).outputs[0])
    scene.world = world
    bpy.ops.object.camera_add(location=(15, -30, 10), rotation=(1.2, 0, 0))
    scene.camera = bpy.context.object
    if packed:
        bpy.ops.file.pack_all()
        for path in folder.iterdir():  # else they would be linked again
            path.unlink()


def _textured(image: bpy.types.Image) -> bpy.types.Material:
    material, build = open_material(image.name)
    color = build.image(image, build.uv_map(), "Linear")[0]
    surface = build.node("ShaderNodeBsdfDiffuse", color).outputs[0]
    build.node("ShaderNodeOutputMaterial", surface)
    return material


def _image(random: np.random.Generator, name: str, width: int, kind: str, folder: Path) -> Any:
    """A noisy picture in a file, half as high as wide."""
    height = width // 2
    drawn: Any = bpy.data.images.new(name, width, height, float_buffer=kind != "PNG")
    values = np.ones((height, width, 4), np.float32)
    values[..., :3] = np.exp(random.normal(0, 0.1, (height, width, 3)))  # some noise, as pictures have
    drawn.pixels.foreach_set(values.ravel())
    drawn.file_format, drawn.filepath_raw = kind, str(folder / f"{name}.{kind[-3:].lower()}")
    drawn.save()
    bpy.data.images.remove(drawn)
    return bpy.data.images.load(str(folder / f"{name}.{kind[-3:].lower()}"))


def _mb(count: float) -> str:
    return f"{count / 1e6:.2f} MB"


if __name__ == "__main__":
    main()
