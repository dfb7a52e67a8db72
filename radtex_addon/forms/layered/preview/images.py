# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Look images up by shader nodes: maps of the surface, buckets, and all materials' curves by N.V.

Images are read with `Closest` and blended here, since Eevee's `Linear` takes mipmaps: see `preview.taps`.
"""

from __future__ import annotations

from collections.abc import Iterable

import bpy
import numpy as np

from ....core.arrays import Floats
from ....preview.taps import after, bilinear, clamp, pair, pixel_centre, readable_size
from ....scene.nodes import NodeBuilder, Operand, Socket, close_group, open_group
from ..files.sidecar import LayeredSidecar
from ..lookup.lobes import SATURATION, SHADOWED, STEPS, Gloss

ROWS = (
    6  # of each material: falloff, both lobes' weights, bend with both widths' logarithms, gloss with brush
)


def constant(values: Floats) -> tuple[float, float, float]:
    """A vector (3,) as a node takes it."""
    x, y, z = (float(value) for value in values)
    return x, y, z


def ordered(build: NodeBuilder, number: Socket, known: Iterable[Socket]) -> Socket:
    """`taps.after`, which Blender 4.5 needs for its stack; later ones manage without it."""
    return number if bpy.app.version >= (5, 0) else after(build, number, known)


def map_group(name: str, image: bpy.types.Image) -> bpy.types.ShaderNodeTree:
    """Look up a map of the surface at UV, bilinear between four texels: Color."""
    width, height = readable_size(image)
    tap, (texel,) = open_group(f"RadTex {name} Texel", Texel="Vector")
    texels = close_group(tap, Color=tap.image(image, pixel_centre(tap, texel, (width, height)))[0])
    build, (uv,) = open_group(f"RadTex {name}", UV="Vector")
    (color,) = bilinear(
        build, texels, position_of(build, uv, (width, height)), last=pair(width - 1, height - 1)
    )
    return close_group(build, Color=color)


def buckets_group(
    name: str, image: bpy.types.Image, cells: int, size: tuple[int, int]
) -> bpy.types.ShaderNodeTree:
    """Look up buckets of cells x cells at UV and a Place on the octahedron's square: Color and Alpha.

    They are those of `size` texels, width and height; bilinear between four texels and four cells.
    """
    width, height = size
    bucket = _bucket_group(name, _cell_group(name, image, cells), cells)
    build, (uv, place) = open_group(f"RadTex {name} Buckets", UV="Vector", Place="Vector")
    position, last = position_of(build, uv, size), pair(width - 1, height - 1)
    color, alpha = bilinear(build, bucket, position, place, last=last, in_turn=True)
    return close_group(build, Color=color, Alpha=alpha)


def position_of(build: NodeBuilder, place: Socket, size: tuple[int, int]) -> Socket:
    """A place in [0, 1]² in texels or cells, whose centres are at whole numbers."""
    return build.vector("MULTIPLY_ADD", place, pair(*size), pair(-0.5, -0.5), label="position")


def folded(build: NodeBuilder, cell: Operand, cells: int) -> Socket:
    """The cell that lies on the sphere where one beyond an edge of the square would be: mirrored there."""
    last = cells - 1.0
    inside = clamp(build, cell, pair(last, last), label="inside")
    beyond_x, beyond_y, _ = build.separate(build.vector("ABSOLUTE", build.vector("SUBTRACT", cell, inside)))
    x, y, _ = build.separate(inside)
    across_x, across_y, _ = build.separate(build.vector("SUBTRACT", pair(last, last), inside))
    return build.combine(build.mix(beyond_y, x, across_x, "FLOAT"), build.mix(beyond_x, y, across_y, "FLOAT"))


def _cell_group(name: str, image: bpy.types.Image, cells: int) -> bpy.types.ShaderNodeTree:
    """Look up one cell of one texel's bucket: the pixel (x W + i, y H + j) of tiles of W x H pixels."""
    width, height = readable_size(image)
    build, (cell, texel) = open_group(f"RadTex {name} Cell", Cell="Vector", Texel="Vector")
    tile = pair(width // cells, height // cells)
    pixel = build.vector("MULTIPLY_ADD", folded(build, cell, cells), tile, texel)
    color, alpha = build.image(image, pixel_centre(build, pixel, (width, height)))
    return close_group(build, Color=color, Alpha=alpha)


def _bucket_group(name: str, cell: bpy.types.ShaderNodeTree, cells: int) -> bpy.types.ShaderNodeTree:
    """Look up one texel's bucket at a place on the octahedron's square, bilinear between four cells."""
    build, (texel, place) = open_group(f"RadTex {name} Bucket", Texel="Vector", Place="Vector")
    color, alpha = bilinear(build, cell, position_of(build, place, (cells, cells)), texel)
    return close_group(build, Color=color, Alpha=alpha)


def curves_of(facts: LayeredSidecar) -> Floats:
    """The image (ROWS M, STEPS, 3) of M materials, row 0 at the bottom."""
    rows = []
    for falloff, material in zip(facts.falloff, facts.materials, strict=True):
        numbers = np.stack([material.bend, *np.log(material.variance)], axis=1)
        gloss = material.gloss or Gloss(np.zeros(3), 0.0)  # of a colour of 0: there is none
        brush = material.brush or (0.0, 0.0)
        told = np.broadcast_to([gloss.colour, [gloss.width, *brush]], (STEPS, 2, 3)).swapaxes(0, 1)
        rows += [falloff, *material.weight, numbers, *told]
    return np.stack(rows).astype(np.float32)


def curve_group(image: bpy.types.Image, materials: int) -> bpy.types.ShaderNodeTree:
    """Look up a Row of the material's curves at a Cosine, linear between steps: Color."""
    size = (STEPS, ROWS * materials)
    build, (cosine, row, material) = open_group("RadTex Curve", Cosine="Float", Row="Float", Material="Float")
    place = build.math("MULTIPLY_ADD", cosine, float(STEPS), -0.5)
    place = build.math("MINIMUM", build.math("MAXIMUM", place, 0.0), STEPS - 1.0)
    low = build.math("MINIMUM", build.math("FLOOR", place), STEPS - 2.0)
    number = build.math("MAXIMUM", build.math("ROUND", material), 0.0)
    number = build.math("MINIMUM", number, materials - 1.0)
    line = build.math("MULTIPLY_ADD", number, float(ROWS), row)
    first, second = (
        build.image(image, pixel_centre(build, build.combine(step, line), size))[0]
        for step in (low, build.math("ADD", low, 1.0))
    )
    return close_group(build, Color=build.mix(build.math("SUBTRACT", place, low), first, second))


def reflected_at(
    build: NodeBuilder, group: bpy.types.ShaderNodeTree, cosine: Socket, material: Socket, wider: Operand
) -> tuple[Socket, Socket, Socket]:
    """N.V, the material's glossy colour, 0 without gloss, and the width² of lobes so much `wider`."""
    colour, width = (build.group(group, cosine, float(row), material)[0] for row in (ROWS - 2, ROWS - 1))
    usual = build.math("POWER", 2.0, build.separate(width)[0])
    return cosine, colour, build.math("MULTIPLY", usual, wider)


def brush_at(
    build: NodeBuilder, group: bpy.types.ShaderNodeTree, material: Socket, wider: Operand
) -> tuple[Socket, Socket]:
    """The material's width² along the tangent and across it, so much `wider`; 0 where it is not brushed."""
    _, *brush = build.separate(build.group(group, 1.0, ROWS - 1.0, material)[0])
    along, across = (build.math("MULTIPLY", one, wider) for one in brush)
    return along, across


def reflected_group() -> bpy.types.ShaderNodeTree:
    """What lobes are multiplied by, as `lookup.lobes.shown_at`: Color, the Tint if Glossy is 0."""
    build, (tint, alpha, cosine, glossy, width) = open_group(
        "RadTex Reflected", Tint="Vector", Alpha="Float", Cosine="Float", Glossy="Vector", Width="Float"
    )
    colour = build.vector("MULTIPLY", tint, glossy)
    cut = build.math("MAXIMUM", build.math("MULTIPLY_ADD", width, -SATURATION, 2.0), 1e-6)
    squared = build.math("MINIMUM", build.math("DIVIDE", width, cut), 1.0)
    rough = build.math("SQRT", build.math("SQRT", squared), label="roughness")
    scale, offset = _environment(build, rough, build.math("MINIMUM", cosine, 1.0))
    facing, bare = _environment(build, rough, 1.0)
    least = build.math("MULTIPLY", alpha, bare)
    facets = build.vector("SUBTRACT", colour, build.combine(least, least, least))
    facets = build.vector("MAXIMUM", facets, (0.0, 0.0, 0.0))
    most = build.math("MAXIMUM", *build.separate(colour)[:2])
    most = build.math("MAXIMUM", most, build.separate(colour)[2])
    white = build.math("MINIMUM", build.math("MULTIPLY", most, SHADOWED), alpha)
    white = build.math("MULTIPLY", white, offset)
    scaled = build.vector("SCALE", facets, build.math("DIVIDE", scale, facing))
    shown = build.vector("ADD", scaled, build.combine(white, white, white))
    given = build.math("GREATER_THAN", build.separate(glossy)[1], 0.0)
    return close_group(build, Color=build.mix(given, tint, shown))


def _environment(build: NodeBuilder, rough: Socket, cosine: Operand) -> tuple[Socket, Socket]:
    """Karis's factor and addend, as `lookup.lobes.reflectance` has them."""
    smoothness = build.math("SUBTRACT", 1.0, rough)
    dark = build.math("POWER", 2.0, build.math("MULTIPLY", cosine, -9.28))
    grazing = build.math("MINIMUM", build.math("MULTIPLY", smoothness, smoothness), dark)
    left = build.math("MULTIPLY_ADD", rough, -0.0275, 0.0425)
    grazing = build.math("MULTIPLY_ADD", grazing, smoothness, left)
    scale = build.math("MULTIPLY_ADD", grazing, -1.04, build.math("MULTIPLY_ADD", rough, -0.572, 1.04))
    offset = build.math("MULTIPLY_ADD", grazing, 1.04, build.math("MULTIPLY_ADD", rough, 0.022, -0.04))
    return scale, offset


def curves_at(
    build: NodeBuilder, group: bpy.types.ShaderNodeTree, cosine: Socket, material: Socket
) -> tuple[Socket, Socket, Socket, Socket, tuple[Socket, Socket]]:
    """The falloff, both lobes' weights, the bend, and both widths²."""
    falloff, first, second, numbers = (
        build.group(group, cosine, float(row), material)[0] for row in range(ROWS - 2)
    )
    bend, *logarithms = build.separate(numbers)
    narrow, wide = (build.math("EXPONENT", one) for one in logarithms)
    return falloff, first, second, bend, (narrow, wide)
