# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What denoising slices gives: Open Image Denoise over pictures of all texels in one direction.

    python -m tests.bench.fidelity.denoising                    metal_20, metal_50, ceramic
    python -m tests.bench.fidelity.denoising --scenes glass --samples 1

Of the plain layout the light is denoised, of the shared one the gain of its lobes. All slices lie side by
side in one picture, gutters filled, the texels' normals as a guide. Blender 5's compositor runs the denoiser.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import replace
from pathlib import Path
from time import perf_counter
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.spec import BakeSpec, Layout
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.gutter import dilate, nearest_covered
from radtex_addon.core.sampler import Filter, sample
from radtex_addon.core.shared import Lobe
from radtex_addon.formats.containers.exr import read_atlas, read_render
from radtex_addon.job import bake_object

from .fitted import Looked, fit_stage, quality
from .references import views
from .report import Result
from .scenes import SCENES, Stage

_SCENES = "metal_20,metal_50,ceramic"


def main() -> None:
    """Bake, denoise, look, print."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.fidelity.denoising",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--scenes", default=_SCENES, help="of " + ", ".join(SCENES))
    parser.add_argument("--texels", type=int, default=128)
    parser.add_argument("--samples", type=int, default=16)
    options = parser.parse_args()
    for name in options.scenes.split(","):
        looked_from = views(SCENES[name]())
        stage = SCENES[name]()
        with tempfile.TemporaryDirectory() as folder:
            spec = BakeSpec(layout=Layout.SHARED, texels=options.texels, samples=options.samples)
            fitted, looked, _ = fit_stage(stage, looked_from, spec, Path(folder))
            _tell(name, looked.result("shared", fitted.atlas))
            started = perf_counter()
            lobes = tuple(_denoised_gain(lobe, fitted.plan) for lobe in fitted.atlas.lobes)
            seconds = perf_counter() - started
            _tell(name, looked.result("shared, gain denoised", replace(fitted.atlas, lobes=lobes)), seconds)
            spec = BakeSpec(texels=options.texels, bucket=8, samples=options.samples)
            _plain(name, stage, spec, fitted.plan, looked, Path(folder))


def _tell(name: str, result: Result, seconds: float = 0.0) -> None:
    flip = result.mean("flip", True)
    print(f"{name}, {result.method}: {quality(result)}, FLIP {flip:.3f}, {seconds:.0f} s more", flush=True)


def _plain(name: str, stage: Stage, spec: BakeSpec, plan: CapturePlan, looked: Looked, folder: Path) -> None:
    """The plain layout before and after; the same texels as the plan's, for both unwrap alike."""
    scene = cast(bpy.types.Scene, bpy.context.scene)
    files = bake_object(scene, stage.subject.name, spec, folder, preview=None).files
    image, sidecar = read_atlas(files.atlas)
    layout = AtlasLayout(sidecar.width, sidecar.height, sidecar.bucket)
    if layout.height != plan.layout.height or layout.width != plan.layout.width:
        raise SystemExit(f"{name}: two unwraps differ")
    buckets = layout.to_buckets(image.astype(np.float32))[..., :3]
    _tell(name, _seen("plain", buckets, layout, looked))
    slices = buckets.reshape(layout.height, layout.width, -1, 3)
    started = perf_counter()
    denoised = _denoised(slices, plan).reshape(buckets.shape)
    _tell(name, _seen("plain, light denoised", denoised, layout, looked), perf_counter() - started)


def _seen(name: str, buckets: Floats, layout: AtlasLayout, looked: Looked) -> Result:
    image = layout.from_buckets(buckets)
    light = [
        buffer.spread(
            sample(image, layout, buffer.uv[buffer.hit], buffer.incidence[buffer.hit], Filter.QUADRILINEAR)
        )
        for view, buffer in looked.views
        if view.held_out
    ]
    return looked.seen(name, light)


def _denoised_gain(lobe: Lobe, plan: CapturePlan) -> Lobe:
    height, width, *cells, _ = lobe.gain.shape
    return replace(
        lobe, gain=_denoised(lobe.gain.reshape(height, width, -1, 3), plan).reshape(height, width, *cells, 3)
    )


def _denoised(slices: Floats, plan: CapturePlan) -> Floats:
    """Slices (H, W, S, 3), S a square, in the same shape; the plan has the texels' normals."""
    nearest = nearest_covered(plan.covered)
    height, width, count, _ = slices.shape
    side = round(count**0.5)
    tiled = dilate(slices, nearest).reshape(height, width, side, side, 3).transpose(2, 0, 3, 1, 4)
    normals = np.tile(plan.placed(plan.normals, gutter=True), (side, side, 1))
    picture = _oidn(tiled.reshape(side * height, side * width, 3), normals)
    found = picture.reshape(side, height, side, width, 3).transpose(1, 3, 0, 2, 4)
    return np.ascontiguousarray(found.reshape(slices.shape))


def _oidn(light: Floats, normals: Floats) -> Floats:
    """A picture (H, W, 3), denoised by Blender's compositor, with normals of the same shape."""
    scene = bpy.data.scenes.new("denoise")
    tree = cast(Any, bpy.data.node_groups.new("denoise", "CompositorNodeTree"))
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    cast(Any, scene).compositing_node_group = tree
    node = tree.nodes.new("CompositorNodeDenoise")
    images = {"Image": _image(light), "Normal": _image(normals)}
    for socket, image in images.items():
        source = tree.nodes.new("CompositorNodeImage")
        source.image = image
        tree.links.new(source.outputs[0], node.inputs[socket])
    tree.links.new(node.outputs[0], tree.nodes.new("NodeGroupOutput").inputs[0])
    camera = bpy.data.objects.new("denoise", bpy.data.cameras.new("denoise"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    render = cast(Any, scene.render)
    render.engine, cast(Any, scene).cycles.samples = "CYCLES", 1
    render.resolution_y, render.resolution_x = light.shape[:2]
    render.image_settings.media_type = "IMAGE"
    render.image_settings.file_format, render.image_settings.color_depth = "OPEN_EXR", "32"
    with tempfile.TemporaryDirectory() as folder:
        render.filepath = str(Path(folder, "denoised.exr"))
        bpy.ops.render.render(write_still=True, scene=scene.name)
        (found,) = read_render(Path(render.filepath)).values()
    bpy.data.scenes.remove(scene)
    bpy.data.node_groups.remove(tree)
    for image in images.values():
        bpy.data.images.remove(image)
    return found[..., :3]


def _image(values: Floats) -> bpy.types.Image:
    height, width, _ = values.shape
    image = bpy.data.images.new("denoise", width, height, float_buffer=True, is_data=True)
    pixels = np.ones((height, width, 4), dtype=np.float32)
    pixels[..., :3] = values
    cast(Any, image.pixels).foreach_set(pixels.ravel())
    return image


if __name__ == "__main__":
    main()
