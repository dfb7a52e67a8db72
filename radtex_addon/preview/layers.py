# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A preview that shows one layer of its bake: the same lookups, in another image."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any, cast

import bpy

from ..bake.forms import layers_apart
from ..core.errors import InputError
from ..formats.bucket_files import image_path
from ..formats.sidecar import Sidecar, read_facts
from .load import OURS
from .material import load_atlas
from .save import images_of

_DATA = "normal"  # the one layer that is no light


def check_layer(sidecar: Path, layer: str) -> None:
    """Raise InputError for a layer that the bake with this sidecar does not have, or that lacks its image."""
    facts = read_facts(sidecar)
    layers = Sidecar.from_facts(facts).layers if layers_apart(str(facts.values.get("layout"))) else ()
    if layer not in layers:
        known = ", ".join(layers) or "none"
        raise InputError(
            f"{sidecar} has no layer {layer}, its layers are: {known}; show one of them, or the whole"
        )
    image = image_path(sidecar, layer)
    if not image.is_file():
        raise InputError(f"{image} is missing: put it back, or bake again")


def wear_layer(meshes: Iterable[bpy.types.Mesh], sidecar: Path, layer: str) -> None:
    """Have the meshes of a bake's preview show a layer, which is there, in the place of the whole; opaque.

    The base, an image of one pixel a texel, is found by the same lookups. Raises FormatError for an image
    that cannot be read.
    """
    shown = load_atlas(image_path(sidecar, layer).absolute(), data=layer == _DATA)
    cast(Any, shown)[OURS] = True
    whole = sidecar.with_suffix(".exr").absolute()
    materials = {material for mesh in meshes for material in mesh.materials if material is not None}
    for image in {image for material in materials for image in images_of(material.node_tree)}:
        if Path(bpy.path.abspath(image.filepath)) == whole:
            image.user_remap(shown)
