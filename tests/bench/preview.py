# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How close is a preview to the path-traced object? Three new views, Cycles and Eevee, each filter.

    python -m tests.bench.preview demo        the scene of `bake.py demo`
    python -m tests.bench.preview gold        the same on a plain grey floor
    python -m tests.bench.preview obj:DIR     an OBJ file with a texture beside it, made to scatter light
    python -m tests.bench.preview demo --layout buckets        the paper's layout, by every filter

Bakes the object, renders it path traced, renders its saved preview, and prints PSNR (of display values:
clipped to 0..1, gamma 2.2; inside the object, its mask eroded by a pixel). With --figures DIR it leaves
pictures there.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
from mathutils import Vector
from PIL import Image

from radtex_addon.core.sampler import Filter
from radtex_addon.formats.containers.exr import read_render
from radtex_addon.job import BakeResult, bake_object
from radtex_addon.report.gbuffer import eroded
from radtex_addon.report.metrics import Mask, Picture, display, psnr
from radtex_addon.scene.demo import OBJECT, add_camera, build_demo_scene
from radtex_addon.settings.spec import BakeSpec, Layout

VIEWS = ((0.0, -4.0, 0.6), (2.0, -3.2, 1.0), (-2.6, -2.6, 0.2))
EEVEE = "BLENDER_EEVEE" if bpy.app.version >= (5, 0) else "BLENDER_EEVEE_NEXT"


def main() -> None:
    """Bake, render, compare, print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("scene", help="demo, gold, or obj:DIR")
    parser.add_argument("--texels", type=int, default=128)
    parser.add_argument("--layout", choices=list(Layout), help="(default: layered, as bakes)")
    parser.add_argument("--bucket", type=int, help="(default: the layout's)")
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--pixels", type=int, default=192, help="of a picture's side")
    parser.add_argument("--reference-samples", type=int, default=256)
    parser.add_argument("--figures", type=Path, help="folder for the pictures")
    parser.add_argument("--no-eevee", action="store_true")
    options = parser.parse_args()
    name, build = _scene(options.scene)
    layout = Layout.LAYERED if options.layout is None else Layout(options.layout)
    spec = BakeSpec(
        layout=layout,
        texels=options.texels,
        bucket=options.bucket,
        samples=options.samples,
    )
    filters = tuple(Filter) if layout is Layout.BUCKETS else (Filter.QUADRILINEAR,)  # others have but one
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        scene = build()
        references, seen = _references(scene, options.pixels, options.reference_samples, folder)
        masks = [eroded(mask) for mask in seen]
        shown: dict[str, list[Picture]] = {}
        results: list[BakeResult] = []
        for kind in filters:
            scene = build()
            result = bake_object(scene, OBJECT, spec, folder, preview=kind, overwrite=True)
            results.append(result)
            assert result.files.preview is not None
            shown[f"Cycles, {kind}"] = _preview(result.files.preview, "CYCLES", options.pixels, folder)
            if not options.no_eevee:
                shown[f"Eevee, {kind}"] = _preview(result.files.preview, EEVEE, options.pixels, folder)
        print(f"\n{name}: {spec.texels} texels, {spec.bucket} cells, {spec.samples} spp, ", end="")
        print(f"{layout}, {results[-1].paths / 1e6:.1f} M paths, {results[-1].islands} islands")
        _print_table(shown, references, masks)
        if options.figures:
            _save_figures(options.figures, name, shown, references, seen)


def _print_table(shown: dict[str, list[Picture]], references: list[Picture], masks: list[Mask]) -> None:
    print("| preview | " + " | ".join(f"view {k + 1}" for k in range(len(VIEWS))) + " | mean |")
    print("|---|" + "---|" * (len(VIEWS) + 1))
    rows = {label: _decibels(pictures, references, masks) for label, pictures in shown.items()}
    for kind in Filter:
        if f"Eevee, {kind}" in shown:
            rows[f"Eevee against Cycles, {kind}"] = _decibels(
                shown[f"Eevee, {kind}"], shown[f"Cycles, {kind}"], masks
            )
    for label, decibels in rows.items():
        cells = " | ".join(f"{value:.2f}" for value in (*decibels, float(np.mean(decibels))))
        print(f"| {label} | {cells} |")


def _decibels(pictures: list[Picture], references: list[Picture], masks: list[Mask]) -> list[float]:
    return [psnr(*trio) for trio in zip(pictures, references, masks, strict=True)]


def _scene(text: str) -> tuple[str, Callable[[], bpy.types.Scene]]:
    if text.startswith("obj:"):
        folder = Path(text.removeprefix("obj:"))
        return folder.name, lambda: _obj_scene(folder)
    return text, {"demo": build_demo_scene, "gold": _gold_scene}[text]


def _gold_scene() -> bpy.types.Scene:
    """The demo's gold head over a plain floor."""
    scene = build_demo_scene()
    tree = bpy.data.objects["Floor"].data.materials[0].node_tree
    shader = next(node for node in tree.nodes if node.type == "BSDF_PRINCIPLED")
    colour = cast(Any, shader.inputs["Base Color"])
    tree.links.remove(colour.links[0])
    colour.default_value = (0.4, 0.4, 0.4, 1)
    return scene


