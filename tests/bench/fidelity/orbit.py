# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Does a baked object flicker? A camera goes once round it, and sees it with one ray a pixel, as games do.

    python -m tests.bench.fidelity.orbit                                  metal_20, the layered layout
    python -m tests.bench.fidelity.orbit --scenes metal_20,ceramic --methods layered,probe --texels 64

Each method's pictures g, of one ray a pixel, are held against its own supersampled ones s, of 4 x 4 rays.
Flicker is what changes between successive frames t of g without changing in s:

    flicker = mean |(g[t+1] - g[t]) - (s[t+1] - s[t])|

over all frames, the last followed by the first, over the three channels of display values (clipped, gamma
2.2), and over the pixels that the object covers wholly in both frames. So edges do not count, nor does what
a method shows wrongly but steadily. Besides: the mean change of s, and of g as a share of it (1 is right,
more shimmers), as tests/bench/minification.py has it; and PSNR of g against s.

Nothing hides the object, except from a method that renders the whole scene, and behind its alpha is black.
Leaves a sheet of pictures per scene, flicker times 8 below each.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import import_module
from itertools import pairwise
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw

from radtex_addon.report.gbuffer import Array, BakedSurface, CameraRays
from radtex_addon.report.metrics import Mask, Picture, display, psnr

from . import methods
from .composite import seen_light
from .method import Baked, Method
from .report import markdown
from .scenes import SCENES

_SUBSAMPLES = 4  # along a pixel's side of the supersampled pictures
_ELEVATION = np.radians(25)
_DISTANCE = 5.0
_FILL = 0.95  # of the picture, by the sphere around the object
_SHOWN = 6  # frames on a sheet
_GAIN = 8  # of the flicker on a sheet
_LABEL = 14  # pixels of a line of text


@dataclass(frozen=True, eq=False)
class Frame:
    """Display values (H, W, 3) of one ray a pixel, and supersampled, and the pixels wholly covered."""

    game: Picture
    supersampled: Picture
    inside: Mask


@dataclass(frozen=True)
class Flicker:
    """As the module says; `share` is the change of the pictures of one ray, over `change`."""

    flicker: float
    change: float
    share: float
    psnr: float


def main() -> None:
    """Bake, go round, print."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.fidelity.orbit",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--scenes", default="metal_20", help="of " + ", ".join(SCENES))
    parser.add_argument("--methods", default="layered", help="modules in methods/")
    parser.add_argument("--texels", type=int, default=128, help="along each side of the atlas (128)")
    parser.add_argument("--samples", type=int, default=16, help="as of bake.py --samples (16)")
    parser.add_argument("--frames", type=int, default=60, help="of the whole turn (60)")
    parser.add_argument("--pixels", type=int, default=128, help="along a picture's side (128)")
    default = Path(tempfile.gettempdir(), "radtex-orbit")
    parser.add_argument("--out", type=Path, default=default, help=f"folder for sheets ({default})")
    options = parser.parse_args()
    if options.frames < 2:
        parser.error("an orbit takes two frames at least")
    options.out.mkdir(parents=True, exist_ok=True)
    for name in options.scenes.split(","):
        rows = [["method", "flicker", "change, supersampled", "change, share", "PSNR"], ["---"] * 5]
        strips = []
        for method_name in options.methods.split(","):
            module = import_module(f"{methods.__name__}.{method_name}")
            method: Method = module.make(options.texels, options.samples)
            frames = film(method, name, options.frames, options.pixels)
            found = measure(frames)
            rows.append(
                [
                    method.name,
                    f"{found.flicker:.4f}",
                    f"{found.change:.4f}",
                    f"{found.share:.2f}",
                    f"{found.psnr:.1f}",
                ]
            )
            print(f"{name}, {method.name}: flicker {found.flicker:.4f}", flush=True)
            strips.append(strip(f"{method.name}: flicker {found.flicker:.4f}", frames))
            Image.fromarray(np.concatenate(strips)).save(options.out / f"{name}.png", optimize=True)
        print(f"\n{name}, {options.frames} frames\n\n{markdown(rows)}\n", flush=True)


def film(method: Method, scene: str, frames: int, pixels: int) -> list[Frame]:
    """The turn around a scene's subject, baked by a method."""
    stage = SCENES[scene]()
    with tempfile.TemporaryDirectory() as folder:
        baked = method.bake(stage, Path(folder))
        surface = BakedSurface(baked.mesh, baked.matrix_world, baked.uv_layer)
        found = []
        for azimuth in np.arange(frames) * 2 * np.pi / frames:
            place, turn, half = _seen_from(surface.place, float(azimuth))
            game, _ = _picture(baked, surface, CameraRays.of_camera(place, turn, half, pixels, 1))
            rays = CameraRays.of_camera(place, turn, half, pixels, _SUBSAMPLES)
            found.append(Frame(game, *_picture(baked, surface, rays)))
    return found


