# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What does a bake cost in three.js, beside the materials that three.js has? Milliseconds of a frame.

    python -m tests.bench.three_cost FOLDER … [--side 512] [--frames 15] [--looks DIR]

Each FOLDER is a web export. Its mesh fills the picture, drawn by RadTex's material and by three.js's own on
the same mesh, in turns, in Chromium. Ratios are of medians. Where the bake is shown by the artist's own
images, three.js's materials have the same images; a lamp and surroundings light them, no shadows are cast.
Without a graphics card Chromium draws by SwiftShader.
"""

from __future__ import annotations

import argparse
import base64
import shutil
import statistics
import tempfile
from pathlib import Path

from tests.real.web import Site

from ..assets.three_scene import bundle_page
from ..engines.__main__ import programs

PAGE = Path(__file__).parent / "page.js"
OURS, TEMPORAL = "radtex", "temporal"  # the second with RADTEX_TEMPORAL
WAYS = ("basic", "lambert", "standard", "physical", "coated", OURS, TEMPORAL)


def main() -> None:
    """Print a table with a row for each folder."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--side", type=int, default=512, help="of the picture, in pixels")
    parser.add_argument("--frames", type=int, default=15)
    parser.add_argument("--looks", type=Path, help="folder for a picture of each")
    asked = parser.parse_args()
    print("| | " + " | ".join(f"{way}, ms" for way in WAYS) + " | over physical | temporal over physical |")
    print("|---|" + "---|" * (len(WAYS) + 2))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        with programs(folder) as showing:
            site = showing.site
            for number, export in enumerate(asked.folders):
                shutil.copytree(export, place := folder / f"export{number}")
                times = timed(site, place, asked.side, asked.frames, asked.looks)
                medians = {way: statistics.median(found) for way, found in times.items()}
                over = [f"{medians[way] / medians['physical']:.2f}" for way in (OURS, TEMPORAL)]
                row = [str(export), *(f"{medians[way]:.1f}" for way in WAYS), *over]
                print(f"| {' | '.join(row)} |", flush=True)


def timed(site: Site, place: Path, side: int, frames: int, looks: Path | None) -> dict[str, list[float]]:
    """Milliseconds of frames by each way, drawn in turns; `place` is an export below the site's folder."""
    bundle_page(place, PAGE)
    (manifest,) = place.glob("*.export.json")
    with site.opened(f"{place.name}/") as shown:
        page = shown.page
        page.wait_for_function("'opened' in window")
        page.evaluate("name => opened(name)", manifest.name)
        times: dict[str, list[float]] = {way: [] for way in WAYS}
        for way in WAYS:  # compile, upload
            picture = page.evaluate("asked => look(...asked)", [way, side])
            if looks is not None:
                looks.mkdir(parents=True, exist_ok=True)
                data = base64.b64decode(picture.partition(",")[2])
                (looks / f"{place.name}-{way}.png").write_bytes(data)
        for _ in range(frames):
            for way, found in times.items():
                found.append(page.evaluate("asked => frame(...asked)", [way, side]))
    return times


if __name__ == "__main__":
    main()
