# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which of the chosen objects are baked by one request: those of the same settings, or of one asset."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

import bpy

from ...core.errors import InputError
from ...job.assets import find_assets, read_shown, spec_of_asset
from ...job.bake_request import with_quality
from .bake_settings import BakeSettings
from .object_settings import by_settings
from .preferences import preferred
from .request import has_folder, open_layout_of, output_folder, shared_name, spec_of, values_of


class BakedGroup(NamedTuple):
    """Objects, by `names`, and the `values` of settings that they are baked by.

    With `is_asset` they share an atlas because they touch: the values have its name and its size.
    """

    values: dict[str, Any]
    names: tuple[str, ...]
    is_asset: bool = False

    @property
    def atlases(self) -> int:
        """How many atlases they get, without counting parts and variants."""
        shared = shared_name(self.values, spec_of(self.values).kind) if len(self.names) > 1 else None
        return len(self.names) if shared is None else 1


def baked_groups(
    scene: bpy.types.Scene,
    names: Iterable[str],
    values: Callable[[BakeSettings], dict[str, Any]] = values_of,
) -> list[BakedGroup]:
    """The groups of the objects, each of at least one if there are `names`; else one without objects.

    `values` are those of settings. Quick: objects are looked at as the viewport shows them, each pair once.
    """
    groups = [(values(settings), group) for settings, group in by_settings(scene, names)]
    detailed = {each[name] for each, _ in groups for name in ("source", "cage")}
    return [one for each, group in groups for one in _with_assets(scene, each, group, detailed)]


def _with_assets(
    scene: bpy.types.Scene, values: dict[str, Any], names: tuple[str, ...], detailed: set[str]
) -> Iterator[BakedGroup]:
    """The objects of the same settings: assets first, then all others together.

    What others are baked from, or looked for from, is part of no asset.
    """
    if values["together"] != "auto" or len(names) < 2:
        yield BakedGroup(values, names)
        return
    try:
        spec = with_quality(spec_of(values), open_layout_of(values))
    except InputError:  # which the request's own checks report
        yield BakedGroup(values, names)
        return
    folder = output_folder(values["directory"], preferred().output) if has_folder(values) else None
    parts = [name for name in names if name not in detailed]
    found = find_assets(scene, parts, spec, open_layout_of(values), folder, read_shown(scene))
    for asset in found:
        texels = spec_of_asset(scene, spec, asset).texels
        of_asset = {
            "together": "one",
            "atlas_name": asset.name,
            "texels": texels,
            "bake_name": spec.bake_name,
        }
        yield BakedGroup(values | of_asset, asset.objects, is_asset=True)
    inside = {name for asset in found for name in asset.objects}
    others = tuple(name for name in names if name not in inside)
    if others or not found:
        yield BakedGroup(values, others)
