# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What light a bake shows: kind, frame, lamps, layers; also of a preview whose sidecar may be gone."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..bake.forms import layers_apart
from ..formats.json_reader import Facts
from ..formats.sidecar import read_facts

_KEPT = "radtex_variant"  # of a copy: JSON, as in a sidecar
_KEYS = ("kind", "layout", "frame", "lights", "layers")


@dataclass(frozen=True)
class Variant:
    """Its `kind`, the `frame` that was asked for, None for none, and the only `lights`, () for all light.

    `layers` are those that can be shown alone.
    """

    kind: str = "radiance"
    frame: int | None = None
    lights: tuple[str, ...] = ()
    layers: tuple[str, ...] = ()


def read_variant(sidecar: Path) -> Variant:
    """That of the bake whose sidecar is the file `sidecar`. Raises FormatError."""
    return _variant_in(read_facts(sidecar))


def keep_variant(copy: Any, sidecar: Path) -> None:
    """Store on a preview what it shows. Raises FormatError."""
    facts = read_facts(sidecar).values
    copy[_KEPT] = json.dumps({key: facts[key] for key in _KEYS if key in facts})


def kept_variant(copy: Any) -> Variant:
    """What a preview shows; all radiance if it does not say."""
    kept = copy.get(_KEPT)
    return Variant() if not isinstance(kept, str) else _variant_in(Facts.parse(kept, f"'{copy.name}'"))


def _variant_in(facts: Facts) -> Variant:
    return Variant(
        facts.text("kind"),
        facts.whole_number("frame", 0) if "frame" in facts.values else None,
        facts.texts("lights") if "lights" in facts.values else (),
        facts.texts("layers") if layers_apart(facts.text("layout")) else (),
    )
