# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake was made of, as digests by parts, so that one can tell what has changed since.

The geometry of objects with modifiers is not always to the last bit what it was: its digests also tell what
they are near to. In the sidecar that is beside the exact digests, so that fingerprints with and without it
compare.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from ..core.near_digest import NearDigest
from .json_reader import Facts

VERSION = 1  # another one digests other things: such fingerprints cannot be compared
KEY = "fingerprint"  # in the sidecar
NEAR = "near"  # in the fingerprint: what parts are near to
PARTS = ("mesh", "transform", "materials", "settings", "surroundings")
_NEAR_PARTS = ("mesh", "surroundings")  # texts of NearDigest


@dataclass(frozen=True)
class Fingerprint:
    """Digests of what a bake was made of; a part is empty if it is not known.

    `mesh`, `transform` and `materials` are those of the baked objects, with their source and cage; `settings`
    are the specification's, and the scene's of how light travels; `surroundings` is all else that the scene
    renders.
    """

    mesh: str = ""
    transform: str = ""
    materials: str = ""
    settings: str = ""
    surroundings: str = ""
    version: int = VERSION

    def differences(self, other: Fingerprint) -> tuple[str, ...]:
        """Names of the parts that differ, in the order of `PARTS`; a part that is not known differs."""
        return tuple(part for part in PARTS if not self._has(part, other))

    def folded_onto(self, earlier: Fingerprint | None, *, everywhere: bool) -> Fingerprint | None:
        """The fingerprint of an atlas of the `earlier` fingerprint to which a bake of this one is added.

        The settings stay the earlier ones. Unless the bake renews the atlas `everywhere`, the parts that
        differ are not known: the atlas has some of both. None if nothing is known of the earlier bake.
        """
        if earlier is None or earlier.version != self.version:
            return None
        settings = earlier.settings
        if everywhere:
            return replace(self, settings=settings)
        mixed = {part: "" for part in PARTS if part != "settings" and not self._has(part, earlier)}
        return replace(self, **{**mixed, "settings": settings})  # type: ignore[arg-type]  # all are strings

    def to_facts(self) -> dict[str, Any]:
        """The fingerprint as JSON values."""
        digests = {part: NearDigest.parse(getattr(self, part)) for part in PARTS}
        near = {part: digests[part].near for part in _NEAR_PARTS if digests[part].near}
        exact = {part: digest.exact for part, digest in digests.items()}
        return {"version": self.version, **exact} | ({NEAR: near} if near else {})

    def _has(self, part: str, other: Fingerprint) -> bool:
        mine, its = NearDigest.parse(getattr(self, part)), NearDigest.parse(getattr(other, part))
        return bool(mine.exact) and mine.is_like(its)


def fingerprint_in(facts: Facts) -> Fingerprint | None:
    """The fingerprint in a sidecar's `facts`, None if it has none. Raises FormatError."""
    if KEY not in facts.values:
        return None
    found = facts.inner(KEY)
    near = found.inner(NEAR) if NEAR in found.values else None
    parts = {part: found.text(part) for part in PARTS if part in found.values}
    for part in _NEAR_PARTS:
        if near is not None and part in near.values and part in parts:
            parts[part] += f" {near.text(part)}"
    return Fingerprint(**parts, version=found.whole_number("version", 1))
