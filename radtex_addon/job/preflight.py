# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Preflight: collect the errors and warnings of bakes of several objects, to show them all at once."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf
from pathlib import Path
from time import monotonic

import bpy

from ..core.errors import InputError
from ..core.messages import Message, Setting, do, leave_out
from ..forms import form_for
from ..settings.spec import BakeSpec
from ..store.ownership import Overwrite
from ..textures.export_spec import Target
from .checks import check_request


@dataclass(frozen=True)
class Preflight:
    """Errors that make a bake fail, and warnings; each is one line, without duplicates."""

    errors: tuple[Message, ...] = ()
    warnings: tuple[Message, ...] = ()


def run_preflight(
    scene: bpy.types.Scene,
    names: Iterable[str],
    spec: BakeSpec,
    folder: Path,
    *,
    preview: bool = False,
    overwrite: bool | Overwrite = False,
    resume: bool = False,
    targets: Iterable[Target] = (),
    view_layer: str | None = None,
    patience: float = inf,
) -> Preflight:
    """Find errors and warnings of bakes of the objects `names` with exports for `targets`. Changes nothing.

    After `patience` seconds no further object is checked: in a large scene each may take 20 ms.
    """
    errors: dict[Message, None] = {}
    warnings: dict[Message, None] = {}
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
            errors[error.message] = None
    try:
        form_for(spec).check_size(spec, spec.texels, spec.texels)
    except InputError as error:
        # The size is that of a square atlas; a new unwrap is seldom square, and may still fit.
        (warnings if spec.uv_layer is None else errors)[error.message] = None
    return Preflight(tuple(errors), tuple(warnings))


def _check_uv(item: bpy.types.Object, spec: BakeSpec) -> None:
    """Raises InputError if the object lacks the UV layer and has no modifier that might make it."""
    layers = [layer.name for layer in getattr(item.data, "uv_layers", ())]
    if spec.uv_layer is None or spec.uv_layer in layers or item.modifiers:
        return
    remedies = [do(f"choose {_listed(layers)}", Setting.UV)] if layers else []
    raise InputError(
        f"object '{item.name}' has no UV layer '{spec.uv_layer}'",
        *remedies,
        leave_out(Setting.UV, to="to have one made"),
    )


def _listed(names: Iterable[str]) -> str:
    return " or ".join(f"'{name}'" for name in names)
