# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery's page, docs/gallery.md: figures, pictures and what an artist sees in them.

Figures are kept in figures/gallery.json, so that a row can be made anew without the others.
"""

from __future__ import annotations

import io
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import bpy
import numpy as np
from PIL import Image

from radtex_addon.formats.disk.atomic import replacing
from radtex_addon.report.metrics import display

from .captions import CAPTIONS
from .row import Row

_MOST_BYTES = 160_000  # of a picture
_COLOURS = (None, 256, 160, 96, 64, 40)  # None is all
_GAIN = 4  # of the differences
_OUTSIDE = 0.12  # a display value, where nothing is measured
_HEAD = """<!-- SPDX-FileCopyrightText: 2026 RadTex authors -->
<!-- SPDX-License-Identifier: GPL-3.0-or-later -->
# What a radiance texture can hold

Each effect and kind on a small scene, from cameras that no bake knows: path traced by Cycles | ours | their
difference, times {gain}, of the view that came out worst. Decibels are of what a display shows (clipped, by a
gamma of 2.2), inside the object's silhouette; FLIP is 0 for what nobody can tell apart. Seconds are of
two CPU cores with other work beside. Buckets of light are denoised ([format.md](format.md), "Denoising"),
but for the row Proxy, whose cells are raw means. The first row is what a
bake makes by default, in the layered layout, under hard lamps. The other scenes were chosen for what
buckets of this many texels and cells can hold: soft light, rough or curved things.
[results.md](results.md) has harder ones.

    uv run --group test python -m tests.bench.gallery            makes this page, its pictures and its figures
    uv run --group test python -m tests.bench.gallery {first}      makes one row of it anew

| effect | dB, worst to best | FLIP | views | seconds |
|---|---|---|---|---|
"""


@dataclass(frozen=True)
class Record:
    """A row's figures: each view's name, decibels, FLIP (or None) and note; and the whole's `seconds`."""

    views: list[tuple[str, float, float | None, str]]
    seconds: float
    blender: str

    @classmethod
    def of(cls, rows: Sequence[Row], seconds: float) -> Record:
        """Measure rows."""
        views = [(row.name, row.psnr, row.flip, row.note) for row in rows]
        return cls(views, seconds, bpy.app.version_string)


def save_picture(path: Path, rows: Sequence[Row]) -> None:
    """Save path traced | ours | difference of the worst of `rows`, as a PNG of at most _MOST_BYTES."""
    row = min(rows, key=lambda row: row.psnr)
    inside = (row.mask if row.around is None else row.mask | row.around)[..., None]
    truth, ours = display(row.reference), display(row.ours)
    panels = [truth, ours, np.clip(_GAIN * np.abs(ours - truth), 0, 1)]
    joined = np.concatenate([np.where(inside, panel, _OUTSIDE) for panel in panels], axis=1)
    picture = Image.fromarray((joined * 255 + 0.5).astype(np.uint8))
    encoded = (_encoded(picture, colours) for colours in _COLOURS)
    fitting = next((found for found in encoded if len(found) <= _MOST_BYTES), None)
    path.parent.mkdir(parents=True, exist_ok=True)
    with replacing(path) as beside:
        beside.write_bytes(fitting or _encoded(picture, 8))


def _encoded(picture: Image.Image, colours: int | None) -> bytes:
    """A PNG of so many colours, or of all."""
    encoded = io.BytesIO()
    kept = picture if colours is None else picture.quantize(colours, dither=Image.Dither.FLOYDSTEINBERG)
    kept.save(encoded, "PNG", optimize=True)
    return encoded.getvalue()


def write_page(folder: Path, name: str, record: Record) -> None:
    """Put a row's figures into gallery.md and figures/gallery.json of a folder."""
    kept = folder / "figures" / "gallery.json"
    records = json.loads(kept.read_text()) if kept.exists() else {}
    records[name] = asdict(record)
    with replacing(kept) as beside:
        beside.write_text(
            json.dumps({key: records[key] for key in CAPTIONS if key in records}, indent=1) + "\n"
        )
    known = {key: Record(**records[key]) for key in CAPTIONS if key in records}
    page = _HEAD.format(gain=_GAIN, first=next(iter(CAPTIONS)))
    page += "".join(_line(key, found) for key, found in known.items())
    page += "".join(_section(key, found) for key, found in known.items())
    with replacing(folder / "gallery.md") as beside:
        beside.write_text(page)


def _line(name: str, record: Record) -> str:
    decibels = [psnr for _, psnr, _, _ in record.views]
    flips = [flip for _, _, flip, _ in record.views if flip is not None]
    flip = f"{max(flips):.3f} to {min(flips):.3f}" if flips else ""
    title = CAPTIONS[name].title
    link = "".join(letter for letter in title.lower() if letter.isalnum() or letter in " -").replace(" ", "-")
    figures = f"{min(decibels):.1f} to {max(decibels):.1f} | {flip} | {len(decibels)} | {record.seconds:.0f}"
    return f"| [{title}](#{link}) | {figures} |\n"


def _section(name: str, record: Record) -> str:
    caption = CAPTIONS[name]
    lines = [
        f"\n## {caption.title}\n",
        f"![path traced, ours, difference](figures/gallery-{name}.png)\n",
        f"{caption.shows} {caption.seen}".rstrip() + "\n",
        "| view | dB | FLIP | |",
        "|---|---|---|---|",
    ]
    for view, psnr, flip, note in record.views:
        lines.append(f"| {view} | {psnr:.1f} | {'' if flip is None else f'{flip:.3f}'} | {note} |")
    command = f"`uv run --group test python -m tests.bench.gallery {name}`"
    lines.append(f"\n{command}, Blender {record.blender}, {record.seconds:.0f} s.")
    return "\n".join(lines) + "\n"
