# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""`core.transfer.sample_transfer` as native shader nodes, alike in Eevee and Cycles: "RadTex Transfer"."""

from __future__ import annotations

import bpy

from ..core.atlas import AtlasLayout
from ..scene.nodes import NodeBuilder, Socket, close_group, open_group
from .node_group import FRAME, check_image, check_previewable, incidence_group, pixel_group
from .shared_group import octahedron_group
from .taps import bilinear, pair


def build_transfer_group(image: bpy.types.Image, layout: AtlasLayout) -> bpy.types.ShaderNodeTree:
    """A node group that samples the atlas `image` of kind `transfer` between four texels and four cells.

    Inputs: UV (0..1, v up); Normal, Tangent and Light, vectors of any length in one space (Light points to
    the light); Sign, the bitangent's in that space. Outputs: Color, the radiance under an irradiance of 1,
    premultiplied, and Alpha. Raises InputError where the atlas is not an image of `layout`, or is larger than
    a GPU takes.
    """
    check_previewable(layout)
    check_image(image, layout)
    texel = _texel_group(_cell_group(pixel_group(image, layout), layout.bucket), layout.bucket)
    build, (uv, *vectors) = open_group("RadTex Transfer", UV="Vector", **FRAME, Light="Vector")
    (local,) = build.group(incidence_group(), *vectors)
    (place,) = build.group(octahedron_group(), local)
    size, last = pair(layout.width, layout.height), pair(layout.width - 1, layout.height - 1)
    position = build.vector("MULTIPLY_ADD", uv, size, pair(-0.5, -0.5), label="position, in texels")
    color, alpha = bilinear(build, texel, position, place, last=last)
    return close_group(build, Color=color, Alpha=alpha)


def _texel_group(cell: bpy.types.ShaderNodeTree, n: int) -> bpy.types.ShaderNodeTree:
    """One texel's bucket at a place on the octahedron, between four cells."""
    build, (texel, place) = open_group("RadTex Transfer Texel", Texel="Vector", Place="Vector")
    position = build.vector("MULTIPLY_ADD", place, pair(n, n), pair(-0.5, -0.5), label="position, in cells")
    color, alpha = bilinear(build, cell, position, texel)
    return close_group(build, Color=color, Alpha=alpha)


def _cell_group(pixel: bpy.types.ShaderNodeTree, n: int) -> bpy.types.ShaderNodeTree:
    """One cell; beyond an edge the one that lies there on the sphere: the same edge's, mirrored."""
    build, (cell, texel) = open_group("RadTex Transfer Cell", Cell="Vector", Texel="Vector")
    x, y, _ = build.separate(cell)
    folded_x, folded_y = _folded(build, x, beyond=y, n=n), _folded(build, y, beyond=x, n=n)
    color, alpha = build.group(pixel, build.combine(folded_x, folded_y), texel)
    return close_group(build, Color=color, Alpha=alpha)


def _folded(build: NodeBuilder, along: Socket, beyond: Socket, n: int) -> Socket:
    """A whole number along one side, mirrored where the other is beyond an edge, and then within [0, n-1]."""
    away = build.math("ABSOLUTE", build.math("SUBTRACT", beyond, (n - 1) / 2))
    turned = build.math("GREATER_THAN", away, n / 2)
    mirrored = build.math("SUBTRACT", n - 1.0, along)
    chosen = build.mix(turned, along, mirrored, "FLOAT")
    return build.math("MINIMUM", build.math("MAXIMUM", chosen, 0.0), n - 1.0)
