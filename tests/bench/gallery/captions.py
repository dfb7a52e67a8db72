# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery's rows: the order of the page, what each shows, and what is wrong in its picture."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Caption:
    """What a row `shows` and what an artist has `seen` in its picture, in whole sentences."""

    title: str
    shows: str
    seen: str


CAPTIONS = {
    "iridescence": Caption("Iridescence", "A steel ring under a thin film.", ""),
    "inter_reflection": Caption("Inter-reflection", "A copper bowl.", ""),
    "refraction": Caption("Refraction", "A glass egg with a bubble.", ""),
    "alpha": Caption("Transparency", "A ball with waves of alpha.", ""),
    "subsurface": Caption("Subsurface scattering", "A jade head.", ""),
    "volume": Caption("Volume", "A ball of fog.", ""),
    "shadow": Caption("Shadow", "One bit a cell.", ""),
    "transfer": Caption("Transfer", "A wax head under suns that no bake knows.", ""),
    "proxy": Caption("Proxy", "A ball of fur, and a bush of leaves: what is drawn is their hull alone.", ""),
    "high_to_low": Caption(
        "High to low",
        "A carved bronze head of 250 thousand triangles, and its light on a head of four thousand.",
        "The outline is the simple head's; rims of eyes and ears are softer, and shift a little.",
    ),
    "interior": Caption("Interior", "A window pane that shows a room.", ""),
}
