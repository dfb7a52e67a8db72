# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The material that shows a baked atlas on its baked copy, in Eevee and Cycles.

The copy's mesh stores the frame, which nodes cannot compute, as attributes: `radtex_normal` and
`radtex_tangent` (object space, one vector per corner) and `radtex_sign` (one number per corner, the
bitangent's sign in object space).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import bpy

from ..core.atlas import AtlasLayout
from ..core.errors import FormatError, InputError
from ..core.sampler import Filter
from ..scene.nodes import close_group, open_group, open_material
from .node_group import build_sample_group
from .taps import image_size


def load_atlas(path: Path, half: bool = True, data: bool = False) -> bpy.types.Image:
    """Load an atlas file as an image whose values reach the shader as they are in the file.

    The colour space is Linear Rec.709, which Blender converts if the file works in another space; `data` that
    is not light is never converted. Alpha stays premultiplied. `half` halves the memory, without loss if the
    file is half float. A file that was loaded before is read again. Raises InputError if there is no such
    file, FormatError if it holds no image.
    """
    try:
        image = bpy.data.images.load(str(path), check_existing=True)
    except RuntimeError as error:
        raise InputError(f"{path}: no atlas to preview; bake it first") from error
    space = "Non-Color" if data else "Linear Rec.709"
    cast(Any, image.colorspace_settings).name = space  # the stubs know no OCIO names
    image.alpha_mode = "CHANNEL_PACKED"
    image.use_half_precision = half
    image.reload()
    if 0 in image_size(image):
        bpy.data.images.remove(image)
        raise FormatError(f"{path}: Blender reads no image in it; bake it again")
    return image


def preview_material(
    name: str,
    atlas: Path,
    layout: AtlasLayout,
    uv_layer: str,
    kind: Filter,
    half: bool = True,
    hull: bool = False,
) -> bpy.types.Material:
    """A material that shows the atlas file on the baked copy: it emits the light, transparent by 1 - alpha.

    `uv_layer` is the baked UV layer, `half` is as in `load_atlas`. A `reflection` atlas looks like a perfect
    mirror, an `incident` one shows the light that arrives from the viewer's direction. With `hull`, which is
    also for objects that light passes through, only front faces are visible: the atlas already contains what
    is seen through the surface, and back faces would show it twice. Raises as `load_atlas` and
    `build_sample_group` do.
    """
    sampler = build_sample_group(load_atlas(atlas, half), layout, kind)
    material, build = open_material(name)
    cast(Any, material).cycles.emission_sampling = "NONE"  # rays see it, but Cycles does not sample it
    uv, frame = build.uv_map(uv_layer), build.group(build_frame_group())
    color, alpha = build.group(sampler, uv, *frame, build.geometry("Incoming"))
    front = build.math("SUBTRACT", 1.0, build.geometry("Backfacing")) if hull else 1.0
    emission = build.node("ShaderNodeEmission", color, front)
    opaque = build.math("MULTIPLY", alpha, front) if hull else alpha
    behind = build.node("ShaderNodeBsdfTransparent", build.math("SUBTRACT", 1.0, opaque))
    surface = build.node("ShaderNodeAddShader", emission.outputs[0], behind.outputs[0])
    build.node("ShaderNodeOutputMaterial", surface.outputs[0])
    build.arrange()
    return material


def build_frame_group() -> bpy.types.ShaderNodeTree:
    """A node group without inputs: the copy's Normal, Tangent and Sign at the shaded point, in world space.

    With M the object's matrix and d the sign of its determinant, -1 for a mirrored object or instance: the
    tangent is parallel to M T, the sign is d times the mesh's, and the normal is parallel to d cof(M) N, as
    inverse(transpose(M)) N is. (The Vector Transform node could transform normals, but in 4.5's Eevee its
    result is wrong if M scales axes differently.)
    """
    build, _ = open_group("RadTex Frame")
    x, y, z = (
        build.transform(axis, "VECTOR") for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    )
    cofactors = [build.vector("CROSS_PRODUCT", *axes) for axes in ((y, z), (z, x), (x, y))]
    d = build.math("SIGN", build.vector("DOT_PRODUCT", x, cofactors[0]), label="mirrored?")
    parts = zip(cofactors, build.separate(build.attribute("radtex_normal")), strict=True)
    along_x, along_y, along_z = (build.vector("SCALE", cofactor, part) for cofactor, part in parts)
    outward = build.vector("ADD", build.vector("ADD", along_x, along_y), along_z)
    tangent = build.vector("NORMALIZE", build.transform(build.attribute("radtex_tangent"), "VECTOR"))
    sign = build.math("MULTIPLY", d, build.attribute("radtex_sign", "Fac"))
    return close_group(build, Normal=build.vector("SCALE", outward, d), Tangent=tangent, Sign=sign)
