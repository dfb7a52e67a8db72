# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a form gets to bake."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import bpy

from ..bake.piece_store import NO_STORE, PieceStore
from ..bake.spec import BakeSpec
from ..bake.thumbnail import Thumbnail
from ..prepare.prepared import Prepared


@dataclass(frozen=True, eq=False)
class BakeJob:
    """A bake of what is `prepared` in a `scratch` scene, which it may change.

    `sidecar` is where the bake's sidecar is to be, `folder` takes temporary files, and the `store` finished
    pieces: it also gives the places where files wait until all are written. The `thumbnail` is shown what
    comes in.
    """

    scratch: bpy.types.Scene
    spec: BakeSpec
    sidecar: Path
    prepared: Prepared
    folder: Path
    store: PieceStore = NO_STORE
    thumbnail: Thumbnail | None = None

    @property
    def place(self) -> Path:
        """Where to write the sidecar, with the images beside it."""
        return self.store.place(self.sidecar)
