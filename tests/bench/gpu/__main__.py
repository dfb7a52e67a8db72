# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What does a lookup cost on this machine's card? No Blender is needed: `pip install moderngl numpy`.

    python -m tests.bench.gpu --out DIR

Objects that were baked before (`bakes`) fill a picture, over EGL, without a window: by the lookups as they
ship, and by what they are compared with (`baselines`). All draw in turns, frame after frame. DIR gets
speed.json, and each lookup's picture to look at; the table is printed. Textures are in blocks, as exports
are; on the processor (llvmpipe), which needs seconds to read them, they are decoded.

The bakes have 64 texels; with `--texels` they lie in memory as larger ones would, their values interpolated.
A frame's time is its timer query's, and on the processor the time of all its threads.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.formats.codecs.srgb import to_srgb
from radtex_addon.formats.containers.png import encode_png

from ..drawing import Canvas, Painter, View, canvas
from .lookups import PHYSICALLY_BASED, lookups_of
from .subject import TEXELS, Subject, names
from .timing import Device, NoDeviceError, cards, device, measured

DIFFUSE = "diffuse"
_DRAWS = 8  # in a frame, on a card: one alone takes less time than its clock needs to speed up


def main(arguments: list[str] | None = None) -> int:
    options = _parser().parse_args(arguments)
    if options.list:
        print("\n".join(f"{number}: {card}" for number, card in enumerate(cards())))
        return 0
    if options.table:
        print("\n\n".join(table(json.loads(path.read_text(encoding="utf-8"))) for path in options.table))
        return 0
    times, odd = divmod(options.texels, TEXELS)
    if odd or times < 1 or options.frames < 1:
        _parser().error(f"--texels is {TEXELS} times a whole number, --frames is 1 or more")
    objects, blocks, out = options.objects or names(), options.blocks, options.out
    if unknown := set(objects) - set(names()):
        _parser().error(f"{', '.join(sorted(unknown))}: choose of {', '.join(names())}")
    try:
        with device(options.device) as found:
            figures = speed(found, objects, options.size, options.frames, times, blocks, out)
    except NoDeviceError as error:
        _parser().error(str(error))
    options.out.mkdir(parents=True, exist_ok=True)
    path = options.out / "speed.json"
    path.write_text(json.dumps(figures, indent=1) + "\n", encoding="utf-8")
    print(table(figures))
    print(f"\n{path}, and the pictures beside it")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.gpu",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("objects", nargs="*", help=f"of {', '.join(names())} (default: all)")
    parser.add_argument(
        "--out", type=Path, default=Path("speed"), help="folder for the results (default: speed)"
    )
    parser.add_argument(
        "--size", type=_size, default=(1920, 1080), help="of the picture (default: 1920x1080)"
    )
    parser.add_argument("--frames", type=int, default=50, help="of which the median is taken (default: 50)")
    parser.add_argument("--texels", type=int, default=128, help="of the bakes, 64 times N (default: 128)")
    parser.add_argument(
        "--device", type=int, help="by its number in --list (default: the first that is a card)"
    )
    parser.add_argument("--list", action="store_true", help="list the devices")
    parser.add_argument(
        "--blocks", action=argparse.BooleanOptionalAction, help="textures in blocks (default: on cards)"
    )
    parser.add_argument("--table", type=Path, nargs="+", metavar="JSON", help="print the tables of results")
    return parser


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    return int(width), int(height)


def speed(
    found: Device,
    objects: list[str],
    size: tuple[int, int],
    frames: int,
    times: int,
    blocks: bool | None,
    out: Path | None,
) -> dict[str, Any]:
    """All figures of some objects, for the JSON; pictures go to `out`."""
    in_blocks = not found.is_processor if blocks is None else blocks
    draws = 1 if found.is_processor else _DRAWS
    return {
        "card": found.card,
        "driver": found.driver,
        "clock": found.clock,
        "size": list(size),
        "frames": frames,
        "draws": draws,
        "texels": TEXELS * times,
        "textures": "blocks" if in_blocks else "decoded",
        "bytes_fetched": None,  # OpenGL has no counter for it
        "objects": {
            name: _of_object(found, Subject.read(name, times), size, frames, draws, in_blocks, out)
            for name in objects
        },
    }


