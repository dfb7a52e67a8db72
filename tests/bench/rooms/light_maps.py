# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A room as web pages show rooms today: light maps by Cycles's own bake, and one probe, in three.js.

Each mesh has a light map by its share of all surfaces, on a second UV map, which is RadTex's own unwrap, so
that the two ways differ by what they keep and not by seams: the diffuse light of all lamps, direct and
indirect, without the surface's colour, denoised by OpenImageDenoise. Colours that nodes compute, which glTF
has not, are baked on the same UVs. Gloss mirrors a panorama from the room's middle, in MeshPhysicalMaterial;
lamps are in the light maps alone, so that there is no mirror image of what is no mesh, the sun's among them.
The sky is the background. Sheets have one side in a light map: their backs show the light of their fronts.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.bake.progress import finished
from radtex_addon.core.arrays import Bools, Floats
from radtex_addon.core.errors import BakeError, InputError
from radtex_addon.core.gutter import dilate, nearest_covered
from radtex_addon.cycles.denoiser import ImageDenoiser, image_denoiser
from radtex_addon.prepare.prepared import prepare
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec

from ..assets import three_scene
from ..assets.views import Pictures, bounds
from ..fidelity.scenes.materials import assign, shader
from .baking import SURFACES, rendered

SAMPLES = 64  # of a light map's texel
_SKY_SAMPLES = 4  # of a pixel of the sky, which has nothing but edges to be sampled
_MOST_UVS = 4  # that three.js reads
_NUMBER = "light"  # the custom property by which the page finds a node's light map
_LEAST = 32  # texels along a light map's side
_FINER = 4  # texels of a colour along one of light


@dataclass(frozen=True)
class LightMap:
    """A mesh's light map of `width` x `height` texels, on its `uv_map`, whose number is the `channel`."""

    width: int
    height: int
    uv_map: str
    channel: int


def write_lit_page(pictures: Pictures, folder: Path, texels: int, samples: int) -> list[LightMap]:
    """Write the page of the scene of `pictures` into a new folder; that scene is open before and after.

    The light maps have about so many texels in all, each traced by so many paths. Returns them in the order
    of their files. Raises InputError for a scene without surfaces, or a mesh of more UV maps than three.js
    reads, and BakeError where Blender has no OpenImageDenoise.
    """
    folder.mkdir(parents=True, exist_ok=True)
    names = [item.name for item in rendered(SURFACES)]
    if not names:
        raise InputError("the scene has no surface that renders show")
    middle = np.mean(bounds(names), axis=0)
    height = three_scene.HEIGHT
    for file, hidden, taken in (("probe", [], three_scene.SAMPLES), ("sky", names, _SKY_SAMPLES)):
        picture = pictures.panorama(middle, hidden, height, taken)
        three_scene.write_halves(picture[::-1], folder / f"{file}.bin")
    try:
        items = _meshes(names)
        areas = np.array([_area(item) for item in items])
        sides = np.round(np.sqrt(texels * areas / areas.sum())).astype(int).clip(_LEAST).tolist()
        maps = [_unwrapped(item, side) for item, side in zip(items, sides, strict=True)]
        for number, (item, one) in enumerate(zip(items, maps, strict=True)):
            item[_NUMBER] = number
            _own_materials(item)
            _bake_colour(item, one, folder / f"colour{number}.png")
        lights = [_light(item, one, samples) for item, one in zip(items, maps, strict=True)]
        with image_denoiser(folder) as denoiser:
            if denoiser is None:
                raise BakeError("this Blender has no OpenImageDenoise")
            for number, (light, there) in enumerate(lights):
                found = _denoised(light, there, denoiser)
                three_scene.write_halves(found[::-1], folder / f"light{number}.bin")
        (folder / "lights.json").write_text(json.dumps([vars(one) for one in maps]), encoding="utf-8")
        three_scene.export_scene(folder, lamps=False)
    finally:
        bpy.ops.wm.open_mainfile(filepath=str(pictures.scene))
    three_scene.bundle_page(folder)
    return maps


def _meshes(names: list[str]) -> list[Any]:
    """The objects as meshes of their own, with their modifiers applied."""
    items: list[Any] = [bpy.data.objects[name] for name in names]
    _select(items)
    bpy.ops.object.make_single_user(object=True, obdata=True)
    bpy.ops.object.convert(target="MESH")
    return [item for item in (cast(Any, bpy.data.objects[name]) for name in names) if item.data.polygons]


def _select(items: Sequence[Any]) -> None:
    for item in cast(Any, bpy.context).view_layer.objects:
        item.select_set(item in items)
    cast(Any, bpy.context).view_layer.objects.active = items[0]


