# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The front page's pictures, and those of the extension platform's listing.

python -m tests.bench.films              all of them
python -m tests.bench.films orbit        docs/figures/orbit.webp and orbit.json: the before/after film
python -m tests.bench.films hero         docs/figures/hero.png, and what `listing` is made of
python -m tests.bench.films listing      docs/figures/listing-*: icon, featured picture, previews
python -m tests.bench.films blend        DIR/still-life.blend, to open in Blender
python -m tests.bench.films orbit --out DIR
"""

from __future__ import annotations

import argparse
from importlib import import_module
from pathlib import Path
from time import perf_counter

_FIGURES = Path(__file__).resolve().parents[3] / "docs" / "figures"
_PICTURES = ("orbit", "hero", "listing")


def main() -> None:
    """Make what was asked for."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.films",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help="of " + ", ".join((*_PICTURES, "blend")))
    parser.add_argument("--out", type=Path, default=_FIGURES, help="folder for what it makes (docs/figures)")
    options = parser.parse_args()
    for name in options.names:
        if name not in (*_PICTURES, "blend"):
            parser.error(f"there is no picture {name}: choose from {', '.join((*_PICTURES, 'blend'))}")
    options.out.mkdir(parents=True, exist_ok=True)
    for name in options.names or _PICTURES:
        began = perf_counter()
        import_module(f"{__package__}.{name}").make(options.out)
        print(f"{name}: {perf_counter() - began:.0f} s", flush=True)


if __name__ == "__main__":
    main()
