# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Forms: the ways to hold a bake, each a folder of its own; and which one a bake has.

A form's folder has all that depends on how a bake is stored: its files, capture, material, flat lightmap,
textures and shaders. To add one, write a folder and its rows in `bake.forms` and `_FORMS`.
"""

from __future__ import annotations

from ..bake.spec import BakeSpec
from ..core.errors import FormatError
from ..formats.json_reader import Facts, shown
from .ambient.form import Ambient
from .bits.form import Bits
from .buckets.form import Buckets
from .condensed.form import Condensed
from .form import Form
from .shared.form import Shared
from .sphere.form import Sphere

__all__ = ["FORMS", "Form", "form_for", "form_in"]

FORMS: tuple[Form, ...] = (Buckets(), Bits(), Ambient(), Sphere(), Shared(), Condensed())


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