def _area(item: Any) -> float:
    """Of a mesh object's surface in the world."""
    mesh = item.data
    mesh.calc_loop_triangles()
    matrix = np.array(item.matrix_world)
    places = np.array([vertex.co for vertex in mesh.vertices]) @ matrix[:3, :3].T
    corners: Any = places[np.array([triangle.vertices for triangle in mesh.loop_triangles])]
    a, b, c = (corners[:, number] for number in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def _unwrapped(item: Any, side: int) -> LightMap:
    """Give an object its mesh as RadTex unwraps it for so many texels along a side."""
    kept: list[bpy.types.ID] = []
    scene = cast(bpy.types.Scene, bpy.context.scene)
    with scratch_scene(scene, None, kept) as scratch:
        spec = BakeSpec(texels=side, samples=1)
        prepared = finished(prepare(scratch, [find_object(scratch, item.name)], spec, kept))
    mesh: Any = prepared.mesh
    names = list(mesh.uv_layers.keys())
    if len(names) > _MOST_UVS:
        raise InputError(f"{item.name} has {len(names) - 1} UV maps: three.js has room for {_MOST_UVS - 1}")
    item.data = mesh
    uv_map = prepared.uv_layer
    return LightMap(prepared.width, prepared.height, uv_map, names.index(uv_map))


def _own_materials(item: Any) -> None:
    """Give an object copies of its materials, and one where it has none."""
    if not item.material_slots:
        assign(item, bpy.data.materials.new("Plain"))
    for slot in item.material_slots:
        slot.material = bpy.data.materials.new("Plain") if slot.material is None else slot.material.copy()
        if slot.material.node_tree is None:  # Blender 4.5
            slot.material.use_nodes = True


def _bake_colour(item: Any, on: LightMap, file: Path) -> None:
    """Replace base colours that nodes compute by an image of them in sRGB, _FINER than the light map."""
    materials = [slot.material for slot in item.material_slots]
    computed = [one for one in materials if _is_computed(one)]
    if not computed:
        return
    image: Any = bpy.data.images.new(file.stem, _FINER * on.width, _FINER * on.height)
    with _shining(materials), _into(item, image):
        _bake("EMIT", on, 1, margin=_FINER)
    image.filepath_raw, image.file_format = str(file), "PNG"
    image.save()
    for material in computed:
        tree = material.node_tree
        uv, texture = tree.nodes.new("ShaderNodeUVMap"), tree.nodes.new("ShaderNodeTexImage")
        uv.uv_map, texture.image = on.uv_map, image
        tree.links.new(uv.outputs[0], texture.inputs[0])
        tree.links.new(texture.outputs["Color"], shader(material).inputs["Base Color"])


def _is_computed(material: Any) -> bool:
    shaders = [node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED"]
    links = shaders[0].inputs["Base Color"].links if shaders else []
    return bool(links) and links[0].from_node.type != "TEX_IMAGE"


@contextmanager
def _shining(materials: list[Any]) -> Iterator[None]:
    """Have materials shine in their base colours, black where they have no Principled node."""
    made = []
    for material in materials:
        tree = material.node_tree
        output = next(node for node in tree.nodes if node.type == "OUTPUT_MATERIAL")
        before = [link.from_socket for link in output.inputs["Surface"].links]
        glow = tree.nodes.new("ShaderNodeEmission")
        glow.inputs["Color"].default_value = (0, 0, 0, 1)
        for node in tree.nodes:
            if node.type == "BSDF_PRINCIPLED":
                colour = node.inputs["Base Color"]
                glow.inputs["Color"].default_value = colour.default_value
                for link in colour.links:
                    tree.links.new(link.from_socket, glow.inputs["Color"])
        tree.links.new(glow.outputs[0], output.inputs["Surface"])
        made.append((tree, glow, output, before))
    try:
        yield
    finally:
        for tree, glow, output, before in made:
            tree.nodes.remove(glow)
            for socket in before:
                tree.links.new(socket, output.inputs["Surface"])


@contextmanager
def _into(item: Any, image: Any) -> Iterator[None]:
    """Have bakes of an object go into an image."""
    _select([item])
    made = []
    for slot in item.material_slots:
        nodes = slot.material.node_tree.nodes
        node = nodes.new("ShaderNodeTexImage")
        node.image, nodes.active = image, node
        made.append((nodes, node))
    try:
        yield
    finally:
        for nodes, node in made:
            nodes.remove(node)


def _bake(kind: str, on: LightMap, samples: int, margin: int, **options: Any) -> None:
    scene: Any = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = samples
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    cast(Any, bpy.ops.object.bake)(type=kind, margin=margin, use_clear=True, uv_layer=on.uv_map, **options)


def _light(item: Any, on: LightMap, samples: int) -> tuple[Floats, Bools]:
    """The radiance of white paint (H, W, 3), the lowest row first, and which texels have any, (H, W).

    What is buried in another object, where no light gets, has none, as lightmappers of game engines have it.
    """
    image: Any = bpy.data.images.new("Light", on.width, on.height, alpha=True, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    with _into(item, image):
        _bake("DIFFUSE", on, samples, margin=0, pass_filter={"DIRECT", "INDIRECT"})
    values = np.empty(on.width * on.height * 4, dtype=np.float32)
    image.pixels.foreach_get(values)
    bpy.data.images.remove(image)
    found = values.reshape(on.height, on.width, 4)
    return found[..., :3].copy(), (found[..., 3] > 0) & (found[..., :3].max(axis=2) > 0)


def _denoised(light: Floats, there: Bools, denoiser: ImageDenoiser) -> Floats:
    """A light map without noise, its gutters filled.

    The denoiser sees smooth gutters: copies of what is beside them would turn noise into stripes, which it
    takes for a pattern.
    """
    if not there.any():
        return light
    white, up = np.ones_like(light), np.zeros_like(light)
    up[..., 2] = 1
    found = denoiser(_filled(light, there), white, up)
    return cast(Floats, dilate(found, nearest_covered(there)))


def _filled(light: Floats, there: Bools) -> Floats:
    """The light, and around it means over ever larger squares."""
    if there.all():
        return light
    height, width = there.shape
    more = ((0, height % 2), (0, width % 2), (0, 0))
    weight = np.pad(there[..., None].astype(np.float32), more)
    total = np.pad(np.where(there[..., None], light, 0), more)
    sums, weights = (
        one.reshape(one.shape[0] // 2, 2, one.shape[1] // 2, 2, -1).sum(axis=(1, 3))
        for one in (total, weight)
    )
    coarse = _filled(sums / np.maximum(weights, 1), weights[..., 0] > 0)
    around = coarse.repeat(2, 0).repeat(2, 1)[:height, :width]
    return cast(Floats, np.where(there[..., None], light, around))
