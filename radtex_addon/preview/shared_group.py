# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""`core.shared.sample_shared` as native shader nodes, alike in Eevee and Cycles: the group "RadTex Shared".

Each step is a group of its own, so that the tree reads like the maths: octahedron, bucket, surroundings,
falloff. Octahedral images have a border of one cell, a copy of the cells across their edges on the sphere, so
that lookups need no special case there. A condensed bake has one more step, between a texel and its buckets.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise

import bpy

from ..core.errors import InputError
from ..core.shared import Axis
from ..formats.packing import (
    COLOUR,
    ENDS,
    GAIN,
    IRRADIANCE,
    REST,
    SURROUNDINGS,
    WEIGHTS,
    level_places,
    lobe_layer,
)
from ..formats.shared_sidecar import SharedSidecar
from ..scene.nodes import NodeBuilder, Socket, close_group, open_group
from ..scene.working_space import rec709_primaries
from .condensed_group import image_layer, mixture_group
from .node_group import MAX_PIXELS
from .taps import bilinear, pair, pixel_centre, readable_size

_LEAST_SPREAD = 1e-12  # as in core.shared.level_weights
_TINY = 1e-30  # avoids 0/0, as in core.octahedron

_Images = Mapping[str, bpy.types.Image]
_Triple = tuple[float, float, float]


def build_shared_group(images: _Images, sidecar: SharedSidecar) -> bpy.types.ShaderNodeTree:
    """A node group that samples the sidecar's `images`, by layer, as `core.shared.sample_shared` does.

    Inputs: UV (0..1, v up); Normal and Incoming, world space, of any length (Incoming points to the viewer;
    if it is zero, the shaded point's own is used). Output: Color, in the file's working space. `images` and
    sidecar come from `load_layers`. Raises InputError if an image does not have the size in the sidecar, or
    is larger than a GPU takes.
    """
    check_shared_previewable(sidecar)
    _check_sizes(images, sidecar)
    octahedron, around = octahedron_group(), _surroundings_group(images[SURROUNDINGS], sidecar)
    inputs = {"UV": "Vector", "Normal": "Vector", "Incoming": "Vector"}
    build, (uv, normal, incoming) = open_group("RadTex Shared", **inputs)
    n = build.vector("NORMALIZE", normal, label="N")
    unset = build.math("LESS_THAN", build.vector("LENGTH", incoming), _TINY)
    viewer = build.vector("NORMALIZE", build.mix(unset, incoming, build.geometry("Incoming")), label="V")
    facing = build.vector("DOT_PRODUCT", n, viewer, label="N.V")
    (colour,) = build.group(_map_group("Colour", images[COLOUR]), uv)
    (irradiance,) = build.group(_map_group("Irradiance", images[IRRADIANCE]), uv)
    (falloff,) = build.group(_falloff_group(sidecar.falloff), facing)
    light = build.vector("MULTIPLY", build.vector("MULTIPLY", colour, irradiance), falloff, label="scattered")
    through = build.vector("SCALE", viewer, -1.0, label="through")
    twice = build.math("MULTIPLY", facing, 2.0)
    axes = {
        Axis.MIRROR: build.vector("ADD", build.vector("SCALE", n, twice), through, label="mirrored"),
        Axis.THROUGH: through,
    }
    for axis in sidecar.lobes:
        (lobe,) = build.group(_lobe_group(axis, images, sidecar, octahedron, around), uv, axes[axis])
        light = build.vector("ADD", light, lobe)
    shown = build.mix(1.0, light, (0.0, 0.0, 0.0, 1.0), "RGBA", "LIGHTEN")
    return close_group(build, Color=in_working_space(build, shown))


def check_shared_previewable(sidecar: SharedSidecar, max_pixels: int = MAX_PIXELS) -> None:
    """Raise InputError where an image of the bake has more than `max_pixels` along a side."""
    for layer, (width, height, _) in sidecar.shapes.items():
        if max(width, height) > max_pixels:
            raise InputError(
                f"the layer '{layer}' has {width} x {height} pixels and cannot be previewed, a GPU takes "
                f"{max_pixels} a side; bake fewer texels, or smaller buckets"
            )


def _check_sizes(images: _Images, sidecar: SharedSidecar) -> None:
    for layer, (width, height, _) in sidecar.shapes.items():
        image = images[image_layer(layer)]
        actual = readable_size(image)
        if actual != (width, height):
            raise InputError(
                f"{image.name}: {actual[0]} x {actual[1]} pixels, but this bake's '{layer}' has "
                f"{width} x {height}; use the sidecar that belongs to this image"
            )


