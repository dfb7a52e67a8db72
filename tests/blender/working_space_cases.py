# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One scene whose light has the same colours in every working space, and each way to bake it.

All that reflects is grey, so that light is only dimmed on its way: colours of lamps, the world and what glows
are the only ones, and the space in which Cycles multiplies makes no difference.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from radtex_addon.bake.layers import Layer
from radtex_addon.bake.transfer_buckets import mean_over_lights
from radtex_addon.core.arrays import Floats
from radtex_addon.core.frame import normalised
from radtex_addon.formats.bucket_files import read_layer
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.formats.shadow_files import read_shadow_of
from radtex_addon.formats.transfer_files import read_transfer
from radtex_addon.forms.layered.files.layered_files import read_layered
from radtex_addon.forms.layered.lookup.atlas import sample_layered
from radtex_addon.job import bake_object
from radtex_addon.settings.spec import BakeSpec, CaptureMethod, Kind, Layout
from tests.blender import farming, stage
from tests.layered.made_up import made_up_fragments

REC_709, WIDE = "Linear Rec.709", ("ACEScg", "Linear Rec.2020")
WORLD = (0.3, 0.5, 2.0)
Images = dict[str, Floats]

PLAIN = BakeSpec(uv_layer="UVMap", texels=8, bucket=4, samples=4, half=False)
ALL_LAYERS = replace(PLAIN, layers=tuple(Layer))
LAYERED = BakeSpec(uv_layer="UVMap", layout=Layout.LAYERED, texels=8, samples=4)


def work_in(space: str) -> None:
    """Let the open file, which works in Rec.709, work in another space; its colours stay what they are."""
    if space != REC_709:
        cast(Any, bpy.ops.wm).set_working_color_space(
            working_space=space, convert_colors=True
        )  # 4.5 has none


def build_scene() -> None:
    """A ball that scatters, reflects, lets through and glows, on a floor, below a lamp and a red light."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    stage.world(WORLD)
    scene: Any = bpy.context.scene
    scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = 0
    scene.cycles.use_light_tree = False  # it chooses lamps by their colours, and so makes other noise
    scene.cycles.light_sampling_threshold = 0  # it leaves lamps out by their colours
    bpy.ops.mesh.primitive_uv_sphere_add(segments=12, ring_count=6, radius=0.6)
    ball = _named("Ball")
    shader = stage.material("all", "ShaderNodeBsdfPrincipled", Roughness=0.4)
    node = next(node for node in shader.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    for name, value in (
        ("Base Color", (0.8, 0.8, 0.8, 1)),
        ("Transmission Weight", 0.4),
        ("Emission Color", (0.1, 0.6, 0.3, 1)),
        ("Emission Strength", 0.5),
    ):
        node.inputs[name].default_value = value
    ball.data.materials.append(shader)
    bpy.ops.mesh.primitive_plane_add(size=4, location=(0, 0, -1))
    grey = stage.material("floor", "ShaderNodeBsdfDiffuse", Color=(0.6, 0.6, 0.6, 1))
    _named("Floor").data.materials.append(grey)
    bpy.ops.mesh.primitive_plane_add(size=1, location=(-1.5, 0, 0.5), rotation=(0, 1.2, 0))
    red = stage.material("red", "ShaderNodeEmission", Color=(0.9, 0.2, 0.05, 1), Strength=3.0)
    _named("Glow").data.materials.append(red)
    bpy.ops.object.light_add(type="AREA", location=(1, 0.5, 2), rotation=(0.2, 0.4, 0))
    lamp = _named("Lamp").data
    lamp.size, lamp.energy, lamp.color = 1, 40, (0.2, 0.9, 0.4)


def _named(name: str) -> Any:
    found: Any = bpy.context.object
    found.name = name
    return found


def _bake(spec: BakeSpec, out: Path, name: str = "Ball") -> Path:
    return bake_object(cast(Any, bpy.context.scene), name, spec, out).files.sidecar


def _buckets(sidecar: Path, spec: BakeSpec) -> Images:
    found = {layer.value: read_layer(sidecar, layer).astype(np.float32) for layer in spec.layers}
    return {"whole": read_buckets(sidecar)[0].astype(np.float32), **found}


def plain(spec: BakeSpec, out: Path) -> Images:
    """The atlas, and its layers."""
    return _buckets(_bake(spec, out), spec)


def in_the_layered_layout(spec: BakeSpec, out: Path) -> Images:
    """Parts of a bake in the layered layout, and what they show together."""
    atlas, _ = read_layered(_bake(spec, out))
    at = made_up_fragments(atlas, 64)
    across = normalised(np.cross(at.normal, [0.1, 0.2, 0.97])).astype(np.float32)
    at = replace(at, tangent=across, bitangent=np.cross(at.normal, across).astype(np.float32))
    parts = {"colour": atlas.colour, "irradiance": atlas.irradiance, "own": atlas.own}
    return parts | {"world": atlas.around.world.levels[0], "shown": sample_layered(atlas, at)}


def transferred(spec: BakeSpec, out: Path) -> Images:
    """What light from everywhere shows of the ball alone, which is diffuse and coloured."""
    ball, glow = (cast(Any, bpy.data.objects[name]) for name in ("Ball", "Glow"))
    red = glow.active_material.node_tree.nodes["Emission"].inputs["Color"].default_value[:]
    ball.active_material = stage.material("red ball", "ShaderNodeBsdfDiffuse", Color=red)
    for item in list(bpy.data.objects):
        if item != ball:
            bpy.data.objects.remove(item)
    pixels, facts = read_transfer(_bake(spec, out))
    return {"mean over lights": mean_over_lights(pixels.astype(np.float32), facts.layout)}


def shaded(spec: BakeSpec, out: Path) -> Images:
    """The bits of a shadow atlas."""
    words, _ = read_shadow_of(_bake(spec, out))
    return {"bits": np.asarray(words).astype(np.float64)}


def farmed(spec: BakeSpec, out: Path) -> Images:
    """What a farm's frames become, assembled in a file that works in Rec.709."""
    bpy.data.objects["Ball"].name = farming.BOX
    farm = farming.prepared(cast(Any, bpy.context.scene), spec, out)
    farming.render(farm.files.folder, f"1-{farm.manifest.sheets}")
    return _buckets(farming.assembled(farm.files.folder, out).result.files.sidecar, spec)


