# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures of each table as JSON in docs/results, from which text and plots are made."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from radtex_addon.formats.disk.atomic import replacing

FOLDER = Path(__file__).parents[3] / "docs" / "results"


def write(name: str, facts: Any) -> None:
    """Write a table's figures."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    with replacing(FOLDER / f"{name}.json") as beside:
        beside.write_text(json.dumps(facts, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def read(name: str) -> Any:
    """A table's figures, None if it was not measured."""
    path = FOLDER / f"{name}.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None
