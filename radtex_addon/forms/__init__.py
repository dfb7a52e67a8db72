# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Forms: the ways to hold a bake, each a folder of its own; and which one a bake has.

A form's folder has all that depends on how a bake is stored: its files, capture, material, flat lightmap,
textures and shaders. It is called as its row in `bake.forms.FORMS`, and its module `form` has the form, FORM:
see docs/extending.md.
"""

from __future__ import annotations

from importlib import import_module

from ..bake.forms import FORMS as _ROWS
from ..bake.spec import BakeSpec
from ..core.errors import FormatError
from ..formats.json_reader import Facts, shown
from .form import Form

__all__ = ["FORMS", "Form", "form_for", "form_in"]

FORMS: tuple[Form, ...] = tuple(import_module(f"{__name__}.{traits.name}.form").FORM for traits in _ROWS)


def form_for(spec: BakeSpec) -> Form:
    """The form that a bake of `spec` gets."""
    return next(form for form in FORMS if form.traits == spec.form)


def form_in(facts: Facts) -> Form:
    """The form of the bake that a sidecar's `facts` are of. Raises FormatError for an unknown one."""
    layout = facts.text("layout")
    for form in FORMS:
        if form.traits.layout == layout and form.holds(facts):
            return form
    raise FormatError(f'{facts.source}: "layout" is {shown(repr(layout))}, which this RadTex does not read')
