# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings as a dict of values by name, and the bake specification made from them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, cast

from ..bake.spec import BakeSpec, Compression, Kind, Layer, Layout, View, parse_kind, parse_layout
from ..core.errors import InputError
from ..scene.proxy_content import EVERYTHING
from .choices import ACCUMULATED, BUCKETS_ONLY, LAYERED, SOURCED
from .preferences import preferred
from .settings import NAMES, BakeSettings

if TYPE_CHECKING:
    from ..job import OpenLayout

_MEGABYTE = 1e6
_BUCKET_NAMED = "bucket_named"  # key in values: true if the number of cells was given explicitly


def values_of(settings: BakeSettings) -> dict[str, Any]:
    """A scene's settings by name."""
    return {name: getattr(settings, name) for name in NAMES}


def values_with(settings: BakeSettings, arguments: BakeSettings, given: Iterable[str]) -> dict[str, Any]:
    """A scene's settings, overridden by the names in `given` from `arguments`.

    If kind, layout, limit, budget or target is overridden but not the cells, the cells get the new default.
    """
    named = set(given)
    values = values_of(settings) | {name: getattr(arguments, name) for name in NAMES if name in named}
    if "atlas_layout" not in named and values["atlas_layout"] == "auto":
        _size_shared(values, named)
    if "bucket" in named:
        values[_BUCKET_NAMED] = True
    elif named & {"kind", "atlas_layout", "limit", "budget", "target"}:
        values["bucket"] = suited_bucket(values["kind"], values["atlas_layout"], values["limit"])
    return values


def _size_shared(values: dict[str, Any], named: set[str]) -> None:
    """Select the shared layout if a size or quality limit is given without a layout; else set no limit."""
    if "limit" not in named:
        values["limit"] = next((name for name in ("budget", "target") if name in named), "none")
    if values["limit"] != "none":
        values["atlas_layout"] = "shared"


def open_layout_of(values: Mapping[str, Any]) -> OpenLayout | None:
    """The automatic layout choice to make; None if a layout was chosen, or the kind has only one.

    The default number of cells that the panel sets does not count as the user's choice.
    """
    from ..job import OpenLayout

    if values["atlas_layout"] != "auto" or values["kind"] in BUCKETS_ONLY:
        return None
    cells: int = values["bucket"]
    brought = suited_bucket(values["kind"], "auto", "none")
    return OpenLayout(cells if values.get(_BUCKET_NAMED) or cells != brought else None)


def suited_bucket(kind: str, layout: str, limit: str) -> int:
    """Default bucket size for this kind, layout and limit, in cells along a side."""
    if kind in BUCKETS_ONLY:
        return BakeSpec(texels=1, kind=parse_kind(kind)).bucket
    if layout == "auto":
        from ..job.layout_choice import SHARED_CELLS

        return SHARED_CELLS if kind == Kind.RADIANCE else Layout.BUCKETS.cells
    chosen = parse_layout(layout)
    condensed = chosen is Layout.SHARED and limit != "none"
    return BakeSpec(texels=1, layout=chosen, target=40.0 if condensed else None).bucket


def spec_of(values: Mapping[str, Any]) -> BakeSpec:
    """The bake specification of the settings; in layout buckets if `open_layout_of` is not None.

    Raises InputError for invalid settings.
    """
    wishes = preferred()
    open_layout = open_layout_of(values)
    plain_only = values["kind"] in BUCKETS_ONLY or open_layout is not None
    layout = Layout.BUCKETS if plain_only else parse_layout(values["atlas_layout"])
    cells = values["bucket"] if open_layout is None else open_layout.cells
    plain = layout is Layout.BUCKETS
    lasting = plain and values["kind"] in ACCUMULATED
    layered = plain and values["kind"] in LAYERED
    sourced = layout is Layout.BUCKETS and values["kind"] in SOURCED and values["source"]
    limit = values["limit"] if layout is Layout.SHARED else "none"
    return BakeSpec(
        kind=values["kind"],
        layout=layout,
        texels=values["texels"],
        bucket=cast(int, cells),  # None lets BakeSpec use its default
        samples=values["samples"],
        seed=values["seed"],
        uv_layer=values["uv_layer"] or None,
        unwrap=values["unwrap"],
        padding=values["padding"],
        device=wishes.device,
        memory_mb=wishes.memory_mb,
        budget=round(values["budget"] * _MEGABYTE) if limit == "budget" else None,
        target=values["target"] if limit == "target" else None,
        half=limit != "none" or values["kind"] == "shadow" or not values["full_floats"],
        compression=Compression.ZIP if limit != "none" else values["compression"],
        layers=tuple(layer for layer in Layer if layer.value in values["layers"]) if layered else (),
        split=None if values["split"] == "none" else values["split"],
        part=values["part"] or None if values["split"] != "none" else None,
        accumulate=values["accumulate"] and lasting,
        refresh=values["refresh"] and lasting,
        view=View(values["view"] if values["kind"] == "transfer" else "normal"),
        where=values["where"] or None if lasting and (values["accumulate"] or values["refresh"]) else None,
        ao_distance=values["ao_distance"] or None if values["kind"] == "ao" else None,
        content=_content_of(values) if values["kind"] == "proxy" else None,
        source=values["source"] if sourced else None,
        extrusion=values["extrusion"] or None if sourced and not values["cage"] else None,
        cage=values["cage"] or None if sourced else None,
    )


def _content_of(values: Mapping[str, Any]) -> str | None:
    if values["content"] == "all":
        return EVERYTHING
    if values["content"] == "inside":
        return None
    if not values["content_collection"]:
        raise InputError("which collection does the hull show? choose it below Content")
    name: str = values["content_collection"]
    return name
