# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of the first seed, kept below the user's cache folder for the contact sheets."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from radtex_addon.report.metrics import Picture


def folder() -> Path:
    """Where they are."""
    root = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return root / "radtex" / "results"


def keep(scene: str, method: str, pictures: Sequence[Picture]) -> None:
    """Keep a method's pictures of a scene's views, (H, W, 3), linear, black outside the object."""
    path = _path(scene, method)
    path.parent.mkdir(parents=True, exist_ok=True)
    np.save(path, np.stack(pictures).astype(np.float16))


def kept(scene: str, method: str) -> Picture | None:
    """The pictures (views, H, W, 3) of a method, None if they were not kept."""
    path = _path(scene, method)
    return np.load(path).astype(np.float64) if path.exists() else None


def _path(scene: str, method: str) -> Path:
    return folder() / f"{scene}-{method.replace(' ', '-')}.npy"
