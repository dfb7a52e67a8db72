# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What previews keep of materials that are texture sets: their images, and how these are used."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from typing import Any, cast

import bpy

from ..core.errors import FormatError
from .image_materials import ImageMaterial, ImageSource

ROLES = ("Base Color", "Metallic", "Roughness", "Normal")  # names of nodes, in the order of `sources`
_NUMBER, _FACTS = "radtex_number", "radtex_images"  # custom properties of a preview's material
_SOURCES = ("base_image", "metallic_image", "roughness_image", "normal")


def keep_facts(material: bpy.types.Material, own: ImageMaterial, number: int) -> None:
    """Store on a preview's material, which is of this `number`, all but the images themselves."""
    without = replace(own, base_image=None, metallic_image=None, roughness_image=None, normal=None)
    channels = [None if source is None else source.channel for source in own.sources]
    cast(Any, material)[_NUMBER] = number
    cast(Any, material)[_FACTS] = json.dumps({**asdict(without), "channels": channels})


def kept_number(material: Any) -> int | None:
    """The number of a preview's material that shows its own images; None for any other."""
    number = material.get(_NUMBER)
    return number if isinstance(number, int) else None


def kept_images(material: Any) -> ImageMaterial:
    """The images of a preview's material that has a `kept_number`. Raises FormatError if it lacks some."""
    try:
        facts = json.loads(material[_FACTS])
        channels = facts.pop("channels")
        sources = {
            key: _source(material.node_tree.nodes.get(role), channel)
            for key, role, channel in zip(_SOURCES, ROLES, channels, strict=True)
        }
        return ImageMaterial(**{**facts, **sources, "base": tuple(facts["base"])})
    except (KeyError, TypeError, ValueError) as error:
        raise FormatError(f"material '{material.name}' of the preview is not as RadTex wrote it") from error


def _source(node: Any, channel: int | None) -> ImageSource | None:
    if node is None or node.image is None:
        return None
    return ImageSource(node.image, node.extension, channel)
