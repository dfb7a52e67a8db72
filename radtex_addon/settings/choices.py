# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The choices of a bake that have names, as enums and their parsers."""

from __future__ import annotations

from enum import StrEnum
from typing import TypeVar

from ..bake.layers import Layer
from ..core.errors import InputError
from .kinds import Kind, Layout


class CaptureMethod(StrEnum):
    """How Cycles fills buckets."""

    PORTAL = "portal"
    PANORAMIC = "panoramic"


class View(StrEnum):
    """The viewpoints of a transfer bake."""

    NORMAL = "normal"  # each texel along its normal
    CAMERA = "camera"  # from the scene's camera
    AROUND = "around"  # each texel from nine directions; lookups blend between them

    @property
    def along(self) -> int:
        """The number of views along a bucket's side; its square is captured."""
        return 3 if self is View.AROUND else 1


class Unwrap(StrEnum):
    """The unwrapper that makes the UV layer if none is named.

    `auto` takes the object's own UV layer if that is fit to bake on, else what `uvunwrap` makes.
    """

    AUTO = "auto"
    UVUNWRAP = "uvunwrap"
    XATLAS = "xatlas"
    BLENDER = "blender"


class Backs(StrEnum):
    """Which faces that are seen from behind get texels for their backs, too."""

    AUTO = "auto"  # those whose back a camera can see in the scene
    ALL = "all"  # those whose back can be seen from outside the mesh
    NONE = "none"


_Choice = TypeVar("_Choice", bound=StrEnum)


def parse_kind(text: str) -> Kind:
    """The kind named by `text`. Raises InputError, with the choices."""
    return parse(Kind, "kind", text)


def parse_capture(text: str) -> CaptureMethod:
    """The capture named by `text`. Raises InputError, with the choices."""
    return parse(CaptureMethod, "capture", text)


def parse_layout(text: str) -> Layout:
    """The layout named by `text`. Raises InputError, with the choices."""
    return parse(Layout, "layout", text)


def parse_layer(text: str) -> Layer:
    """The layer named by `text`. Raises InputError, with the choices."""
    return parse(Layer, "layer", text)


def parse_backs(text: str) -> Backs:
    """The choice of backs named by `text`. Raises InputError, with the choices."""
    return parse(Backs, "choice of backs", text)


def parse(choices: type[_Choice], word: str, text: str) -> _Choice:
    """The choice named by `text`; `word` is what it chooses. Raises InputError, with the choices."""
    try:
        return choices(text)
    except ValueError:
        raise InputError(f"there is no {word} {text!r}: choose from {', '.join(choices)}") from None
