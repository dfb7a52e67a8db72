# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Show one layer of a bake in its preview: the same nodes, with another image."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any, cast

import bpy

from ..bake.forms import has_light_layers
from ..core.errors import InputError
from ..formats.bucket_files import image_path
from ..formats.sidecar import Sidecar
from ..formats.sidecar_file import SidecarFile
from .load import PREVIEW_TAG
from .material import load_atlas
from .save import images_of

_DATA = "normal"  # the only layer that does not hold light


def check_layer(sidecar: SidecarFile, layer: str) -> None:
    """Raise InputError if the bake with this sidecar has no such layer, or the layer's image is missing."""
    facts = sidecar.facts
    layers = Sidecar.from_facts(facts).layers if has_light_layers(str(facts.values.get("layout"))) else ()
    if layer not in layers:
        known = ", ".join(layers) or "none"
        raise InputError(
            f"{sidecar} has no layer {layer}, its layers are: {known}; show one of these, or all of the light"
        )
    image = image_path(sidecar.path, layer)
    if not image.is_file():
        raise InputError(f"{image} is missing: put it back, or bake again")


def show_layer(meshes: Iterable[bpy.types.Mesh], sidecar: SidecarFile, layer: str) -> None:
    """Make a preview's meshes show a layer, which `check_layer` accepts, instead of the whole; it is opaque.

    The layer `base` needs no other nodes, although its image has one pixel per texel. Raises FormatError for
    an image that cannot be read.
    """
    shown = load_atlas(image_path(sidecar.path, layer).absolute(), data=layer == _DATA)
    cast(Any, shown)[PREVIEW_TAG] = True
    whole = sidecar.path.with_suffix(".exr").absolute()
    materials = {material for mesh in meshes for material in mesh.materials if material is not None}
    for image in {image for material in materials for image in images_of(material.node_tree)}:
        if Path(bpy.path.abspath(image.filepath)) == whole:
            image.user_remap(shown)
