# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The input of a form's bake."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import bpy

from ..bake.piece_store import NO_STORE, PieceStore
from ..bake.thumbnail import Thumbnail
from ..prepare.prepared import Prepared
from ..settings.spec import BakeSpec


@dataclass(frozen=True, eq=False)
class BakeJob:
    """A bake of the `prepared` objects in a `scratch` scene, which the bake may change.

    `sidecar` is the final path of the bake's sidecar, `folder` is for temporary files. The `store` takes
    finished pieces, and has places for output files until all are written. The `thumbnail` gets the captured
    light. `surroundings` is the width of the pictures of what surrounds the objects, relative to the usual;
    a probe that only measures time has smaller ones. Large arrays lie in files in the folder `arrays`, None:
    beside the output.
    """

    scratch: bpy.types.Scene
    spec: BakeSpec
    sidecar: Path
    prepared: Prepared
    folder: Path
    store: PieceStore = NO_STORE
    thumbnail: Thumbnail | None = None
    surroundings: float = 1.0
    arrays: Path | None = None

    @property
    def place(self) -> Path:
        """Where to write the sidecar, with the images beside it."""
        return self.store.place(self.sidecar)
