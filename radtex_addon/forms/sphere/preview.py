# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What shows a bake of kind `transfer`: its node group, its material, and the Script node."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import bpy

from ...core.atlas import AtlasLayout
from ...formats.transfer_files import with_views
from ...preview.lit_material import follow_sun, own_light
from ...preview.material import build_frame_group, load_atlas
from ...preview.node_group import (
    FRAME,
    bucket_group,
    check_image,
    check_previewable,
    incidence_group,
    pixel_group,
)
from ...preview.osl import SHADERS, script_node
from ...preview.taps import bilinear, clamp, octahedron_group, pair
from ...scene.nodes import NodeBuilder, Socket, close_group, open_group, open_material
from ..form import PreviewOf


def build_transfer_group(
    image: bpy.types.Image, layout: AtlasLayout, views: int = 1
) -> bpy.types.ShaderNodeTree:
    """A node group that samples the atlas `image` of kind `transfer`, bilinear in texels and in cells.

    `layout` is the atlas's without its `views` x `views` views. Inputs: UV (0..1, v up); Normal, Tangent and
    Light, vectors of any length in one space (Light points to the light); Sign, the bitangent's in that
    space; if there are several views, four of which are blended, also Incoming as in "RadTex Sample".
    Outputs: Color, the radiance under an irradiance of 1, premultiplied, and Alpha. Raises InputError if the
    atlas is not an image of `layout` with these views, or is larger than a GPU takes.
    """
    stored = with_views(layout, views)
    check_previewable(stored)
    check_image(image, stored)
    texel = _texel_group(_cell_group(pixel_group(image, stored), layout.bucket), layout.bucket)
    view = _view_group(texel, layout, views)
    viewer = {"Incoming": "Vector"} if views > 1 else {}
    build, (uv, *vectors) = open_group("RadTex Transfer", UV="Vector", **FRAME, Light="Vector", **viewer)
    frame, light, *incoming = vectors[:3], *vectors[3:]
    (local,) = build.group(incidence_group(), *frame, light)
    (place,) = build.group(octahedron_group(), local)
    if views == 1:
        color, alpha = build.group(view, pair(0, 0), uv, place)
        return close_group(build, Color=color, Alpha=alpha)
    (incidence,) = build.group(incidence_group(), *frame, *incoming)
    (b,) = build.group(bucket_group(), incidence)
    half, last = views / 2, pair(views - 1, views - 1)
    position = build.vector("MULTIPLY_ADD", b, pair(half, half), pair(half - 0.5, half - 0.5))
    among = clamp(build, position, last, label="position, in views")
    color, alpha = bilinear(build, view, among, uv, place, last=last, in_turn=True)
    return close_group(build, Color=color, Alpha=alpha)


def _view_group(texel: bpy.types.ShaderNodeTree, layout: AtlasLayout, views: int) -> bpy.types.ShaderNodeTree:
    """Look up one view, bilinear between the four texels around UV."""
    of_view, (number, view, place) = open_group(
        "RadTex Transfer View Texel", Texel="Vector", View="Vector", Place="Vector"
    )
    index = of_view.vector("MULTIPLY_ADD", number, pair(views, views), view)
    color, alpha = of_view.group(texel, index, place)
    tap = close_group(of_view, Color=color, Alpha=alpha)
    build, (view, uv, place) = open_group("RadTex Transfer View", View="Vector", UV="Vector", Place="Vector")
    size, last = pair(layout.width, layout.height), pair(layout.width - 1, layout.height - 1)
    position = build.vector("MULTIPLY_ADD", uv, size, pair(-0.5, -0.5), label="position, in texels")
    color, alpha = bilinear(build, tap, position, view, place, last=last)
    return close_group(build, Color=color, Alpha=alpha)


def _texel_group(cell: bpy.types.ShaderNodeTree, n: int) -> bpy.types.ShaderNodeTree:
    """Look up one texel's bucket at a place on the octahedron, bilinear between four cells."""
    build, (texel, place) = open_group("RadTex Transfer Texel", Texel="Vector", Place="Vector")
    position = build.vector("MULTIPLY_ADD", place, pair(n, n), pair(-0.5, -0.5), label="position, in cells")
    color, alpha = bilinear(build, cell, position, texel)
    return close_group(build, Color=color, Alpha=alpha)


def _cell_group(pixel: bpy.types.ShaderNodeTree, n: int) -> bpy.types.ShaderNodeTree:
    """Look up one cell. Across an edge lies, on the sphere, a cell of the same edge, mirrored."""
    build, (cell, texel) = open_group("RadTex Transfer Cell", Cell="Vector", Texel="Vector")
    x, y, _ = build.separate(cell)
    folded_x, folded_y = _folded(build, x, beyond=y, n=n), _folded(build, y, beyond=x, n=n)
    color, alpha = build.group(pixel, build.combine(folded_x, folded_y), texel)
    return close_group(build, Color=color, Alpha=alpha)


def _folded(build: NodeBuilder, along: Socket, beyond: Socket, n: int) -> Socket:
    """One coordinate of a cell: mirrored if the other, `beyond`, is outside [0, n - 1], then clamped."""
    away = build.math("ABSOLUTE", build.math("SUBTRACT", beyond, (n - 1) / 2))
    turned = build.math("GREATER_THAN", away, n / 2)
    mirrored = build.math("SUBTRACT", n - 1.0, along)
    chosen = build.mix(turned, along, mirrored, "FLOAT")
    return build.math("MINIMUM", build.math("MAXIMUM", chosen, 0.0), n - 1.0)


def transfer_material(of: PreviewOf, atlas: Path, layout: AtlasLayout, views: int) -> bpy.types.Material:
    """The material that shows the file `atlas` in the light of the scene's first sun.

    `layout` and `views` are as in `build_transfer_group`. Raises as that and `load_atlas` do.
    """
    sampler = build_transfer_group(load_atlas(atlas, of.spec.half), layout, views)
    material, build = open_material(of.title)
    cast(Any, material).cycles.emission_sampling = "NONE"  # rays see it, but Cycles does not sample it
    uv, frame = build.uv_map(of.uv_layer), build.group(build_frame_group())
    light, strength = own_light(build)
    color, alpha = build.group(sampler, uv, *frame, light)
    emission = build.node("ShaderNodeEmission", build.vector("MULTIPLY", color, strength))
    behind = build.node("ShaderNodeBsdfTransparent", build.math("SUBTRACT", 1.0, alpha))
    surface = build.node("ShaderNodeAddShader", emission.outputs[0], behind.outputs[0])
    build.node("ShaderNodeOutputMaterial", surface.outputs[0])
    build.arrange()
    follow_sun(material, of.scene)
    return material


def add_transfer_osl_node(
    tree: bpy.types.NodeTree, atlas: Path, layout: AtlasLayout, views: int = 1
) -> bpy.types.Node:
    """A Script node that samples the file `atlas` as "RadTex Transfer" does.

    Inputs: those of `preview.osl.add_osl_node`, and Light, the direction to the light; Incoming has no effect
    if there is only one view. The scene must render as described there, and the errors are the same.
    """
    constants = {
        "Atlas": str(atlas),
        "Width": layout.width,
        "Height": layout.height,
        "Bucket": layout.bucket,
        "Views": views,
    }
    source = SHADERS / "radtex_transfer.osl"
    return script_node(tree, source.name, source.read_text(encoding="utf-8"), constants)
