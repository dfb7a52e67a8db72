# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Places on a baked surface that a viewer looks at: all that a lookup may use."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np

from .arrays import Floats, Ints
from .frame import to_frame


@dataclass(frozen=True, eq=False)
class Fragments:
    """Places looked at: `uv` (N, 2); `normal`, `viewer`, `position` (N, 3), world space; `material` (N,).

    `tangent` and `bitangent` (N, 3) are the mesh's, None if no lookup needs them. Directions are unit
    vectors; `viewer` points to the viewer. `spread` (N,): what normals that differ within a pixel add to the
    width² of lobes, None for nothing.
    """

    uv: Floats
    normal: Floats
    viewer: Floats
    position: Floats
    material: Ints
    tangent: Floats | None = None
    bitangent: Floats | None = None
    spread: Floats | None = None

    @property
    def incidence(self) -> Floats:
        """`viewer` in the frame of tangent, bitangent and normal, (N, 3). Raises ValueError without these."""
        if self.tangent is None or self.bitangent is None:
            raise ValueError("the fragments have no tangents")
        return cast(Floats, to_frame(self.viewer, self.tangent, self.bitangent, self.normal))

    def part(self, some: slice) -> Fragments:
        """Some of the fragments."""
        return Fragments(
            self.uv[some],
            self.normal[some],
            self.viewer[some],
            self.position[some],
            self.material[some],
            None if self.tangent is None else self.tangent[some],
            None if self.bitangent is None else self.bitangent[some],
            None if self.spread is None else self.spread[some],
        )

    def single(self) -> Fragments:
        """The same in float32."""
        return Fragments(
            self.uv.astype(np.float32),
            self.normal.astype(np.float32),
            self.viewer.astype(np.float32),
            self.position.astype(np.float32),
            self.material,
            None if self.tangent is None else self.tangent.astype(np.float32),
            None if self.bitangent is None else self.bitangent.astype(np.float32),
            None if self.spread is None else self.spread.astype(np.float32),
        )