def _lobe_group(
    axis: Axis,
    images: _Images,
    sidecar: SharedSidecar,
    octahedron: bpy.types.ShaderNodeTree,
    around: bpy.types.ShaderNodeTree,
) -> bpy.types.ShaderNodeTree:
    """gain(uv, A) surroundings(A + shift(uv, A), spread(uv, A)) + rest(uv, A)."""
    width, height = sidecar.bake.width, sidecar.bake.height
    bucket = _texel_group(axis, images, sidecar)
    build, (uv, along) = open_group(f"RadTex {axis.title()}", UV="Vector", Axis="Vector")
    position, last = _position(build, uv, (width, height)), pair(width - 1, height - 1)
    place, in_turn = _place(build, octahedron, along), sidecar.condensed is not None
    shift, spread, gain, rest = bilinear(build, bucket, position, place, last=last, in_turn=in_turn)
    end = build.vector("ADD", along, shift, label="where it comes from")
    (met,) = build.group(around, _place(build, octahedron, end), spread)
    return close_group(build, Light=build.vector("MULTIPLY_ADD", gain, met, rest))


def _texel_group(axis: Axis, images: _Images, sidecar: SharedSidecar) -> bpy.types.ShaderNodeTree:
    """Look up a texel's bucket at a place on the octahedron: its own, or a mixture of its cluster's."""
    n, condensed = sidecar.bake.bucket, sidecar.condensed
    bucket = _bucket_group(_cell_group(axis, images, n), axis, n)
    if condensed is None:
        return bucket
    weights = images[lobe_layer(axis, WEIGHTS)]
    return mixture_group(axis, bucket, weights, condensed.rank, condensed.columns)


def _bucket_group(cell: bpy.types.ShaderNodeTree, axis: Axis, cells: int) -> bpy.types.ShaderNodeTree:
    """Look up one bucket of the images at a place on the octahedron, bilinear between four cells."""
    build, (texel, place) = open_group(f"RadTex {axis.title()} Bucket", Texel="Vector", Place="Vector")
    shift, spread, gain, rest = bilinear(build, cell, _position(build, place, (cells, cells)), texel)
    return close_group(build, Shift=shift, Spread=spread, Gain=gain, Rest=rest)


def _cell_group(axis: Axis, images: _Images, n: int) -> bpy.types.ShaderNodeTree:
    """Look up one cell of one bucket in the lobe's images: the pixel (i (n+2) + 1 + x, j (n+2) + 1 + y).

    The spread is returned as stored, in units of the sidecar's `sharpest`.
    """
    ends, gain, rest = (images[lobe_layer(axis, part)] for part in (ENDS, GAIN, REST))
    build, (cell, texel) = open_group(f"RadTex {axis.title()} Cell", Cell="Vector", Texel="Vector")
    pixel = build.vector("MULTIPLY_ADD", texel, pair(n + 2, n + 2), build.vector("ADD", cell, pair(1, 1)))
    centre = pixel_centre(build, pixel, readable_size(ends))
    shift, spread = build.image(ends, centre)
    taken, own = (build.image(image, centre)[0] for image in (gain, rest))
    return close_group(build, Shift=shift, Spread=spread, Gain=taken, Rest=own)


def _surroundings_group(image: bpy.types.Image, sidecar: SharedSidecar) -> bpy.types.ShaderNodeTree:
    """Look up the surroundings blurred by a variance in units of `sharpest`, blending two levels."""
    level_group = _level_group(image, sidecar)
    build, (place, spread) = open_group("RadTex Surroundings", Place="Vector", Spread="Float")
    least = build.math("MAXIMUM", spread, _LEAST_SPREAD / sidecar.sharpest)
    exact = build.math("DIVIDE", build.math("LOGARITHM", least, 2.0), 2.0)
    level = build.math("MINIMUM", build.math("MAXIMUM", exact, 0.0), sidecar.levels - 1.0, label="level")
    sharper = build.math("FLOOR", level)
    taken = (sharper, build.math("ADD", sharper, 1.0))
    sharp, blurred = (build.group(level_group, place, number)[0] for number in taken)
    return close_group(build, Light=build.mix(build.math("FRACT", level), sharp, blurred, "RGBA"))


def _level_group(image: bpy.types.Image, sidecar: SharedSidecar) -> bpy.types.ShaderNodeTree:
    """Look up one level of the surroundings, a whole number up to the last, bilinear between four cells."""
    cell = _surroundings_cell_group(image)
    build, (place, level) = open_group("RadTex Level", Place="Vector", Level="Float")
    reached = [build.math("GREATER_THAN", level, number + 0.5) for number in range(sidecar.levels - 1)]
    places = list(level_places(sidecar.surroundings, sidecar.levels))
    x, y, side = build.separate(_climb(build, places, reached))
    cells = build.vector("SCALE", place, side)
    position = build.vector("SUBTRACT", cells, pair(0.5, 0.5), label="position, in cells")
    (light,) = bilinear(build, cell, position, build.combine(x, y))
    return close_group(build, Light=light)


