# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials that show bakes of `shadow` (a white object lit by the sun) and `ao` (a grey object)."""

from __future__ import annotations

from math import pi
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np

from ..core.atlas import AtlasLayout
from ..core.sampler import Filter
from ..core.shadow import unpack_bits
from ..formats.containers.png import encode_png
from ..formats.disk.temporary import temporary_folder
from ..formats.shadow_files import read_shadow_of
from ..scene.nodes import open_material
from .material import build_frame_group, load_atlas
from .node_group import build_sample_group, check_previewable
from .sun import DIRECTION, IRRADIANCE, follow_sun

_FROM_LEFT = (-0.45, -0.55, 0.7)
_SUNNY = (3.0, 3.0, 3.0)


def preview_shadow_material(
    name: str, sidecar: Path, uv_layer: str, scene: bpy.types.Scene, kind: Filter
) -> bpy.types.Material:
    """A white material lit by `scene`'s first sun, with the shadows of the bake `sidecar`.

    The light has one direction: the node DIRECTION holds the vector towards it, and a driver makes it follow
    the sun, if there is one. Raises FormatError for files that cannot be read, InputError for a bake that,
    at one pixel per cell, is larger than a GPU takes.
    """
    image, layout = _spread_out(name, sidecar)
    sampler = build_sample_group(image, layout, kind)
    material, build = open_material(name)
    cast(Any, material).cycles.emission_sampling = "NONE"  # rays see it, but Cycles does not sample it
    uv, frame = build.uv_map(uv_layer), build.group(build_frame_group())
    light, irradiance = build.combine(*_FROM_LEFT), build.combine(*_SUNNY)
    for socket, label in ((light, DIRECTION), (irradiance, IRRADIANCE)):
        socket.node.name = socket.node.label = label
    seen, _ = build.group(sampler, uv, *frame, light)
    upright, towards = build.vector("NORMALIZE", frame[0]), build.vector("NORMALIZE", light)
    cosine = build.math("MAXIMUM", build.vector("DOT_PRODUCT", upright, towards), 0.0)
    arriving = build.vector("SCALE", irradiance, build.math("MULTIPLY", cosine, 1 / pi))
    emission = build.node("ShaderNodeEmission", build.vector("MULTIPLY", seen, arriving))
    build.node("ShaderNodeOutputMaterial", emission.outputs[0])
    build.arrange()
    follow_sun(material, scene)
    return material


def preview_ambient_material(
    name: str, atlas: Path, layout: AtlasLayout, uv_layer: str, half: bool = True
) -> bpy.types.Material:
    """A material whose grey is the ambient visibility in the file `atlas`. Raises as `load_atlas` does."""
    sampler = build_sample_group(load_atlas(atlas, half, data=True), layout, Filter.QUADRILINEAR)
    material, build = open_material(name)
    cast(Any, material).cycles.emission_sampling = "NONE"
    uv, frame = build.uv_map(uv_layer), build.group(build_frame_group())
    _, ambient = build.group(sampler, uv, *frame)
    emission = build.node("ShaderNodeEmission", build.combine(ambient, ambient, ambient))
    build.node("ShaderNodeOutputMaterial", emission.outputs[0])
    build.arrange()
    return material


def _spread_out(name: str, sidecar: Path) -> tuple[bpy.types.Image, AtlasLayout]:
    """Unpack the shadow bits to an image packed in the .blend: one pixel per cell, white if unoccluded."""
    words, facts = read_shadow_of(sidecar)
    layout = AtlasLayout(facts.width, facts.height, facts.bucket)
    check_previewable(layout)
    open_cells = (~unpack_bits(words, facts.bucket)).astype(np.float32)[..., None]
    picture = np.broadcast_to(layout.from_buckets(open_cells), (layout.pixel_height, layout.pixel_width, 3))
    with temporary_folder() as folder:
        path = folder / f"{sidecar.stem}.png"
        path.write_bytes(encode_png(picture[::-1]))
        image = load_atlas(path, data=True)
        image.name = f"{name} shadow"
        image.pack()
        image.filepath_raw = ""  # the temporary file will be gone
    return image, layout
