# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How still are lookups when the camera moves? Frames a quarter of a pixel apart, held against each other.

    python -m tests.bench.gpu.stillness [convex rough film lights shared] [--looks DIR]

The objects of `tests.bench.gpu`, drawn by the GLSL shader with MSAA of 4 samples at 1, 3 and 10 times a
distance at which they fill the picture: the mean PSNR of one frame against the next, of display values, where
both show the object. Beside it the physically based lookup, and ours without RADTEX_STEADY.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.frame import normalised
from radtex_addon.formats.codecs.srgb import to_srgb
from radtex_addon.formats.containers.png import encode_png
from radtex_addon.report.metrics import psnr

from ..drawing import Canvas, Painter, View, canvas
from .lookups import PHYSICALLY_BASED, lookups_of
from .subject import Subject, names
from .timing import device

SIZE, SAMPLES = 256, 4
TIMES = (1, 3, 10)
FRAMES, STEP = 5, 0.25  # of each film, and pixels between one and the next
FAR = 1.6  # times the bench's distance, from which an object is more than the picture
STEADY = 0.16  # as exports define it
LAYERED = "layered"


def main(arguments: list[str] | None = None) -> None:
    """Film each object, print a table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("objects", nargs="*", help=f"of {', '.join(names())} (default: all)")
    parser.add_argument("--looks", type=Path, help="folder for the first frame of each film")
    asked = parser.parse_args(arguments)
    print("| object | way | " + " | ".join(f"{times} x, dB" for times in TIMES) + " |")
    print("|---|---|" + "---|" * len(TIMES))
    with device(None) as found:
        target = canvas(found.context, (SIZE, SIZE), SAMPLES)
        for name in asked.objects or names():
            subject = Subject.read(name)
            plain, ours = (
                lookups_of(found.context, each, blocks=False) for each in (subject, _steady(subject))
            )
            ways = {
                "RadTex": ours[LAYERED].painter,
                "RadTex, without RADTEX_STEADY": plain[LAYERED].painter,
                PHYSICALLY_BASED: plain[PHYSICALLY_BASED].painter,
            }
            for way, painter in ways.items():
                films = [list(_film(painter, subject, target, times)) for times in TIMES]
                print(
                    f"| {name} | {way} | {' | '.join(f'{_still(film):.1f}' for film in films)} |", flush=True
                )
                if asked.looks:
                    asked.looks.mkdir(parents=True, exist_ok=True)
                    whole = np.concatenate([film[0][..., :3] for film in films], axis=1)
                    file = f"{name}-{way.replace(', ', '-').replace(' ', '-')}.png"
                    (asked.looks / file).write_bytes(encode_png(to_srgb(np.clip(whole, 0, 1))))


def _steady(subject: Subject) -> Subject:
    """The same object, whose layered lookup has RADTEX_STEADY."""
    variant = subject.facts["variants"][LAYERED]
    defined = {**variant, "defines": {**variant["defines"], "RADTEX_STEADY": STEADY}}
    return replace(subject, facts={**subject.facts, "variants": {LAYERED: defined}}, _made={})


def _film(painter: Painter, subject: Subject, target: Canvas, times: float) -> Iterator[Floats]:
    """Pictures (H, W, 4), linear; alpha is 1 where the object is, of all of a pixel's samples."""
    view = subject.view((SIZE, SIZE))
    away = (view.place - view.target) * (times * FAR)
    right = normalised(np.cross([0.0, 0.0, 1.0], away))
    pixel = 2 * float(np.linalg.norm(away)) * view.half / SIZE
    for number in range(FRAMES):
        middle = view.target + right * (pixel * STEP * number)
        moved: View = replace(view, place=middle + away, target=middle)
        painter.draw(target.drawn, moved)
        yield target.read()[::-1]


def _still(film: list[Floats]) -> float:
    """The mean PSNR of one frame against the next, where both show the object."""
    found = []
    for one, other in pairwise(film):
        both = (one[..., 3] == 1) & (other[..., 3] == 1)
        found.append(psnr(one[..., :3].astype(np.float64), other[..., :3].astype(np.float64), both))
    return float(np.mean(found))


if __name__ == "__main__":
    main()
