# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""All that `check_request` and the bake itself would refuse, for several objects, as text to show."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf
from pathlib import Path
from time import monotonic

import bpy

from ..bake.spec import BakeSpec
from ..core.errors import InputError
from ..forms import form_for
from ..textures.spec import Target
from .checks import check_request


@dataclass(frozen=True)
class Preflight:
    """What would fail, and what would bake but hardly as it is meant; each a line, none twice."""

    errors: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()


def run_preflight(
    scene: bpy.types.Scene,
    names: Iterable[str],
    spec: BakeSpec,
    folder: Path,
    *,
    preview: bool = False,
    overwrite: bool = False,
    resume: bool = False,
    targets: Iterable[Target] = (),
    view_layer: str | None = None,
    patience: float = inf,
) -> Preflight:
    """What a bake of the objects `names` with exports for `targets` would meet. Changes nothing.

    After `patience` seconds no further object is looked at: in a large scene each may take 20 ms.
    """
    errors: dict[str, None] = {}
    warnings: dict[str, None] = {}
    wanted, since = tuple(targets), monotonic()
    for number, name in enumerate(names):
        if number and monotonic() - since > patience:
            break
        try:
            found = check_request(
                scene, name, spec, folder, preview, overwrite, view_layer, resume, exports=wanted
            )
            warnings |= dict.fromkeys(found)
            for each in spec.objects or (name,):
                _check_uv(scene.objects[each], spec)
        except InputError as error:
            errors[str(error)] = None
    try:
        form_for(spec).check_size(spec, spec.texels, spec.texels)
    except InputError as error:
        # The atlas of an unwrap is seldom square: it may yet fit.
        (warnings if spec.uv_layer is None else errors)[str(error)] = None
    return Preflight(tuple(errors), tuple(warnings))


def _check_uv(item: bpy.types.Object, spec: BakeSpec) -> None:
    """Refuse a layer that the object has not, unless a modifier may make it."""
    layers = [layer.name for layer in item.data.uv_layers]
    if spec.uv_layer is None or spec.uv_layer in layers or item.modifiers:
        return
    known = f"choose {_listed(layers)}" if layers else "it has none: unwrap it"
    raise InputError(f"object '{item.name}' has no UV layer '{spec.uv_layer}': {known}, or leave it empty")


def _listed(names: Iterable[str]) -> str:
    return " or ".join(f"'{name}'" for name in names)
