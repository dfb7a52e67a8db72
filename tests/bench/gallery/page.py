# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The gallery's page, docs/gallery.md: figures, pictures and what an artist sees in them.

Figures are kept in figures/gallery.json, so that a row can be made anew without the others.
"""

from __future__ import annotations

import io
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import bpy
import numpy as np
from PIL import Image

from radtex_addon.formats.disk.atomic import replacing
from radtex_addon.report.metrics import display

from ..films.encode import save_film
from .captions import CAPTIONS
from .row import Row, Use

_MOST_BYTES = 160_000  # of a picture
_COLOURS = (None, 256, 160, 96, 64, 40)  # None is all
_PER_SECOND, _MOST_FILM_BYTES = 12, 300_000
_GAIN = 4  # of the differences
_OUTSIDE = 0.12  # a display value, where nothing is measured
_HEAD = """<!-- SPDX-FileCopyrightText: 2026 RadTex authors -->
<!-- SPDX-License-Identifier: GPL-3.0-or-later -->
# What a radiance texture can hold

A radiance texture holds the light that an object sends in every direction. This page shows what can be baked
into one: each effect on a small scene, from cameras that were not used in the bake.
{orbit}{still_life}
## How to read the rows

* A row's picture is of the view with the largest error. From the left: path traced by Cycles, ours, and their
  difference times {gain}. Where the effect is one of motion, a film stands below: path traced, ours.
* dB (PSNR) compares what a display shows: values are clipped and have a gamma of 2.2. Only pixels of the
  object count. More is better; from about 40 dB on, few people see a difference.
* FLIP is an error that takes account of how people look: 0 means that nobody can tell the pictures apart.
* The table names each row's layout. *Layered* is the default. Shadow, transfer, ambient occlusion, proxies,
  volumes, parts of light, and rays that end in an atlas have *buckets* only. Where a row has both, they are
  bakes of one scene.
* Buckets of light are denoised ([format.md](format.md), "Denoising"), but not those of the row Proxy.
* Seconds are of two CPU cores that had other work to do.