def _seen_from(points: Array, azimuth: float) -> tuple[Array, Array, float]:
    """Place, rotation and tangent of half the angle of view of a camera that holds all points (V, 3)."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    radius = float(np.linalg.norm(points - middle, axis=1).max())
    distance = max(_DISTANCE, 2 * radius)
    level = np.cos(_ELEVATION)
    back = np.array([np.sin(azimuth) * level, -np.cos(azimuth) * level, np.sin(_ELEVATION)])
    right = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    turn = np.stack([right, np.cross(back, right), back], axis=1)
    return middle + distance * back, turn, radius / np.sqrt(distance**2 - radius**2) / _FILL


def _picture(baked: Baked, surface: BakedSurface, rays: CameraRays) -> tuple[Picture, Mask]:
    buffer = surface.gbuffer(rays, np.full(len(rays.away), np.inf))
    light = seen_light(baked, surface, rays, np.full(len(rays.away), np.inf), buffer)
    picture = display(buffer.resolve(light))
    return picture * buffer.inside[..., None], buffer.inside


def measure(frames: list[Frame]) -> Flicker:
    """The figures of a turn; where the object covers no pixel wholly in two frames they are NaN."""
    extra, change, shown, count = 0.0, 0.0, 0.0, 0
    for before, after in _turn(frames):
        both = before.inside & after.inside
        game, steady = after.game - before.game, after.supersampled - before.supersampled
        extra += float(np.abs(game - steady)[both].sum())
        change += float(np.abs(steady)[both].sum())
        shown += float(np.abs(game)[both].sum())
        count += 3 * int(both.sum())
    if not count or not change:
        return Flicker(*[float("nan")] * 4)
    decibels = [psnr(frame.game**2.2, frame.supersampled**2.2, frame.inside) for frame in frames]
    return Flicker(extra / count, change / count, shown / change, float(np.mean(decibels)))


def _turn(frames: list[Frame]) -> Iterator[tuple[Frame, Frame]]:
    return pairwise([*frames, frames[0]])


def strip(label: str, frames: list[Frame]) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """Some of the frames side by side, supersampled and of one ray, and below them the flicker after each."""
    chosen = list(_turn(frames))[:: -(-len(frames) // _SHOWN)]
    columns = []
    for before, after in chosen:
        both = (before.inside & after.inside)[..., None]
        extra = np.abs((after.game - before.game) - (after.supersampled - before.supersampled)) * both
        tiles = [before.supersampled, before.game, np.clip(_GAIN * extra, 0, 1)]
        columns.append(np.concatenate(tiles))
    picture = (np.concatenate(columns, axis=1) * 255 + 0.5).astype(np.uint8)
    sheet = Image.new("RGB", (picture.shape[1], picture.shape[0] + _LABEL))
    sheet.paste(Image.fromarray(picture), (0, _LABEL))
    ImageDraw.Draw(sheet).text((3, 1), label, fill=(255, 255, 255))
    return np.asarray(sheet)


if __name__ == "__main__":
    main()
