# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings as a dict of values by name, and the specification and the request to bake that they make."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any, cast

import bpy

from ...core.errors import InputError
from ...core.sampler import Filter
from ...job import OpenLayout
from ...job.bake_request import BakeRequest
from ...scene.lights.lamps import EACH
from ...scene.proxy_content import EVERYTHING
from ...settings.choices import parse_kind, parse_layout
from ...settings.cost import check_memory
from ...settings.forms import FormTraits
from ...settings.frame_numbers import parse_frames
from ...settings.kinds import Kind, KindTraits, Layout, form_in
from ...settings.options import DEFAULT_FOLDER, OPTIONS, BakeOptions
from ...settings.spec import BakeSpec, Layer
from ...store.ownership import blend_folder_name, former_folder, open_blend
from ...textures.export_spec import Target
from .bake_settings import NAMES, BakeSettings, suited_bucket
from .preferences import preferred

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
    sourced = kind.source and values["source"]
    special: dict[str, Any] = {
        "layout": layout,
        "density": values["density"] if values["atlas_size"] == "density" else None,
        "bucket": cast(int, cells),  # None lets BakeSpec use its default
        "device": wishes.device,
        "memory_mb": wishes.memory_mb,
        "half": not kind.full_floats or not values["full_floats"],
        "layers": _layers_of(values) if asked.layers and kind.layers else (),
        "texel_weights": None if values["uv_layer"] else values["texel_weights"] or None,
        "split": None if values["split"] == "none" else values["split"],
        "part": values["part"] or None if values["split"] != "none" else None,
        "accumulate": more,
        "refresh": again,
        "where": values["where"] or None if (more or again) and asked.accumulates_parts else None,
        "content": _content_of(values) if kind.content else None,
        "extrusion": values["extrusion"] or None if sourced and not values["cage"] else None,
        "cage": values["cage"] or None if sourced else None,
    }
    spec = BakeSpec(**(_plain(values, kind, asked) | special))
    check_memory(spec)
    return spec


def _plain(values: Mapping[str, Any], kind: KindTraits, form: FormTraits) -> dict[str, Any]:
    """The fields that have the values of their settings; defaults where the kind or the form has no such."""
    options = {field.name: OPTIONS[field.name] for field in fields(BakeOptions) if field.name in OPTIONS}
    return {
        name: (values[name] or None) if option.default is None else values[name]
        for name, option in options.items()
        if name in values and option.applies(kind, form)
    }


def _layers_of(values: Mapping[str, Any]) -> tuple[Layer, ...]:
    return tuple(layer for layer in Layer if layer.value in values["layers"])


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


def shared_name(values: Mapping[str, Any], kind: Kind) -> str | None:
    """Name of the atlas that all objects share; None if each object has its own."""
    name: str = values["atlas_name"]
    return name if values["together"] == "one" and kind.traits.shared_atlas else None


def request_of(values: Mapping[str, Any], names: Sequence[str]) -> BakeRequest:
    """The request to bake the objects `names` by `values` (by setting name).

    Raises InputError for invalid settings.
    """
    spec = spec_of(values)
    targets = tuple(target for target in Target if target.value in values["export_targets"])
    if targets and not values["preview"]:
        raise InputError("an export is made from the preview: switch Preview on, or the export off")
    return BakeRequest(
        objects=tuple(names),
        spec=spec,
        folder=output_folder(values["directory"], preferred().output),
        former=former_places(values["directory"]),
        shared=shared_name(values, spec.kind) if len(names) > 1 else None,
        preview=Filter.QUADRILINEAR if values["preview"] else None,
        overwrite=values["overwrite"],
        resume=values["resume"],
        exports=targets,
        frames=parse_frames(values["frames"]) if values["variants"] == "frames" else (),
        lights=((EACH,),) if values["variants"] == "lamps" else (),
        open_layout=open_layout_of(values),
    )


def output_folder(directory: str, instead: Path | None) -> Path:
    """The absolute path of `directory`; `instead` if that is empty, or relative to an unsaved file.

    `{blend_name}` in it becomes the name of the file's own folder of bakes. Raises InputError if neither can
    be used.
    """
    if directory.strip() and (bpy.data.filepath or not directory.startswith("//")):
        own = blend_folder_name(open_blend()) if bpy.data.filepath else "untitled"
        return Path(bpy.path.abspath(directory.replace("{blend_name}", own)))
    if instead is not None:
        return instead
    if not directory.strip():
        raise InputError("no output folder is chosen: choose one")
    raise InputError("this file was never saved: save it, or choose a folder for its bakes")


def former_places(directory: str) -> tuple[Path, ...]:
    """Where earlier versions left bakes, if `directory` is the default: there they are still found."""
    if directory != DEFAULT_FOLDER or not bpy.data.filepath:
        return ()
    return (former_folder(open_blend()),)


def has_folder(values: Mapping[str, Any]) -> bool:
    """Whether `values` or the preferences name a usable output folder."""
    try:
        output_folder(values["directory"], preferred().output)
    except InputError:
        return False
    return True
