# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The material that shows a layered bake on its baked copy, in Eevee and Cycles."""

from __future__ import annotations

import logging
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, cast

import bpy

from ....core.errors import InputError
from ....formats.containers.exr import Compression, stored_rows, write_rows
from ....formats.disk.atomic import replacing
from ....formats.disk.temporary import temporary_folder
from ....formats.image_files import Shapes, layer_path
from ....formats.sidecar_file import AnySidecar, opened
from ....preview.material import build_frame_group, load_atlas
from ....preview.node_group import MAX_PIXELS
from ....scene.image_materials import ImageMaterial
from ....scene.mesh.copy import MATERIAL
from ....scene.nodes import NodeBuilder, Operand, open_material
from ..files.arrangement import OF_IMAGES
from ..files.layered_files import read_layered_sidecar
from ..files.sidecar import LayeredSidecar
from .group import CURVES, SHOWS_THROUGH, build_layered_group
from .images import curves_of
from .own_images import given_by_images, keep_images

log = logging.getLogger(__name__)


def preview_layered_material(
    name: str, sidecar: Path, uv_layer: str, half: bool = True, hull: bool = False
) -> bpy.types.Material:
    """A material that shows a bake in the layered layout on its baked copy: it emits the light.

    The images lie beside the file `sidecar`. It is transparent where the bake has an alpha. `uv_layer` is the
    baked UV layer, `half` is as in `load_atlas`. With `hull` only front faces are visible. Raises
    FormatError for files that are not of such a bake, InputError if an image is missing or larger than a GPU
    takes.
    """
    images, facts = load_images(sidecar, half)
    if facts.through is not None and not SHOWS_THROUGH:
        log.warning(
            "the preview of '%s' lacks the light that comes through it, for which Blender 4.5 has too little "
            "room: open the bake in a later Blender, or export it",
            facts.bake.object_name,
        )
    material, build = open_material(name)
    sampler = build_layered_group(images, facts)
    _show(material, build, sampler, uv_layer, hull, clear="alpha" in images)
    return material


def preview_materials_of_images(
    name: str,
    sidecar: Path,
    uv_layer: str,
    own: Mapping[int, ImageMaterial],
    half: bool = True,
    hull: bool = False,
) -> dict[int, bpy.types.Material]:
    """Materials by number that show such a bake by their `own` images, for those that the bake says can.

    What is not asked of the images is looked up as by `preview_layered_material`, whose arguments the others
    are; raises as that does.
    """
    facts = read_layered_sidecar(opened(sidecar))
    looks = {number: look for number, look in enumerate(facts.looks) if look is not None and number in own}
    if not looks:
        return {}
    images, facts = load_images(sidecar, half, without=OF_IMAGES)
    sampler = build_layered_group(images, facts, of_images=True)
    found = {}
    for number, look in looks.items():
        found[number], build = open_material(f"{name} {number}" if len(facts.materials) > 1 else name)
        keep_images(found[number], build.tree, own[number], number)
        given = given_by_images(build, own[number], look, hull)
        _show(found[number], build, sampler, uv_layer, hull, "alpha" in images, given)
    return found


def _show(
    material: bpy.types.Material,
    build: NodeBuilder,
    sampler: bpy.types.ShaderNodeTree,
    uv_layer: str,
    hull: bool,
    clear: bool,
    given: Sequence[Operand] = (),
) -> None:
    """Make an empty material show what the `sampler` looks up; `given` are its inputs of the material."""
    cast(Any, material).cycles.emission_sampling = "NONE"  # rays see it, but Cycles does not sample it
    place = (build.geometry("Incoming"), build.geometry("Position"), build.attribute(MATERIAL, "Fac"))
    frame = build.group(build_frame_group())
    color, alpha = build.group(sampler, build.uv_map(uv_layer), *frame, *place, *given)
    front = build.math("SUBTRACT", 1.0, build.geometry("Backfacing")) if hull else 1.0
    surface = build.node("ShaderNodeEmission", color, front).outputs[0]
    if hull or clear:
        opaque = build.math("MULTIPLY", alpha, front)
        behind = build.node("ShaderNodeBsdfTransparent", build.math("SUBTRACT", 1.0, opaque)).outputs[0]
        surface = build.node("ShaderNodeAddShader", surface, behind).outputs[0]
    build.node("ShaderNodeOutputMaterial", surface)
    build.arrange()


def load_images(
    sidecar: AnySidecar, half: bool = True, without: Collection[str] = ()
) -> tuple[dict[str, bpy.types.Image], LayeredSidecar]:
    """Load a bake's images by layer, and that of its materials' curves; and read its sidecar.

    Layers that it is `without` are left out. No image is converted to the scene's working space: the nodes
    multiply colours in Rec.709, as the bake did. Raises as `preview_layered_material` does.
    """
    file = opened(sidecar)
    facts = read_layered_sidecar(file)
    check_layered_previewable(facts.shapes)
    layers = [layer for layer in facts.shapes if layer not in without]
    images = {layer: load_atlas(layer_path(file.path, layer), half, data=True) for layer in layers}
    return images | {CURVES: _packed_curves(file.path, facts)}, facts


def check_layered_previewable(shapes: Shapes, max_pixels: int = MAX_PIXELS) -> None:
    """Raise InputError where an image of the bake has more than `max_pixels` along a side."""
    for layer, (width, height, _) in shapes.items():
        if max(width, height) > max_pixels:
            raise InputError(
                f"the layer '{layer}' has {width} x {height} pixels and cannot be previewed, a GPU takes "
                f"{max_pixels} a side; bake fewer texels"
            )


def _packed_curves(sidecar: Path, facts: LayeredSidecar) -> bpy.types.Image:
    """The materials' curves as an image of floats that is packed into the .blend."""
    with temporary_folder() as folder:
        path = layer_path(folder / sidecar.name, CURVES)
        rows, _ = stored_rows(path, curves_of(facts), half=False)
        with replacing(path, lasting=False) as beside:
            write_rows(beside, rows, facts.to_json(), Compression.ZIP)
        image = load_atlas(path, half=False, data=True)
        image.pack()
        image.filepath_raw = ""  # the temporary file will be gone
    return image
