# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Choose the layout of the selected objects when it is automatic, and describe the choice in one line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import inf
from time import monotonic
from typing import TYPE_CHECKING, Any

import bpy

from ...settings.menu_items import LAYOUTS
from .labels import iface_, remark

if TYPE_CHECKING:
    from ...job import Choice
    from ...settings.spec import BakeSpec

    Chosen = tuple[tuple[str, Choice], ...]


def chosen_layouts(
    scene: bpy.types.Scene,
    names: Sequence[str],
    values: Mapping[str, Any],
    spec: BakeSpec,
    patience: float = inf,
) -> Chosen:
    """Pairs of atlas name and `Choice`, one for each atlas of the objects `names`.

    Parts and single lamps have no pairs of their own: their layout is that of the whole object.
    Without `names` the result is one pair called "", for an object without special properties. After
    `patience` seconds no more objects are examined. Raises InputError as `job.choose_layout` does.
    """
    from ...job import choose_layout
    from ...job.about_texels import with_about_texels
    from ...job.bake_request import with_quality
    from ...job.variants import named_in
    from ..settings.preferences import preferred
    from ..settings.request import has_folder, open_layout_of, output_folder, shared_name

    folder = output_folder(values["directory"], preferred().output) if has_folder(values) else None
    wish = open_layout_of(values)
    shared = shared_name(values, spec.kind)
    spec = with_quality(spec, wish)
    bakes = [(name, spec) for name in names or ("",)]
    if shared is not None and len(names) > 1:
        bakes = [(shared, replace(spec, objects=tuple(names)))]
    since, found = monotonic(), []
    resume, overwrite = values["resume"], values["overwrite"]
    for bake in bakes:
        sized = bake[0], named_in(scene, with_about_texels(scene, *bake))
        choice = choose_layout(scene, sized, wish, folder, resume=resume, overwrite=overwrite)
        found.append((bake[0], choice))
        if monotonic() - since > patience:
            break
    return tuple(found)


def told_layouts(values: Mapping[str, Any], chosen: Chosen) -> str:
    """One line on which layout was chosen automatically; empty if the user chose the layout."""
    from ..settings.request import open_layout_of

    if open_layout_of(values) is None:
        return ""
    others = [(name, choice) for name, choice in chosen if choice.spec.layout != chosen[0][1].spec.layout]
    if others:
        plain = sum(choice.spec.form.any_cells for _, choice in chosen)
        told = iface_("Buckets for {} of {} objects, Layered for the others").format(plain, len(chosen))
        return ". ".join([told, *(remark(choice.told(name)) for name, choice in chosen if choice.reason)][:2])
    choice = chosen[0][1]
    named = next(label for identifier, label, _ in LAYOUTS if identifier == choice.spec.layout)
    told = iface_(named)
    if choice.spec.form.any_cells:
        told = iface_("{}, {} cells").format(told, choice.spec.bucket)
    return f"{told}. {remark(choice.reason)}" if choice.reason else told
