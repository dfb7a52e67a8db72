# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The reference sampler as native shader nodes, alike in Eevee and Cycles: the group "RadTex Sample".

Each step is a group of its own, so that the tree reads like the maths: incidence, bucket, texels, cells.
"""

from __future__ import annotations

import bpy

from ..core.atlas import AtlasLayout
from ..core.errors import InputError
from ..core.frame import DEGENERATE
from ..core.sampler import Filter
from ..scene.nodes import close_group, open_group
from .taps import bilinear, clamp, pair, readable_size

MAX_PIXELS = 16384  # the image side that every current GPU takes; Eevee shrinks a larger one, silently

FRAME = {"Normal": "Vector", "Tangent": "Vector", "Sign": "Float"}
_TINY = 1e-30  # avoids 0/0, as in core.hemisphere


def build_sample_group(
    image: bpy.types.Image, layout: AtlasLayout, kind: Filter, max_pixels: int = MAX_PIXELS
) -> bpy.types.ShaderNodeTree:
    """A node group that samples the atlas `image` as `core.sampler.sample` does.

    Inputs: UV (0..1, v up); Normal, Tangent and Incoming, vectors of any length in one space (Incoming points
    to the viewer; if it is zero, the shaded point's own is used, in world space); Sign, the bitangent's in
    that space. Outputs: Color (premultiplied) and Alpha. `image` comes from `load_atlas`. Raises InputError
    if the atlas is not an image of `layout` or has more than `max_pixels` along a side.
    """
    check_previewable(layout, max_pixels)
    check_image(image, layout)
    texel = _texel_group(pixel_group(image, layout), layout, kind)
    build, (uv, *vectors) = open_group("RadTex Sample", UV="Vector", **FRAME, Incoming="Vector")
    (incidence,) = build.group(incidence_group(), *vectors)
    (b,) = build.group(bucket_group(), incidence)
    size, last = pair(layout.width, layout.height), pair(layout.width - 1, layout.height - 1)
    if kind is Filter.QUADRILINEAR:
        position = build.vector("MULTIPLY_ADD", uv, size, pair(-0.5, -0.5), label="position, in texels")
        color, alpha = bilinear(build, texel, position, b, last=last)
    else:
        inside = build.vector("FLOOR", build.vector("MULTIPLY", uv, size))
        color, alpha = build.group(texel, clamp(build, inside, last), b)
    return close_group(build, Color=color, Alpha=alpha)


def check_previewable(layout: AtlasLayout, max_pixels: int = MAX_PIXELS) -> None:
    """Raise InputError where an atlas of `layout` has more than `max_pixels` along a side."""
    width, height = layout.pixel_width, layout.pixel_height
    if max(width, height) > max_pixels:
        raise InputError(
            f"an atlas of {width} x {height} pixels cannot be previewed, a GPU takes {max_pixels} a side; "
            f"bake at most {max_pixels // layout.bucket} texels of {layout.bucket} cells, or smaller buckets"
        )


def check_image(image: bpy.types.Image, layout: AtlasLayout) -> None:
    """Raise InputError where the image is not of the layout's size, FormatError where it cannot be read."""
    width, height = layout.pixel_width, layout.pixel_height
    actual = readable_size(image)
    if actual != (width, height):
        raise InputError(
            f"{image.name}: {actual[0]} x {actual[1]} pixels, but {layout.width} x {layout.height} texels of "
            f"{layout.bucket} cells have {width} x {height}; use the sidecar that belongs to this atlas"
        )


def incidence_group() -> bpy.types.ShaderNodeTree:
    """The vector towards the viewer in the frame (T, Bt, N) that `core.frame.orthonormal_frame` makes."""
    build, inputs = open_group("RadTex Incidence", **FRAME, Incoming="Vector")
    normal, tangent, sign, incoming = inputs
    n = build.vector("NORMALIZE", normal, label="N")
    along = build.vector("NORMALIZE", tangent)
    flat = build.vector("SUBTRACT", along, build.vector("SCALE", n, build.vector("DOT_PRODUCT", n, along)))
    upright = build.math("LESS_THAN", build.math("ABSOLUTE", build.separate(n)[2]), 0.9)
    fallback = build.vector("CROSS_PRODUCT", build.mix(upright, (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)), n)
    degenerate = build.math("LESS_THAN", build.vector("DOT_PRODUCT", flat, flat), DEGENERATE)
    t = build.vector("NORMALIZE", build.mix(degenerate, flat, fallback), label="T")
    bt = build.vector("SCALE", build.vector("CROSS_PRODUCT", n, t), build.math("SIGN", sign), label="Bt")
    unset = build.math("LESS_THAN", build.vector("LENGTH", incoming), _TINY)
    viewer = build.vector("NORMALIZE", build.mix(unset, incoming, build.geometry("Incoming")), label="viewer")
    local = build.combine(*(build.vector("DOT_PRODUCT", viewer, axis) for axis in (t, bt, n)))
    return close_group(build, Incidence=local)


def bucket_group() -> bpy.types.ShaderNodeTree:
    """Direction in the frame to B in [-1, 1]^2, as `core.hemisphere.direction_to_square`."""
    build, (incidence,) = open_group("RadTex Bucket", Incidence="Vector")
    x, y, z = build.separate(incidence)
    root = build.math("SQRT", build.math("MAXIMUM", build.math("ADD", z, 1.0), _TINY))
    disc = build.combine(build.math("DIVIDE", x, root), build.math("DIVIDE", y, root))
    beyond = build.math("MAXIMUM", build.vector("LENGTH", disc), 1.0, label="below the horizon")
    a = build.vector("SCALE", disc, build.math("DIVIDE", 1.0, beyond), label="A")
    ax, ay, _ = build.separate(build.vector("ABSOLUTE", a))
    widest = build.math("MAXIMUM", build.math("MAXIMUM", ax, ay), _TINY)
    stretch = build.math("DIVIDE", build.vector("LENGTH", a), widest, label="|A| / max(|A.x|, |A.y|)")
    return close_group(build, B=build.vector("SCALE", a, stretch, label="B"))


def _texel_group(
    pixel: bpy.types.ShaderNodeTree, layout: AtlasLayout, kind: Filter
) -> bpy.types.ShaderNodeTree:
    """Look up one texel's bucket at B: the nearest cell, or bilinear between four cells of this bucket."""
    build, (texel, b) = open_group("RadTex Texel", Texel="Vector", B="Vector")
    half, last = layout.bucket / 2, pair(layout.bucket - 1, layout.bucket - 1)
    if kind is Filter.NEAREST:
        inside = build.vector("FLOOR", build.vector("MULTIPLY_ADD", b, pair(half, half), pair(half, half)))
        color, alpha = build.group(pixel, clamp(build, inside, last), texel)
    else:
        centre = pair(half - 0.5, half - 0.5)
        position = build.vector("MULTIPLY_ADD", b, pair(half, half), centre, label="position, in cells")
        guarded = clamp(build, position, last, label="bleed guard")
        color, alpha = bilinear(build, pixel, guarded, texel, last=last)
    return close_group(build, Color=color, Alpha=alpha)


def pixel_group(image: bpy.types.Image, layout: AtlasLayout) -> bpy.types.ShaderNodeTree:
    """Look up one cell of one texel: the pixel (i n + p, j n + q), read at its centre."""
    build, (cell, texel) = open_group("RadTex Pixel", Cell="Vector", Texel="Vector")
    width, height = layout.pixel_width, layout.pixel_height
    pixel = build.vector("MULTIPLY_ADD", texel, pair(layout.bucket, layout.bucket), cell, label="pixel")
    to_uv, centre = pair(1 / width, 1 / height), pair(0.5 / width, 0.5 / height)
    color, alpha = build.image(image, build.vector("MULTIPLY_ADD", pixel, to_uv, centre))
    return close_group(build, Color=color, Alpha=alpha)
