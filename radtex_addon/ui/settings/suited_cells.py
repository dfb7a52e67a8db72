# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The default number of cells in a bucket for the panel's kinds and layouts."""

from __future__ import annotations

from ...bake.kinds import Layout, form_in
from ...bake.spec import parse_kind, parse_layout


def suited_bucket(kind: str, layout: str) -> int:
    """Default bucket size for this kind and layout, in cells along a side."""
    traits = parse_kind(kind).traits
    if traits.form is not None:
        return traits.form.cells
    if layout in ("auto", ""):  # empty: an earlier version saved a layout that is no longer there
        return (Layout.LAYERED if traits.looks_at_surface else Layout.BUCKETS).cells
    return form_in(parse_layout(layout)).cells
