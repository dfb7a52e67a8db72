# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which light a bake shows: kind, frame, lamps, layers. Previews store it, as their sidecar may be gone."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from ..bake.forms import has_light_layers
from ..bake.options import MARKED
from ..formats.json_reader import Facts
from ..formats.sidecar_file import AnySidecar, read_facts

_KEPT = "radtex_variant"  # custom property of a copy: JSON, as in a sidecar
_KEYS = ("kind", "layout", "frame", "lights", "layers", *MARKED)


@dataclass(frozen=True)
class Variant:
    """A bake's `kind`, its `frame` if one was specified, and its lamps `lights`, () for all light.

    `layers` are those that can be shown alone, `marks` the options that its sidecar marks.
    """

    kind: str = "radiance"
    frame: int | None = None
    lights: tuple[str, ...] = ()
    layers: tuple[str, ...] = ()
    marks: tuple[str, ...] = ()


def read_variant(sidecar: AnySidecar) -> Variant:
    """Read a bake's variant from its sidecar. Raises FormatError."""
    return _variant_in(read_facts(sidecar))


def keep_variant(copy: Any, sidecar: AnySidecar) -> None:
    """Store on a preview the variant of its bake. Raises FormatError."""
    facts = read_facts(sidecar).values
    copy[_KEPT] = json.dumps({key: facts[key] for key in _KEYS if key in facts})


def kept_variant(copy: Any) -> Variant:
    """The variant stored on a preview; if there is none, radiance of all light."""
    kept = copy.get(_KEPT)
    return Variant() if not isinstance(kept, str) else _variant_in(Facts.parse(kept, f"'{copy.name}'"))


def _variant_in(facts: Facts) -> Variant:
    return Variant(
        facts.text("kind"),
        facts.whole_number("frame", 0) if "frame" in facts.values else None,
        facts.texts("lights") if "lights" in facts.values else (),
        facts.texts("layers") if has_light_layers(facts.text("layout")) else (),
        tuple(name for name in MARKED if facts.values.get(name) is True),
    )
