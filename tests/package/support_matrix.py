# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What each kind and layout can be baked with and exported to, asked of the code that would refuse it.

python -m tests.package.support_matrix    # writes docs/support.md
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from radtex_addon.core.errors import InputError
from radtex_addon.farm.farm_manifest import check_farmable
from radtex_addon.farm.part_frames import PARTS, has_frames
from radtex_addon.farm.prepare_tasks import check_farmed
from radtex_addon.settings.spec import BakeSpec, Kind, Layer, Layout
from radtex_addon.settings.targets import check_target
from radtex_addon.textures.export_spec import Target

PAGE = Path(__file__).resolve().parents[2] / "docs" / "support.md"
LAYOUTS: dict[str, dict[str, Any]] = {
    "": {},
    ", layered": {"layout": Layout.LAYERED},
}
ROWS: dict[str, dict[str, Any]] = {
    f"{kind}{title}": {"kind": kind, **layout} for kind in Kind for title, layout in LAYOUTS.items()
}
OPTIONS: dict[str, dict[str, Any]] = {
    "layers": {"layers": (Layer.DIFFUSE,)},
    "from another object": {"source": "High"},
    "some lamps": {"lights": ("Key",)},
    "several objects in one atlas": {"objects": ("A", "B")},
    "an atlas a material": {"split": "material", "part": "Wood"},
    "frames": {"frame": 7},
    "accumulate": {"accumulate": True},
    "refresh": {"refresh": True},
    "panoramic capture": {"capture": "panoramic"},
    "32-bit floats": {"half": False},
    "DWAA compression": {"compression": "dwaa"},
    "content": {"content": "Shelf"},
    "view": {"view": "camera"},
    "distance": {"ao_distance": 0.5},
}
_INTRODUCTION = """\
<!-- SPDX-FileCopyrightText: 2026 RadTex authors -->
<!-- SPDX-License-Identifier: GPL-3.0-or-later -->
# What goes with what

Each row is a kind of bake, in layout buckets or the layered layout; each column something that it can be
baked with, or exported to. **yes**: it works. A number: it is refused, for the reason of that number below,
in the words of the error. The page is written by `python -m tests.package.support_matrix`, which asks the
code that refuses; a test compares.
"""


def main() -> None:
    PAGE.write_text(page(), encoding="utf-8")


def page() -> str:
    """The page's text."""
    reasons: dict[str, int] = {}
    tables = [
        _table("baked with", {name: _baked(changes) for name, changes in OPTIONS.items()}, reasons),
        _table(
            "rendered or exported by",
            {
                "a farm with RadTex": _farmed,
                "a farm without RadTex": _framed,
                **{str(t): _exported(t) for t in Target},
            },
            reasons,
        ),
    ]
    listed = "\n".join(f"{number}. {reason}" for reason, number in reasons.items())
    return "\n".join([_INTRODUCTION, *tables, "## Reasons\n", listed, ""])


Check = Callable[[dict[str, Any]], str | None]  # the cell's words, if not yes


def _baked(changes: dict[str, Any]) -> Check:
    def check(row: dict[str, Any]) -> None:
        _made(row | changes)

    return check


def _farmed(row: dict[str, Any]) -> None:
    check_farmed([("", _made(row))])


def _framed(row: dict[str, Any]) -> str | None:
    if has_frames(_made(row)):
        return f"in part: its {' and '.join(PARTS)}"
    check_farmable(_made(row))
    return None


def _exported(target: Target) -> Check:
    return lambda row: check_target("the bake", _made(row).kind, target)


def _made(fields: dict[str, Any]) -> Any:
    return BakeSpec(**fields)


def _table(title: str, columns: dict[str, Check], reasons: dict[str, int]) -> str:
    lines = [f"| {title} | {' | '.join(columns)} |", "|---" * (len(columns) + 1) + "|"]
    for name, row in _possible():
        cells = [_cell(check, row, reasons) for check in columns.values()]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def _possible() -> Iterator[tuple[str, dict[str, Any]]]:
    """The rows whose kind and layout go together at all."""
    for name, row in ROWS.items():
        try:
            _made(row)
        except InputError:
            continue
        yield name, row


def _cell(check: Check, row: dict[str, Any], reasons: dict[str, int]) -> str:
    try:
        return check(row) or "yes"
    except InputError as error:
        reason = re.sub(rf"\b(kind |a )?{row['kind']}\b", "this kind", str(error), count=1)
        return str(reasons.setdefault(reason, len(reasons) + 1))


if __name__ == "__main__":
    main()