def accumulated(spec: BakeSpec, out: Path) -> Images:
    """Twice the samples, in two bakes."""
    _bake(spec, out)
    return plain(replace(spec, accumulate=True), out)


Case = tuple[Callable[[BakeSpec, Path], Images], BakeSpec]

CASES: Mapping[str, Case] = {
    "radiance": (plain, PLAIN),
    "radiance, all layers": (plain, ALL_LAYERS),
    "radiance, a lamp": (plain, replace(PLAIN, lights=("Lamp",))),
    "radiance, world": (plain, replace(PLAIN, lights=("world",))),
    "radiance, accumulated": (accumulated, PLAIN),
    "radiance by a farm": (farmed, PLAIN),
    "radiance by a farm, all layers": (farmed, ALL_LAYERS),
    "radiance, layered": (in_the_layered_layout, LAYERED),
    "incident": (plain, replace(PLAIN, kind=Kind.INCIDENT)),
    "incident, panoramic": (plain, replace(PLAIN, kind=Kind.INCIDENT, capture=CaptureMethod.PANORAMIC)),
    "reflection": (plain, replace(PLAIN, kind=Kind.REFLECTION)),
    "proxy": (plain, replace(PLAIN, kind=Kind.PROXY, content="*")),
    "transfer": (transferred, BakeSpec(uv_layer="UVMap", kind=Kind.TRANSFER, texels=6, samples=4)),
    "ao": (plain, replace(PLAIN, kind=Kind.AO)),
    "ao within 1": (plain, replace(PLAIN, kind=Kind.AO, ao_distance=1.0)),
    "shadow": (shaded, replace(PLAIN, kind=Kind.SHADOW, half=True)),
}


def images_of(name: str, space: str, out: Path) -> Images:
    """What a case bakes of the scene in a space."""
    build_scene()
    work_in(space)
    run, spec = CASES[name]
    return run(spec, out)


def worst(found: Images, expected: Images) -> dict[str, float]:
    """The largest difference in each image, as a part of the larger of 1 and the image's largest value."""
    assert found.keys() == expected.keys()
    gaps = {name: np.abs(found[name] - image).max() for name, image in expected.items()}
    return {name: float(gap / max(1.0, np.abs(expected[name]).max())) for name, gap in gaps.items()}
