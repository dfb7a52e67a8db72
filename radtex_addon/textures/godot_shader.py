# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake's shader in Godot: a template file and the values to fill in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .entry import TextureEntry


@dataclass(frozen=True)
class GodotShader:
    """A `template` file, the values of its `words`, and the material's `parameters` and textures by uniform.

    `parameters` are in the syntax of Godot's text resources. A mesh with several materials has, for each, the
    parameters in `materials`, too.
    """

    template: str
    words: Mapping[str, str]
    includes: tuple[str, ...]
    parameters: Mapping[str, str]
    textures: Mapping[str, TextureEntry]
    materials: tuple[Mapping[str, str], ...] = ({},)


def blending_words(alpha: str | None, *, prepass: bool = False, hull: bool = False) -> dict[str, str]:
    """The words of a template that say how it is blended; `alpha` is an expression, None where all is opaque.

    What is clear is not drawn, so that it hides nothing; but in a `hull`, whose nearest side has it all. With
    a `prepass`, what is opaque is drawn first, so that soft edges in front of it blend with it whatever the
    order of triangles, for a second lookup.
    """
    if alpha is None:
        return {"BLENDED": "", "COVER": "1.0", "ALPHA": ""}
    lines = f"    ALPHA = {alpha};\n"
    if not hull:
        lines += "    if (max(ALPHA, max(light.r, max(light.g, light.b))) < 0.002) discard;\n"
    depth = "depth_prepass_alpha" if prepass else "depth_draw_always"
    return {"BLENDED": f", blend_premul_alpha, {depth}", "COVER": alpha, "ALPHA": lines}


def integers(values: Any) -> str:
    """A vector of whole numbers in the syntax of Godot's text resources."""
    return f"Vector{len(values)}i({', '.join(str(int(value)) for value in values)})"


def number_list(values: npt.ArrayLike) -> str:
    """All numbers of an array, separated by commas."""
    return ", ".join(repr(float(value)) for value in np.asarray(values, dtype=np.float64).ravel())
