# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A comparison's pictures as files: light as half-float EXRs, and the difference as a PNG."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from ..formats.containers.exr import Compression, read_render, stored_rows, write_rows
from ..formats.containers.png import encode_png
from ..formats.disk.atomic import replacing_together
from ..formats.sidecar import safe_name
from ..version import VERSION
from .metrics import Picture
from .side_by_side import Comparison


@dataclass(frozen=True)
class ComparisonFiles:
    """The pictures' paths: `traced` and `baked` are linear EXRs, `difference` is a PNG."""

    traced: Path
    baked: Path
    difference: Path

    @classmethod
    def of(cls, folder: Path, names: Sequence[str]) -> ComparisonFiles:
        """The files for the objects `names` in a folder: `<names>.traced.exr` and so on."""
        name = safe_name("+".join(names))
        return cls(
            folder / f"{name}.traced.exr", folder / f"{name}.baked.exr", folder / f"{name}.difference.png"
        )

    @property
    def all(self) -> tuple[Path, ...]:
        return self.traced, self.baked, self.difference


def write_comparison(found: Comparison, files: ComparisonFiles) -> None:
    """Write the pictures; an earlier comparison's are replaced, all or none. Raises BakeError."""
    with replacing_together(files.difference) as difference:
        for path, picture in ((files.traced, found.traced), (files.baked, found.baked)):
            rows, _ = stored_rows(path, picture, half=True)
            facts = {"tool": f"RadTex {VERSION}", "picture": path.suffixes[-2][1:], **asdict(found.figures)}
            write_rows(difference.with_name(path.name), rows, json.dumps(facts), Compression.ZIP)
        difference.write_bytes(encode_png(found.difference[::-1]))


def read_picture(path: Path) -> Picture:
    """A picture (H, W, 3) of light, row 0 at the bottom. Raises FormatError."""
    return read_render(path)[""].astype(np.float64)
