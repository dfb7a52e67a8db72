# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The report as one self-contained HTML file, with its pictures embedded."""

from __future__ import annotations

import math
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from ..core.arrays import Floats
from ..formats.containers.png import encode_png
from ..formats.disk.memory import readable_size
from ..job.variants import variant_of
from .causes import HalvedBake, first_change
from .finished_bake import Finished
from .judging import Judged, mean_energy, mean_flip, mean_glints, mean_psnr, part_figures, verdict
from .map_pictures import MapPictures
from .metrics import Figures, display
from .sizes import ImageSize, gpu_bytes

GAIN = 4  # the factor of the error pictures
_STYLE = """
:root { color-scheme: light dark; --ink: #1c1c1e; --paper: #fcfcfa; --line: #d5d5d0; --soft: #62625e; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e8e8e4; --paper: #191a1c; --line: #3c3d40; --soft: #a0a09a; }
}
body { font: 16px/1.5 system-ui, sans-serif; color: var(--ink); background: var(--paper);
       max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; margin-bottom: 0; }
h2 { font-size: 1.15rem; margin: 2.2rem 0 .5rem; }
.verdict { font-size: 1.2rem; }
p.note, figcaption { color: var(--soft); font-size: .9rem; }
div.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { text-align: right; padding: .3rem .6rem; border-bottom: 1px solid var(--line); }
th:first-child, td:first-child { text-align: left; }
th { font-weight: 600; }
figure { display: grid; grid-template-columns: repeat(3, 1fr); gap: .5rem; margin: 1rem 0; }
figure img { width: 100%; display: block; }
figcaption { grid-column: 1 / -1; }
"""


@dataclass(frozen=True, eq=False)
class Contents:
    """The data of a report; `variants` is None if none were baked."""

    bake: Finished
    judged: Sequence[Judged]
    floor: Figures
    sizes: list[ImageSize]
    variants: Sequence[HalvedBake] | None
    reference_samples: int
    map: MapPictures

    @property
    def verdict(self) -> str:
        return verdict(self.bake.sidecar.object_name, self.judged, self.floor)


def page(contents: Contents) -> str:
    """The HTML file's text."""
    name = escape(contents.bake.sidecar.object_name)
    parts = [
        f"<h1>{name}</h1>",
        f'<p class="note">{escape(_facts(contents.bake))}</p>',
        f'<p class="verdict">{escape(contents.verdict)}</p>',
        _closeness(contents),
        *_parts(contents.judged),
        "<h2>Pictures</h2>",
        *(_pictures(judged) for judged in contents.judged),
        "<h2>Map</h2>",
        _map(contents),
        "<h2>Size</h2>",
        _sizes(contents.sizes),
        "<h2>What the error comes from</h2>",
        _causes(contents),
    ]
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{name}: report of its bake</title>\n<style>{_STYLE}</style>\n</head>\n<body>\n"
        + "\n".join(parts)
        + "\n</body>\n</html>\n"
    )


def _facts(bake: Finished) -> str:
    facts = bake.sidecar
    traits = bake.form.traits
    named = f"{traits.layout} layout, " if traits.by_paths else ""
    cells = f" of {facts.bucket} × {facts.bucket} cells" if traits.any_cells else ""
    shows = [] if facts.source is None else [f"from {facts.source.object_name}"]
    shows += [word for word in (variant_of(bake.spec("auto")),) if word]
    return (
        f"{', '.join([bake.name, *shows])}: {named}{facts.width} × {facts.height} texels"
        f"{cells}, {facts.samples} samples, {facts.tool}, Blender {facts.blender}"
    )


def _closeness(contents: Contents) -> str:
    judged, floor = contents.judged, contents.floor
    rows = [["", "PSNR, dB", "FLIP", "energy", "glints"]]
    rows += [[one.view.name, *_row(one.figures)] for one in judged]
    means = [f"{mean_psnr(judged):.2f}", _flip(mean_flip(judged)), f"{mean_energy(judged):.3f}"]
    rows.append(["mean", *means, _share(mean_glints(judged))])
    rows.append(["the path-traced picture against another seed's", *_row(floor)])
    note = (
        f"Against path-traced views of {contents.reference_samples} samples a pixel, denoised; inside the "
        "object, but for its outermost pixels. PSNR is of display values (clipped to 0..1, gamma 2.2): more "
        "is better, and beyond the last row it says nothing. FLIP is the error that an eye sees, 0 to 1: "
        "less is better. Energy is the mean radiance over the path-traced one's: 1 is right. Glints: what is "
        "kept of the light of pixels that are brighter than white."
    )
    if floor.flip is None:
        note += " There is no FLIP for this platform."
    return _table(rows) + f'<p class="note">{note}</p>'


def _parts(judged: Sequence[Judged]) -> list[str]:
    """The figures of several objects, the worst first."""
    found = part_figures(judged)
    if not found:
        return []
    views = [one.view.name for one in judged]
    rows = [["", *(f"{view}, dB" for view in views), "mean, dB", "FLIP", "energy", "glints"]]
    for name, part in found.items():
        each = [f"{part.psnr[view]:.2f}" if view in part.psnr else "–" for view in views]
        rows.append([name, *each, *_row(part.mean)])
    note = (
        "Each object where it is seen, the worst first. Of one that shows a few pixels alone there is a dash."
    )
    return ["<h2>Objects</h2>", _table(rows), f'<p class="note">{note}</p>']


