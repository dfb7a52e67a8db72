# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes of one run whose files would have the same names, so that one would replace the other's."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from ..core.errors import InputError
from ..formats.disk.path_checks import nearest_folder
from .output_files import OutputFiles
from .variants import Bake, variant_of


def check_output_collisions(bakes: Sequence[Bake], out: Path, preview: bool) -> None:
    """Make sure that no two bakes write the same file in the folder `out`.

    Names may be the same although their Unicode forms differ (é), or their case if the filesystem ignores
    it. Raises InputError for the first two that share a file.
    """
    if len(bakes) < 2:
        return
    joins_case: bool | None = None
    owners: dict[str, tuple[str, Bake]] = {}
    for bake in bakes:
        name, spec = bake
        for path in OutputFiles.of(name, spec, out, preview).own:
            known, owner = owners.setdefault(path.name.casefold(), (path.name, bake))
            if owner is bake:
                continue
            if known != path.name and joins_case is None:
                joins_case = _joins_case(out)
            if known == path.name or joins_case:
                raise InputError(
                    f"{_told(owner)} and {_told(bake)} would both become {out / path.name}: "
                    "rename one of them, or bake them into folders of their own"
                )


def _told(bake: Bake) -> str:
    name, spec = bake
    words = [f"'{name}'", *([f"its {spec.split} '{spec.part}'"] if spec.part is not None else [])]
    return ", ".join([*words, *([variant_of(spec)] if variant_of(spec) else [])])


def _joins_case(folder: Path) -> bool:
    """Whether the folder's filesystem ignores the case of names."""
    with (
        suppress(OSError),
        tempfile.NamedTemporaryFile(dir=nearest_folder(folder), prefix=".radtex-", suffix="-a") as file,
    ):
        return Path(f"{file.name[:-1]}A").exists()
    return False
