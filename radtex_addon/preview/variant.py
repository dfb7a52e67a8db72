# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which light a bake shows: kind, frame, lamps, layers. Previews store it, as their sidecar may be gone.

A layer is shown by the same nodes, with another image.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import bpy

from ..core.errors import InputError
from ..formats.bucket_files import image_path
from ..formats.json_reader import Facts
from ..formats.sidecar import Sidecar
from ..formats.sidecar_file import AnySidecar, SidecarFile, read_facts
from ..settings.forms import has_light_layers
from ..settings.options import MARKED
from .load import PREVIEW_TAG
from .material import load_atlas
from .save import images_of

_DATA = "normal"  # the only layer that does not hold light
_KEPT = "radtex_variant"  # custom property of a copy: JSON, as in a sidecar
_KEYS = ("kind", "layout", "frame", "lights", "layers", *MARKED)


@dataclass(frozen=True)
class Variant:
    """A bake's `kind`, its `frame` if one was specified, and its lamps `lights`, () for all light.

    `layers` are those that can be shown alone, `marks` the options that its sidecar marks.
    """

    kind: str = "radiance"
    frame: int | None = None
    lights: tuple[str, ...] = ()
    layers: tuple[str, ...] = ()
    marks: tuple[str, ...] = ()


def read_variant(sidecar: AnySidecar) -> Variant:
    """Read a bake's variant from its sidecar. Raises FormatError."""
    return _variant_in(read_facts(sidecar))


def keep_variant(copy: Any, sidecar: AnySidecar) -> None:
    """Store on a preview the variant of its bake. Raises FormatError."""
    facts = read_facts(sidecar).values
    copy[_KEPT] = json.dumps({key: facts[key] for key in _KEYS if key in facts})


def kept_variant(copy: Any) -> Variant:
    """The variant stored on a preview; if there is none, radiance of all light."""
    kept = copy.get(_KEPT)
    return Variant() if not isinstance(kept, str) else _variant_in(Facts.parse(kept, f"'{copy.name}'"))


def _variant_in(facts: Facts) -> Variant:
    return Variant(
        facts.text("kind"),
        facts.whole_number("frame", 0) if "frame" in facts.values else None,
        facts.texts("lights") if "lights" in facts.values else (),
        facts.texts("layers") if has_light_layers(facts.text("layout")) else (),
        tuple(name for name in MARKED if facts.values.get(name) is True),
    )


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
