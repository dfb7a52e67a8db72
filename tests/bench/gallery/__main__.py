# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a radiance texture can hold, path traced and ours, in one page.

    python -m tests.bench.gallery                    every row
    python -m tests.bench.gallery proxy interior     these; the page keeps the others' as they were
    python -m tests.bench.gallery --films proxy      its film alone
    python -m tests.bench.gallery proxy --out DIR

A row is a module here with a function `rows`, and `kept_seconds` if its bake is kept. Writes gallery.md,
figures/gallery-ROW.png and, of what moves, figures/gallery-ROW.webp into DIR (docs).
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from time import perf_counter

from .captions import CAPTIONS, FILMS
from .page import Record, record_of, save_frames, save_picture, write_page
from .row import Row, Use

_DOCS = Path(__file__).resolve().parents[3] / "docs"


def main() -> None:
    """Bake, look, compare, write."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.gallery",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("rows", nargs="*", metavar="ROW", help="of " + ", ".join(CAPTIONS))
    parser.add_argument(
        "--films", action="store_true", help="films alone: tables and stills stay as they are"
    )
    parser.add_argument("--out", type=Path, default=_DOCS, help="folder of gallery.md (docs)")
    options = parser.parse_args()
    known = FILMS if options.films else tuple(CAPTIONS)
    for name in options.rows:
        if name not in known:
            parser.error(
                f"there is no {'film' if options.films else 'row'} {name}: choose from {', '.join(known)}"
            )
    for name in options.rows or known:
        (_film if options.films else _row)(options.out, name)


def _row(out: Path, name: str) -> None:
    """Make a row's table, picture and film."""
    began, module = perf_counter(), import_module(f"{__package__}.{name}")
    before = module.kept_seconds() if hasattr(module, "kept_seconds") else 0.0
    found = [_told(row) for row in module.rows()]
    frames = [row for row in found if row.use is Use.FILM]
    views = [row for row in found if row.use is not Use.FILM]
    record = Record.of(views, frames, before + perf_counter() - began)
    save_picture(out / "figures" / f"gallery-{name}.png", views)
    if frames:
        save_frames(out / "figures" / f"gallery-{name}.webp", frames)
    write_page(out, name, record)


def _film(out: Path, name: str) -> None:
    """Make a row's film; the page must have the row."""
    frames = [_told(row) for row in import_module(f"{__package__}.{name}").rows(stills=False)]
    save_frames(out / "figures" / f"gallery-{name}.webp", frames)
    write_page(out, name, replace(record_of(out, name), film=[round(frame.psnr, 2) for frame in frames]))


def _told(row: Row) -> Row:
    flip = "" if row.flip is None else f", FLIP {row.flip:.3f}"
    print(f"{row.name}: {row.psnr:.1f} dB{flip}. {row.note}", flush=True)
    return row


if __name__ == "__main__":
    main()
