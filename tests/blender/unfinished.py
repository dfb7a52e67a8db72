# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake leaves that did not come to its end."""

from __future__ import annotations

import shutil
from pathlib import Path

from radtex_addon.store.checkpoint_files import KEY


def take_pieces(out: Path) -> bool:
    """Remove the one folder of finished pieces, and `out` if nothing else is in it; True if it was there.

    Nothing half-written may be in it.
    """
    folders = list(out.glob("*.radtex-unfinished"))
    for folder in folders:
        names = {path.name for path in folder.iterdir()}
        assert KEY in names
        assert len(names) > 1, "a key without pieces"
        assert all(name == KEY or Path(name).suffix == ".piece" for name in names), names
        shutil.rmtree(folder)
    if out.exists() and not any(out.iterdir()):
        out.rmdir()
    assert len(folders) <= 1, folders
    return bool(folders)
