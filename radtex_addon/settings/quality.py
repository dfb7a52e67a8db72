# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How good a bake is, as far as its settings tell: which of two is the better one."""

from __future__ import annotations

from dataclasses import dataclass

from ..formats.json_reader import Facts
from .forms import LAYERED, has_light_layers
from .spec import BakeSpec


@dataclass(frozen=True)
class Quality:
    """What a bake has of each thing that makes it better.

    `texels` are along its longer side, an estimate if a `density` of them was asked for. `cells` are those
    along a bucket's side, 0 in a layout that chooses them itself. `samples` are light paths a cell, which
    are about as many in different layouts. `layers` are parts of the light that are kept beside the whole.
    """

    layout: str
    texels: int
    cells: int
    samples: int
    layers: frozenset[str] = frozenset()
    density: float | None = None

    @classmethod
    def of_spec(cls, spec: BakeSpec, passes: int = 1) -> Quality:
        """Of a bake to be made, with so many passes in all, each of which adds as many samples again."""
        form, samples = spec.form, spec.samples * passes
        single = not spec.kind.traits.cells  # all rays of a texel go into one cell
        return cls(
            layout=form.layout,
            texels=spec.texels,
            cells=1 if single else spec.bucket if form.any_cells else 0,
            samples=samples * spec.bucket**2 if single else samples,
            layers=frozenset(spec.layers),
            density=spec.density,
        )

    @classmethod
    def in_facts(cls, facts: Facts) -> Quality:
        """Of a finished bake, by its sidecar. Raises FormatError."""
        layout, cells = facts.text("layout"), facts.whole_number("bucket", 1)
        asked = facts.inner("texel_density").positive("asked") if "texel_density" in facts.values else None
        return cls(
            layout=layout,
            texels=max(facts.size("texels")),
            cells=0 if layout == LAYERED.layout else cells,
            samples=facts.whole_number("samples", 1),
            layers=frozenset(facts.texts("layers")) if has_light_layers(layout) else frozenset(),
            density=asked,
        )

    def is_worse_than(self, other: Quality) -> bool:
        """Whether something that `other` has would be lost.

        These are texels, cells in the same layout, samples and layers of the light, and the layered layout,
        which shows gloss better than buckets. So of two bakes each may be worse than the other.
        """
        if self.density is not None and other.density is not None:
            coarser = self.density < other.density * _SAME
        else:
            coarser = self.texels < other.texels
        left = self.layout != other.layout and other.layout == LAYERED.layout
        fewer = self.layout == other.layout and (self.cells < other.cells or not self.layers >= other.layers)
        return coarser or left or fewer or self.samples < other.samples

    def __str__(self) -> str:
        """In words, such as "layered, 256 texels, 16 samples"."""
        size = f"{self.texels} texels" if self.density is None else f"{self.density:.4g} texels a metre"
        cells = f"{self.cells} cells a side" if self.cells > 1 else ""
        samples = "1 sample" if self.samples == 1 else f"{self.samples} samples"
        with_layers = f"layers {', '.join(sorted(self.layers))}" if self.layers else ""
        return ", ".join(word for word in (self.layout, size, cells, samples, with_layers) if word)


_SAME = 1 - 1e-6  # a panel's density is a float32
