# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the batch writes and looks for bakes if no folder is named."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from ..report.shown import has_bakes
from ..store.ownership import FOLDER, UNSAVED, former_folder, open_blend, own_folder


def blend_of(found: argparse.Namespace, demo: bool) -> Path:
    """The file whose bakes are meant: the one that is named, or Blender's; none for the demo."""
    if demo:
        return UNSAVED
    return open_blend() if found.scene is None else Path(found.scene)


def former_folders(blend: Path) -> tuple[Path, ...]:
    """Where bakes lay by default before each file had a folder of its own; none for a scene in no file."""
    return tuple(dict.fromkeys((former_folder(blend), Path(FOLDER)))) if blend.name else ()


def default_bakes(blend: Path, names: Sequence[str]) -> Path:
    """The file's own folder, or a former one that has the bakes of all these objects where that has not."""
    own = own_folder(blend)
    places = (place for place in (own, *former_folders(blend)) if has_bakes(place, names, blend))
    return next(places, own)