def _surroundings_cell_group(image: bpy.types.Image) -> bpy.types.ShaderNodeTree:
    """Look up one cell of the level whose border begins at the pixel Corner."""
    build, (cell, corner) = open_group("RadTex Surroundings Cell", Cell="Vector", Corner="Vector")
    pixel = build.vector("ADD", build.vector("ADD", cell, corner), pair(1, 1), label="pixel")
    return close_group(build, Light=build.image(image, pixel_centre(build, pixel, readable_size(image)))[0])


def _falloff_group(falloff: Sequence[_Triple]) -> bpy.types.ShaderNodeTree:
    """The falloff curve at a cosine, interpolated linearly between its points."""
    build, (cosine,) = open_group("RadTex Falloff", Cosine="Float")
    place = build.math("MULTIPLY_ADD", cosine, float(len(falloff)), -0.5, label="position, in points")
    passed = [
        build.node("ShaderNodeMath", place, float(point), operation="SUBTRACT", use_clamp=True).outputs[0]
        for point in range(len(falloff) - 1)
    ]
    return close_group(build, Falloff=_climb(build, falloff, passed))


def in_working_space(build: NodeBuilder, colour: Socket) -> Socket:
    """Convert a Rec.709 colour to the file's working space.

    Rec.709's primaries are stored as colours, so that Blender converts them if the file's working space is
    changed, or if the nodes are appended to a file with another one.
    """
    shown: Socket | tuple[float, ...] = (0.0, 0.0, 0.0, 1.0)
    for share, primary in zip(build.separate(colour), rec709_primaries(), strict=True):
        shown = build.mix(share, shown, (*primary, 1.0), "RGBA", "ADD")
    assert isinstance(shown, bpy.types.NodeSocket)  # there are three primaries
    return shown


def _map_group(name: str, image: bpy.types.Image) -> bpy.types.ShaderNodeTree:
    """Look up an image with one colour per texel at UV, bilinear between four texels."""
    width, height = readable_size(image)
    tap, (texel,) = open_group(f"RadTex {name} Texel", Texel="Vector")
    color, _ = tap.image(image, pixel_centre(tap, texel, (width, height)))
    texels = close_group(tap, Color=color)
    build, (uv,) = open_group(f"RadTex {name}", UV="Vector")
    position, last = _position(build, uv, (width, height)), pair(width - 1, height - 1)
    (color,) = bilinear(build, texels, position, last=last)
    return close_group(build, Color=color)


def octahedron_group() -> bpy.types.ShaderNodeTree:
    """Direction, of any length, to Place in [0, 1]^2, as `core.octahedron.direction_to_octahedron`."""
    build, (direction,) = open_group("RadTex Octahedron", Direction="Vector")
    length = build.vector("DOT_PRODUCT", build.vector("ABSOLUTE", direction), (1.0, 1.0, 1.0))
    scale = build.math("DIVIDE", 1.0, build.math("MAXIMUM", length, _TINY))
    flat = build.vector("SCALE", direction, scale, label="|x| + |y| + |z| = 1")
    x, y, z = build.separate(flat)
    swapped = build.combine(y, x)
    inside = build.vector("SUBTRACT", (1.0, 1.0, 0.0), build.vector("ABSOLUTE", swapped))
    side = build.vector("SIGN", build.vector("ADD", flat, pair(_TINY, _TINY)), label="zero is positive")
    folded = build.vector("MULTIPLY", inside, side, label="the lower half, folded outwards")
    square = build.mix(build.math("LESS_THAN", z, 0.0), flat, folded)
    return close_group(build, Place=build.vector("MULTIPLY_ADD", square, pair(0.5, 0.5), pair(0.5, 0.5)))


def _place(build: NodeBuilder, octahedron: bpy.types.ShaderNodeTree, direction: Socket) -> Socket:
    return build.group(octahedron, direction)[0]


def _position(build: NodeBuilder, place: Socket, size: tuple[int, int]) -> Socket:
    """Scale a place in [0, 1]^2 to texels or cells, whose centres are at whole numbers."""
    return build.vector("MULTIPLY_ADD", place, pair(*size), pair(-0.5, -0.5), label="position")


def _climb(build: NodeBuilder, values: Sequence[_Triple], shares: Iterable[Socket]) -> Socket:
    """The first value plus each difference to the next, times its share: a piecewise linear curve."""
    total = build.combine(*values[0])
    for (low, high), share in zip(pairwise(values), shares, strict=True):
        step = tuple(b - a for a, b in zip(low, high, strict=True))
        total = build.vector("MULTIPLY_ADD", share, step, total)
    return total
