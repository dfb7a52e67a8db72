# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Forms: the ways to store a bake, each in a folder of its own; and which form a bake has.

A form's folder has everything that depends on how a bake is stored: its files, capture, material, flat
lightmap, textures and shaders. The folder has the name of the form's row in `settings.forms.FORMS`, and its
module `form` defines the form as FORM: see docs/extending.md.
"""

from __future__ import annotations

from importlib import import_module

from ..core.errors import FormatError
from ..formats.json_reader import Facts, shown
from ..settings.cost import Cost
from ..settings.forms import FORMS as _ROWS
from ..settings.spec import BakeSpec
from .form import Form

__all__ = ["FORMS", "Form", "cost_of", "form_for", "form_in"]

_FORMER = "shared"  # a layout that earlier versions wrote

FORMS: tuple[Form, ...] = tuple(import_module(f"{__name__}.{traits.name}.form").FORM for traits in _ROWS)


def form_for(spec: BakeSpec) -> Form:
    """The form that a bake of `spec` gets."""
    return next(form for form in FORMS if form.traits == spec.form)


def cost_of(spec: BakeSpec) -> Cost:
    """The most that a bake of `spec` can cost."""
    return form_for(spec).cost(spec)


def form_in(facts: Facts) -> Form:
    """The form of the bake whose sidecar has these `facts`. Raises FormatError for an unknown one."""
    layout = facts.text("layout")
    for form in FORMS:
        if form.traits.layout == layout and form.holds(facts):
            return form
    if layout == _FORMER:
        tool = shown(repr(facts.text("tool")))
        raise FormatError(
            f"{facts.source} is in the shared layout, made by {tool}, which this RadTex no longer reads: "
            "bake the object anew, in the layered layout, or use that version"
        )
    raise FormatError(f'{facts.source}: "layout" is {shown(repr(layout))}, which this RadTex does not read')