def _of_object(
    found: Device,
    subject: Subject,
    size: tuple[int, int],
    frames: int,
    draws: int,
    blocks: bool,
    out: Path | None,
) -> dict[str, Any]:
    print(f"{subject.name} …", file=sys.stderr, flush=True)
    view = subject.view(size)
    lookups = lookups_of(found.context, subject, blocks)
    target = canvas(found.context, size)
    pictures = {name: drawn(lookup.painter, view, target) for name, lookup in lookups.items()}
    counts = {name: drawn(lookup.counting(), view, target) for name, lookup in lookups.items()}
    if out is not None:
        _save(pictures, out / subject.name)
    took = measured(
        found, {name: (lookup.painter, view) for name, lookup in lookups.items()}, size, frames, draws
    )
    rows = {}
    for name, lookup in lookups.items():
        clock = took[name].clock
        rows[name] = {
            "ms": _median(clock),
            "wall_ms": _median(took[name].wall),
            "over_diffuse": _median(clock / took[DIFFUSE].clock),
            "over_physically_based": _median(clock / took[PHYSICALLY_BASED].clock),
            "fetches": lookup.fetches,
            "fetches_made": _made(counts[name]),
            "bytes": lookup.bytes,
            "bytes_here": lookup.bytes_here,
            "mean_light": round(float(pictures[name][..., :3].mean()), 4),
        }
    covered = float(pictures[DIFFUSE][..., 3].mean())
    return {"covered": round(covered, 3), "lookups": rows}


def drawn(painter: Painter, view: View, target: Canvas) -> Floats:
    """The picture by a lookup, linear (H, W, 4), the top row first; alpha is 1 where the object is."""
    painter.draw(target.drawn, view)
    return target.read()[::-1]


def _made(counts: Floats) -> float:
    """The mean of red over the pixels where the object is."""
    return round(float(counts[counts[..., 3] > 0, 0].mean()), 2)


def _save(pictures: dict[str, Floats], folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    for name, picture in pictures.items():
        shown = to_srgb(1 - np.exp(-np.maximum(picture[..., :3], 0)))  # a film's: highlights keep their shape
        (folder / f"{name.replace(', ', '-').replace(' ', '-')}.png").write_bytes(encode_png(shown))


def _median(values: Floats) -> float:
    return round(float(np.median(values)), 4)


def table(figures: dict[str, Any]) -> str:
    """The figures as a table in Markdown: a row for each lookup."""
    objects = figures["objects"]
    counted = all("fetches_made" in row for each in objects.values() for row in each["lookups"].values())
    made = " made |" if counted else ""
    rows = [
        _conditions(figures),
        "",
        "| ms a frame | "
        + " | ".join(objects)
        + " | over diffuse | over physically based | fetches |"
        + made
        + " MB |",
        "|---" * (len(objects) + 5 + counted) + "|",
    ]
    for name in next(iter(objects.values()))["lookups"]:
        found = [each["lookups"][name] for each in objects.values()]
        cells = [f"{one['ms']:.3g}" if one["ms"] < 100 else f"{one['ms']:.0f}" for one in found]
        cells += [
            f"{np.median([one[key] for one in found]):.2f}"
            for key in ("over_diffuse", "over_physically_based")
        ]
        cells += [
            _range([one["fetches"] for one in found], "d"),
            *([_range([one["fetches_made"] for one in found], ".1f")] if counted else []),
            _range([one["bytes"] / 1e6 for one in found], ".1f"),
        ]
        rows.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(rows)


def _conditions(figures: dict[str, Any]) -> str:
    width, height = figures["size"]
    textures = "in blocks" if figures["textures"] == "blocks" else "decoded"
    return (
        f"*{figures['card']}; {figures['driver']}. {width} x {height} pixels, bakes of {figures['texels']} "
        f"texels, textures {textures}. Medians of {figures['frames']} frames by {figures['clock']}.*"
    )


def _range(values: list[Any], kind: str) -> str:
    least, most = (f"{end:{kind}}" for end in (min(values), max(values)))
    return least if least == most else f"{least} to {most}"


if __name__ == "__main__":
    sys.exit(main())
