# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The project's Results: tables, plots and figures, one command for each and one for all.

    python -m tests.bench.results                  text, plots and JSON anew, of what was measured (seconds)
    python -m tests.bench.results quality          all methods, five scenes, five bake seeds (1 hour)
    python -m tests.bench.results bytes            the same at 32 and 128 texels (3 hours)
    python -m tests.bench.results paths            the same with 1 and 4 samples (2 hours)
    python -m tests.bench.results lookup           what a lookup costs (2 minutes)
    python -m tests.bench.results stereo           what two eyes see, five bake seeds (half an hour)
    python -m tests.bench.results sheet            pictures of the worst views, after quality (a minute)
    python -m tests.bench.results --all            all of that
    python -m tests.bench.results --blend DIR      the scenes as .blend files

Hours are those of two cores without a GPU. Each bake that is measured is kept in docs/results/cells.json at
once, so that a run that is broken off goes on; `--seeds 1,2` takes fewer. References are rendered where the
user's cache folder lacks them.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

from . import kept_json
from .blends import write_blends
from .cells import Cells
from .filling import fill
from .matrix import BY_BYTES, BY_PATHS, MAIN, SEEDS, Group
from .page import write_page
from .sheet import save_sheet
from .stereo import stereo_figures

_BAKED = (Group.LAYERED, Group.CAPTURE, Group.BUCKETS, Group.DENOISED)


def main() -> None:
    """Measure what is asked for; then write everything anew."""
    options = _options()
    if options.blend is not None:
        for path in write_blends(options.blend):
            print(path)
        return
    cells = Cells(kept_json.FOLDER / "cells.json")
    for name in _MEASURES if options.all else options.tables:
        _MEASURES[name](cells, options.seeds)
    write_page(cells)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.results",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    known = ", ".join(_MEASURES)
    parser.add_argument("tables", nargs="*", type=_table, metavar="TABLE", help=f"of {known}")
    parser.add_argument("--all", action="store_true", help="measure all tables")
    parser.add_argument("--seeds", type=_numbers, default=SEEDS, help="of bakes (1,2,3,4,5)")
    parser.add_argument("--blend", type=Path, metavar="DIR", help="save the scenes as .blend files, no more")
    return parser.parse_args()


def _table(text: str) -> str:
    if text not in _MEASURES:
        raise argparse.ArgumentTypeError(f"{text} is none of {', '.join(_MEASURES)}")
    return text


def _numbers(text: str) -> tuple[int, ...]:
    return tuple(int(part) for part in text.split(","))


def _quality(cells: Cells, seeds: Sequence[int]) -> None:
    fill(cells, [MAIN], seeds, tuple(Group))


def _bytes(cells: Cells, seeds: Sequence[int]) -> None:
    fill(cells, BY_BYTES, seeds, _BAKED)


def _paths(cells: Cells, seeds: Sequence[int]) -> None:
    fill(cells, BY_PATHS, seeds, _BAKED)


def _lookup(cells: Cells, seeds: Sequence[int]) -> None:
    from .lookup import lookup_costs  # noqa: PLC0415  # no other table needs OpenGL

    kept_json.write("lookup", lookup_costs())


def _stereo(cells: Cells, seeds: Sequence[int]) -> None:
    kept_json.write("stereo", stereo_figures(seeds))


def _sheet(cells: Cells, seeds: Sequence[int]) -> None:
    if not save_sheet(kept_json.FOLDER / "sheet.webp", cells):
        print("no pictures of the first seed are kept: measure quality with an empty cells.json")


_MEASURES: dict[str, Callable[[Cells, Sequence[int]], None]] = {
    "quality": _quality,
    "bytes": _bytes,
    "paths": _paths,
    "lookup": _lookup,
    "stereo": _stereo,
    "sheet": _sheet,
}


if __name__ == "__main__":
    main()