def _obj_scene(folder: Path) -> bpy.types.Scene:
    """The demo with its head exchanged for a folder's OBJ, textured and waxy."""
    scene = build_demo_scene()
    head = bpy.data.objects[OBJECT]
    bpy.data.objects.remove(head)
    bpy.ops.wm.obj_import(filepath=str(next(folder.glob("*.obj"))))
    item = bpy.context.object
    item.name = OBJECT
    bpy.ops.object.shade_smooth()
    item.location.z = -0.25
    material = bpy.data.materials.new("Wax")
    if material.node_tree is None:
        material.use_nodes = True
    shader = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    texture = material.node_tree.nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.load(str(next(folder.glob("*.png"))))
    material.node_tree.links.new(texture.outputs["Color"], shader.inputs["Base Color"])
    shader.inputs["Subsurface Weight"].default_value = 0.6
    shader.inputs["Subsurface Radius"].default_value = (0.3, 0.15, 0.1)
    shader.inputs["Roughness"].default_value = 0.35
    item.data.materials.clear()
    item.data.materials.append(material)
    return scene


def _references(
    scene: bpy.types.Scene, pixels: int, samples: int, folder: Path
) -> tuple[list[Picture], list[Mask]]:
    """Path-traced views, denoised, and where the object is seen in them."""
    references, masks = [], []
    for place in VIEWS:
        _look_from(scene, place, pixels)
        cycles = cast(Any, scene).cycles
        cycles.use_adaptive_sampling = False
        cycles.samples, cycles.use_denoising = samples, True
        cycles.pixel_filter_type = "BOX"
        references.append(_render(scene, folder))
        masks.append(_seen(scene, folder))
    return references, masks


def _seen(scene: bpy.types.Scene, folder: Path) -> Mask:
    """Pixels at whose centre the camera sees the object."""
    bpy.data.objects[OBJECT].pass_index = 1
    layer = scene.view_layers[0]
    layer.use_pass_object_index = True
    _at_pixel_centres(scene)
    layers = _render_layers(scene, folder, multilayer=True)
    layer.use_pass_object_index = False
    index = next(value for name, value in layers.items() if name.endswith(("IndexOB", "Object Index")))
    seen: Mask = index[..., 0] > 0.5
    return seen


def _preview(path: Path, engine: str, pixels: int, folder: Path) -> list[Picture]:
    bpy.ops.wm.open_mainfile(filepath=str(path), load_ui=False)
    scene = cast(bpy.types.Scene, bpy.context.scene)
    cast(Any, scene.render).engine = engine  # the stubs know no add-on's engine
    _at_pixel_centres(scene)
    pictures = []
    for place in VIEWS:
        _look_from(scene, place, pixels)
        pictures.append(_render(scene, folder))
    return pictures


def _at_pixel_centres(scene: bpy.types.Scene) -> None:
    """One sample a pixel, at its centre, in both engines: an emitter has no noise."""
    cycles = cast(Any, scene).cycles
    cycles.samples, cycles.use_denoising = 1, False
    cycles.use_adaptive_sampling = False
    cycles.pixel_filter_type, cycles.filter_width = "GAUSSIAN", 0.01
    scene.eevee.taa_render_samples = 1
    scene.render.filter_size = 0.0


def _look_from(scene: bpy.types.Scene, place: tuple[float, float, float], pixels: int) -> None:
    if scene.camera is None:
        scene.camera = add_camera(scene, place)
    scene.camera.location = place
    scene.camera.rotation_euler = (-Vector(place)).to_track_quat("-Z", "Y").to_euler()
    scene.render.resolution_x = scene.render.resolution_y = pixels
    scene.render.resolution_percentage = 100


def _render(scene: bpy.types.Scene, folder: Path) -> Picture:
    """The combined picture, (pixels, pixels, 3), the top row first."""
    combined = next(iter(_render_layers(scene, folder, multilayer=False).values()))
    picture: Picture = combined[::-1, :, :3].astype(np.float64)
    return picture


def _render_layers(scene: bpy.types.Scene, folder: Path, multilayer: bool) -> dict[str, Any]:
    image = scene.render.image_settings
    if hasattr(image, "media_type"):
        image.media_type = "MULTI_LAYER_IMAGE" if multilayer else "IMAGE"
    image.file_format = "OPEN_EXR_MULTILAYER" if multilayer else "OPEN_EXR"
    image.color_depth = "32"
    scene.render.filepath = str(folder / "view.exr")
    bpy.ops.render.render(write_still=True)
    layers = read_render(folder / "view.exr")
    return {name: value[::-1] for name, value in layers.items()} if multilayer else layers


def _save_figures(
    folder: Path, name: str, shown: dict[str, list[Picture]], references: list[Picture], seen: list[Mask]
) -> None:
    """A strip a view: the object as Cycles and Eevee preview it, path traced, and the first's error times 4.

    Around the object every picture is the path-traced one: the previews have one sample a pixel.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for index, (reference, mask) in enumerate(zip(references, seen, strict=True)):
        labels = [f"{engine}, {Filter.QUADRILINEAR}" for engine in ("Cycles", "Eevee")]
        previews = [display(shown[label][index]) for label in labels if label in shown]
        error = np.clip(4 * np.abs(previews[0] - display(reference)), 0, 1)
        around = display(reference)
        pictures = [*(np.where(mask[..., None], picture, around) for picture in previews), around]
        strip = np.concatenate([*pictures, error * mask[..., None]], axis=1)
        image = Image.fromarray((strip * 255 + 0.5).astype(np.uint8))
        image.save(folder / f"preview-{name}-{index + 1}.png", optimize=True)


if __name__ == "__main__":
    main()
