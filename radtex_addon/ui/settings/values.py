# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings as a dict of values by name, and the bake specification made from them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, cast

from ...bake.cost import check_memory
from ...bake.kinds import KindTraits, Layout, form_in
from ...bake.spec import BakeSpec, Layer, View, parse_kind, parse_layout
from ...core.errors import InputError
from ...scene.proxy_content import EVERYTHING
from .bake_settings import NAMES, BakeSettings
from .preferences import preferred
from .suited_cells import suited_bucket

if TYPE_CHECKING:
    from ...job import OpenLayout

_BUCKET_NAMED = "bucket_named"  # key in values: true if the number of cells was given explicitly


def values_of(settings: BakeSettings) -> dict[str, Any]:
    """A scene's settings by name."""
    values = {name: getattr(settings, name) for name in NAMES}
    if not values["atlas_layout"]:  # an earlier version saved a layout that is no longer there
        values["atlas_layout"] = "auto"
        values["bucket"] = suited_bucket(values["kind"], "auto")
    return values


def values_with(settings: BakeSettings, arguments: BakeSettings, given: Iterable[str]) -> dict[str, Any]:
    """A scene's settings, overridden by the names in `given` from `arguments`.

    If kind or layout is overridden but not the cells, the cells get the new default. The atlas's size follows
    from texels or density if either is overridden.
    """
    named = set(given)
    values = values_of(settings) | {name: getattr(arguments, name) for name in NAMES if name in named}
    if "atlas_size" not in named and len(sizes := named & {"texels", "density"}) == 1:
        values["atlas_size"] = sizes.pop()
    if "bucket" in named:
        values[_BUCKET_NAMED] = True
    elif named & {"kind", "atlas_layout"}:
        values["bucket"] = suited_bucket(values["kind"], values["atlas_layout"])
    return values


def open_layout_of(values: Mapping[str, Any]) -> OpenLayout | None:
    """The automatic layout choice to make; None if a layout was chosen, or the kind has only one.

    The default number of cells that the panel sets does not count as the user's choice.
    """
    from ...job import OpenLayout

    if values["atlas_layout"] != "auto" or _kind_in(values).form:
        return None
    cells: int = values["bucket"]
    brought = suited_bucket(values["kind"], "auto")
    return OpenLayout(cells if values.get(_BUCKET_NAMED) or cells != brought else None)


def spec_of(values: Mapping[str, Any]) -> BakeSpec:
    """The bake specification of the settings; in layout buckets if `open_layout_of` is not None.

    Raises InputError for invalid settings, and for what does not fit into memory.
    """
    wishes = preferred()
    open_layout = open_layout_of(values)
    kind = _kind_in(values)
    plain_only = kind.form is not None or open_layout is not None
    layout = Layout.BUCKETS if plain_only else parse_layout(values["atlas_layout"])
    cells = values["bucket"] if open_layout is None else open_layout.cells
    asked = form_in(layout)
    more = bool(values["accumulate"]) and asked.accumulates and kind.accumulates
    again = bool(values["refresh"]) and asked.refreshes and kind.accumulates
    layered = asked.layers and kind.layers
    sourced = kind.source and values["source"]
    spec = BakeSpec(
        kind=values["kind"],
        layout=layout,
        texels=values["texels"],
        density=values["density"] if values["atlas_size"] == "density" else None,
        bucket=cast(int, cells),  # None lets BakeSpec use its default
        samples=values["samples"],
        seed=values["seed"],
        denoise=values["denoise"],
        uv_layer=values["uv_layer"] or None,
        unwrap=values["unwrap"],
        padding=values["padding"],
        device=wishes.device,
        memory_mb=wishes.memory_mb,
        half=not kind.full_floats or not values["full_floats"],
        compression=values["compression"],
        layers=tuple(layer for layer in Layer if layer.value in values["layers"]) if layered else (),
        split=None if values["split"] == "none" else values["split"],
        part=values["part"] or None if values["split"] != "none" else None,
        accumulate=more,
        refresh=again,
        view=View(values["view"] if kind.views else "normal"),
        where=values["where"] or None if (more or again) and asked.accumulates_parts else None,
        ao_distance=values["ao_distance"] or None if kind.ao_distance else None,
        content=_content_of(values) if kind.content else None,
        alone=values["alone"] and not kind.content,
        source=values["source"] if sourced else None,
        extrusion=values["extrusion"] or None if sourced and not values["cage"] else None,
        cage=values["cage"] or None if sourced else None,
    )
    check_memory(spec)
    return spec


def _kind_in(values: Mapping[str, Any]) -> KindTraits:
    return parse_kind(values["kind"]).traits


def _content_of(values: Mapping[str, Any]) -> str | None:
    if values["content"] == "all":
        return EVERYTHING
    if values["content"] == "inside":
        return None
    if not values["content_collection"]:
        raise InputError("which collection does the hull show? choose it below Content")
    name: str = values["content_collection"]
    return name