[results.md](results.md) has harder scenes, other methods, and
[an asset of six parts](results.md#an-asset-of-several-parts) beside three.js and Eevee.

    uv run --group test python -m tests.bench.gallery            makes this page, its pictures and its figures
    uv run --group test python -m tests.bench.gallery {first}      makes one row of it anew
    uv run --group test python -m tests.bench.gallery --films     makes the films alone

| effect | dB, worst to best | FLIP | views | seconds |
|---|---|---|---|---|
"""


@dataclass(frozen=True)
class Record:
    """A row's figures: each view's name, decibels, FLIP (or None) and note; and the whole's `seconds`.

    `film` has the decibels of the film's frames in their order, if there is a film; `beside` the names of
    views that stand beside what the row is about.
    """

    views: list[tuple[str, float, float | None, str]]
    seconds: float
    blender: str
    film: list[float] = field(default_factory=list)
    beside: list[str] = field(default_factory=list)

    @classmethod
    def of(cls, rows: Sequence[Row], frames: Sequence[Row], seconds: float) -> Record:
        """Measure rows, and frames of the film."""
        views = [(row.name, row.psnr, row.flip, row.note) for row in rows]
        film = [round(frame.psnr, 2) for frame in frames]
        beside = [row.name for row in rows if row.use is Use.TABLE]
        return cls(views, seconds, bpy.app.version_string, film, beside)


def save_picture(path: Path, rows: Sequence[Row]) -> None:
    """Save path traced | ours | difference of the worst of `rows`, as a PNG of at most _MOST_BYTES."""
    row = min((row for row in rows if row.use is Use.PICTURE), key=lambda row: row.psnr)
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


def save_frames(path: Path, frames: Sequence[Row]) -> None:
    """Save path traced | ours of each frame, as a WebP that repeats, of at most _MOST_FILM_BYTES."""
    joined = []
    for row in frames:
        inside = (row.mask if row.around is None else row.mask | row.around)[..., None]
        pair = [np.where(inside, display(picture), _OUTSIDE) for picture in (row.reference, row.ours)]
        joined.append(np.concatenate(pair, axis=1))
    save_film(path, joined, _PER_SECOND, _MOST_FILM_BYTES)


def _encoded(picture: Image.Image, colours: int | None) -> bytes:
    """A PNG of so many colours, or of all."""
    encoded = io.BytesIO()
    kept = picture if colours is None else picture.quantize(colours, dither=Image.Dither.FLOYDSTEINBERG)
    kept.save(encoded, "PNG", optimize=True)
    return encoded.getvalue()


def record_of(folder: Path, name: str) -> Record:
    """A row's figures in figures/gallery.json of a folder. Raises KeyError where it has none."""
    return Record(**json.loads((folder / "figures" / "gallery.json").read_text())[name])


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
    page = _HEAD.format(
        gain=_GAIN,
        first=next(iter(CAPTIONS)),
        orbit=_before_and_after(folder),
        still_life=_still_life(folder),
    )
    page += "".join(_line(key, found) for key, found in known.items())
    page += "".join(_section(key, found) for key, found in known.items())
    with replacing(folder / "gallery.md") as beside:
        beside.write_text(page)


def _before_and_after(folder: Path) -> str:
    """The film of `tests.bench.films orbit` with its figures; empty where it was not made."""
    kept = folder / "figures" / "orbit.json"
    if not kept.is_file():
        return ""
    facts = json.loads(kept.read_text())
    spans = facts["decibels, worst to best"]
    told = "; ".join(f"{name} {low:.1f} to {high:.1f} dB" for name, (low, high) in spans.items())
    sizes = ", ".join(f"{size / 1e6:.1f} MB" for size in facts["bytes on a GPU"].values())
    return f"""
## Before and after

![path traced, RadTex, flat lightmap, reflection probe](figures/orbit.webp)

*Once around a glazed teapot in {facts["frames"]} frames. The teapot alone is baked, with the defaults
({facts["texels"]} texels); all else is path traced in all four. Worst to best frame: {told}.
On a GPU, compressed: {sizes}. `uv run --group test python -m tests.bench.films orbit`,
Blender {facts["blender"]}.*
"""


def _still_life(folder: Path) -> str:
    """The picture of `tests.bench.films hero` with its figures; empty where it was not made."""
    kept = folder / "figures" / "hero.json"
    if not kept.is_file():
        return ""
    facts = json.loads(kept.read_text())
    told = ", ".join(f"{name.lower()} {found:.1f} dB" for name, found in facts["decibels"].items())
    return f"""
![a still life, its left half path traced, its right half baked](figures/hero.png)

*A still life under crisp light. Left of the line it is path traced, right of it the pots are baked, each
alone and with the defaults, and rendered by {facts["preview"]} with their previews. Over the whole picture,
worst first: {told}; highlights come out softer. `uv run --group test python -m tests.bench.films hero`,
Blender {facts["blender"]}.*
"""


def _line(name: str, record: Record) -> str:
    views = [view for view in record.views if view[0] not in record.beside]
    decibels = [psnr for _, psnr, _, _ in views]
    flips = [flip for _, _, flip, _ in views if flip is not None]
    flip = f"{max(flips):.3f} to {min(flips):.3f}" if flips else ""
    title = CAPTIONS[name].title
    link = "".join(letter for letter in title.lower() if letter.isalnum() or letter in " -").replace(" ", "-")
    figures = f"{min(decibels):.1f} to {max(decibels):.1f} | {flip} | {len(decibels)} | {record.seconds:.0f}"
    return f"| [{title}](#{link}) | {figures} |\n"


def _film(name: str, decibels: Sequence[float]) -> list[str]:
    """The film of a row that has one, and how near its frames are."""
    if not decibels:
        return []
    span = f"{min(decibels):.1f} to {max(decibels):.1f} dB, worst to best"
    return [
        f"![path traced, ours, moving](figures/gallery-{name}.webp)\n",
        f"*Path traced and ours in {len(decibels)} frames: {span}.*\n",
    ]


def _section(name: str, record: Record) -> str:
    caption = CAPTIONS[name]
    lines = [
        f"\n## {caption.title}\n",
        f"![path traced, ours, difference](figures/gallery-{name}.png)\n",
        *_film(name, record.film),
        f"{caption.shows} {caption.seen}".rstrip() + "\n",
        "| view | dB | FLIP | |",
        "|---|---|---|---|",
    ]
    for view, psnr, flip, note in record.views:
        lines.append(f"| {view} | {psnr:.1f} | {'' if flip is None else f'{flip:.3f}'} | {note} |")
    command = f"`uv run --group test python -m tests.bench.gallery {name}`"
    lines.append(f"\n{command}, Blender {record.blender}, {record.seconds:.0f} s.")
    return "\n".join(lines) + "\n"