def _row(figures: Figures) -> list[str]:
    return [f"{figures.psnr:.2f}", _flip(figures.flip), f"{figures.energy:.3f}", _share(figures.glints)]


def _share(part: float | None) -> str:
    return "–" if part is None else f"{100 * part:.0f} %"


def _pictures(judged: Judged) -> str:
    reference, inside = display(judged.view.reference), judged.inside[..., None]
    ours = np.where(inside, display(judged.picture), reference)
    error = np.clip(GAIN * np.abs(ours - reference), 0, 1)
    labels = ("path traced", "as baked", f"error times {GAIN}")
    images = [
        f'<img alt="{judged.view.name}, {label}" src="{_data(picture)}">'
        for label, picture in zip(labels, (reference, ours, error), strict=True)
    ]
    caption = f"{judged.view.name}: {', '.join(labels)}. {judged.figures.psnr:.2f} dB."
    return f"<figure>{''.join(images)}<figcaption>{caption}</figcaption></figure>"


def _map(contents: Contents) -> str:
    found, bake = contents.map, contents.bake.sidecar
    names = [judged.view.name for judged in contents.judged]
    labels = ["the map", *(f"the checker, {name}" for name in names)]
    images = [
        f'<img alt="{label}" src="{_data(picture)}">'
        for label, picture in zip(labels, (found.picture, *found.checkers), strict=False)
    ]
    islands = "1 island covers" if found.islands == 1 else f"{found.islands} islands cover"
    told = (
        f"{islands} {found.coverage:.0%} of {bake.width} × {bake.height} texels, "
        f"with {found.density:.3g} texels to a unit of the surface on average."
    )
    wasteful = f" <strong>The map {escape(found.wasteful)}.</strong>" if found.wasteful else ""
    texels = "a texel" if found.square == 1 else f"{found.square} × {found.square} texels"
    caption = (
        "The map: an island in one colour, darker where texels are denser than on average. On the object, a "
        f"square is {texels}: small squares are dense texels, oblong ones are stretched, and a seam is where "
        "the colour changes."
    )
    return f"<p>{told}{wasteful}</p><figure>{''.join(images)}<figcaption>{caption}</figcaption></figure>"


def _data(picture: Floats) -> str:
    return "data:image/png;base64," + b64encode(encode_png(picture)).decode("ascii")


def _sizes(sizes: Sequence[ImageSize]) -> str:
    rows = [["image", "pixels", "on disk", "GPU, RGBA16F", "RGB9E5", "BC6H"]]
    for size in sizes:
        packed = [_size(size.rgb9e5), _size(size.bc6h)]
        pixels = f"{size.width} × {size.height}"
        rows.append([size.name, pixels, _size(size.disk), _size(size.rgba16f), *packed])
    if len(sizes) > 1:
        disk, whole = sum(size.disk for size in sizes), sum(size.rgba16f for size in sizes)
        nine = sum(size.rgba16f if size.rgb9e5 is None else size.rgb9e5 for size in sizes)
        block = sum(size.rgba16f if size.bc6h is None else size.bc6h for size in sizes)
        rows.append(["together", "", _size(disk), _size(whole), _size(nine), _size(block)])
    note = (
        "RGB9E5 and BC6H hold no alpha, and RGB9E5 nothing below 0: where there is a dash, the image stays "
        "RGBA16F. Both lose a little, which is not measured here."
    )
    return _table(rows) + f'<p class="note">{note}</p>'


def _causes(contents: Contents) -> str:
    variants, bake = contents.variants, contents.bake
    if bake.sidecar.objects:
        return "<p>Not measured of several objects in one atlas.</p>"
    if variants is None:
        return "<p>Not measured: a report with variants bakes the object again, with half of each.</p>"
    whole = f"{mean_psnr(contents.judged):.2f}"
    rows = [["", "PSNR, dB", "lost, dB", "FLIP", "M paths", "MB on a GPU"]]
    rows.append(
        ["as baked", whole, "", _flip(mean_flip(contents.judged)), "", f"{gpu_bytes(bake) / 1e6:.2f}"]
    )
    rows += [
        [
            variant.name,
            f"{variant.psnr:.2f}",
            f"{variant.lost:.2f}",
            _flip(variant.flip),
            f"{variant.paths / 1e6:.2f}",
            f"{variant.bytes / 1e6:.2f}",
        ]
        for variant in variants
    ]
    shown = "".join(f"<li>{variant.cause.word}: {escape(variant.shows)}</li>" for variant in variants)
    note = (
        "Each further row is a bake with half of one thing, against the same views. Less than nothing lost "
        "means that the smaller bake is the closer one."
    )
    first = escape(first_change(bake, variants))
    return f'<p class="verdict">{first}</p>{_table(rows)}<p class="note">{note}</p><ul>{shown}</ul>'


def _table(rows: Sequence[Sequence[str]]) -> str:
    head, *body = (
        "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in row)
        for tag, row in zip(["th"] + ["td"] * (len(rows) - 1), rows, strict=True)
    )
    lines = "\n".join(f"<tr>{row}</tr>" for row in body)
    return f'<div class="wide"><table>\n<tr>{head}</tr>\n{lines}\n</table></div>'


def _flip(value: float | None) -> str:
    return "–" if value is None or math.isnan(value) else f"{value:.3f}"


def _size(count: int | None) -> str:
    return "–" if count is None else readable_size(count)
