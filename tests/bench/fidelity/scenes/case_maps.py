# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Textures of a painted steel case, drawn with numpy: six faces side by side, rows from the bottom."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Map = npt.NDArray[np.float64]

CELLS = 3, 2  # faces across and up
_SIDE = 256  # pixels of a face
_LETTERS = {  # five columns by seven rows, from the top
    "R": "11110 10001 10001 11110 10100 10010 10001",
    "T": "11111 00100 00100 00100 00100 00100 00100",
    "0": "01110 10001 10011 10101 11001 10001 01110",
    "7": "11111 00001 00010 00100 01000 01000 01000",
}


@dataclass(frozen=True, eq=False)
class Maps:
    """Pixels (H, W, 3): colour as display values, the others plain; `normal` is tangent-space, OpenGL's."""

    colour: Map
    roughness: Map
    metallic: Map
    normal: Map


def case_maps() -> Maps:
    """Draw the textures; the same at every call."""
    rng = np.random.default_rng(7)
    faces = [_face(number, rng) for number in range(CELLS[0] * CELLS[1])]
    stacked = (_grid([getattr(face, name) for face in faces]) for name in Maps.__dataclass_fields__)
    return Maps(*stacked)


def _grid(cells: list[Map]) -> Map:
    across = CELLS[0]
    rows = [np.concatenate(cells[k : k + across], axis=1) for k in range(0, len(cells), across)]
    return np.concatenate(rows, axis=0)


def _face(number: int, rng: np.random.Generator) -> Maps:
    """One face's."""
    steps = (np.arange(_SIDE) + 0.5) / _SIDE
    u, v = np.meshgrid(steps, steps)
    border = np.minimum(np.minimum(u, 1 - u), np.minimum(v, 1 - v))
    mottled, fine = _noise(rng, 24), _noise(rng, 5)
    paint = np.array([0.33, 0.4, 0.24]) * (1 + 0.06 * mottled[..., None])
    decal, ink = _decals(number, u, v)
    colour = np.where(decal[..., None], ink, paint)
    scratched = _scratches(rng)
    worn = (border + 0.02 * fine + 0.02 * mottled < 0.045) | (scratched > 0.6)
    steel = np.array([0.74, 0.73, 0.72]) * (1 + 0.05 * fine[..., None])
    colour = np.where(worn[..., None], steel, colour)
    roughness = np.where(worn, 0.22, np.where(decal, 0.3, 0.42)) + 0.07 * mottled
    return Maps(
        colour=np.clip(colour, 0, 1),
        roughness=_grey(np.clip(roughness, 0.05, 1)),
        metallic=_grey(worn.astype(np.float64)),
        normal=_normals(_embossed(u, v) - 0.004 * scratched + 0.0006 * fine),
    )


def _decals(number: int, u: Map, v: Map) -> tuple[npt.NDArray[np.bool_], Map]:
    """Where a face's decals are, and their colour."""
    yellow, black, white, red = (0.95, 0.75, 0.1), (0.06, 0.06, 0.06), (0.9, 0.9, 0.86), (0.75, 0.1, 0.07)
    ink = np.empty((*u.shape, 3))
    band = (v > 0.12) & (v < 0.24) & (number < 4)
    ink[:] = np.where((((u + v) * 9) % 1 < 0.5)[..., None], yellow, black)
    disc = np.hypot(u - 0.5, v - 0.55)
    emblem = (disc < 0.24) & (number in {1, 3, 4})
    ink = np.where(emblem[..., None], np.where(((disc < 0.11) | (disc > 0.19))[..., None], red, white), ink)
    letters = _text("RT07", u, v) & (number in {0, 2})
    ink = np.where(letters[..., None], white, ink)
    return band | emblem | letters, ink


def _text(text: str, u: Map, v: Map) -> npt.NDArray[np.bool_]:
    """A line of letters across the face."""
    rows = [" ".join(_LETTERS[letter].split()[row] + "0" for letter in text) for row in range(7)]
    bitmap = np.array([[dot == "1" for dot in row.replace(" ", "")] for row in rows[::-1]])
    x = np.floor((u - 0.14) / 0.74 * bitmap.shape[1]).astype(int)
    y = np.floor((v - 0.42) / 0.34 * 7).astype(int)
    inside = (x >= 0) & (x < bitmap.shape[1]) & (y >= 0) & (y < 7)
    drawn: npt.NDArray[np.bool_] = inside & bitmap[np.clip(y, 0, 6), np.clip(x, 0, bitmap.shape[1] - 1)]
    return drawn


def _embossed(u: Map, v: Map) -> Map:
    """The height of a sunk frame line and of rivets along it, in sides of a face."""
    frame = np.abs(np.maximum(np.abs(u - 0.5), np.abs(v - 0.5)) - 0.41)
    height = -0.012 * np.clip(1 - frame / 0.012, 0, 1)
    for x in (0.06, 0.35, 0.65, 0.94):
        for y in (0.06, 0.5, 0.94):
            if x in {0.06, 0.94} or y != 0.5:
                height += 0.016 * np.sqrt(np.clip(1 - ((u - x) ** 2 + (v - y) ** 2) / 0.022**2, 0, 1))
    return height


def _scratches(rng: np.random.Generator) -> Map:
    """Thin straight scratches, how deep: from 0 to 1."""
    steps = (np.arange(_SIDE) + 0.5) / _SIDE
    u, v = np.meshgrid(steps, steps)
    deepest = np.zeros_like(u)
    for _ in range(14):
        x, y = rng.uniform(0, 1, 2)
        angle, length, depth = rng.normal(0.5, 0.5), rng.uniform(0.05, 0.35), rng.uniform(0.2, 1)
        along = (u - x) * np.cos(angle) + (v - y) * np.sin(angle)
        across = (v - y) * np.cos(angle) - (u - x) * np.sin(angle)
        inside = np.clip(1 - np.abs(across) * _SIDE / 1.3, 0, 1) * (np.abs(along) < length / 2)
        deepest = np.maximum(deepest, depth * inside)
    return deepest


def _noise(rng: np.random.Generator, radius: float) -> Map:
    """Smooth noise that repeats, of deviation 1; features of about `radius` pixels."""
    rate = np.hypot(*np.meshgrid(np.fft.fftfreq(_SIDE), np.fft.fftfreq(_SIDE)))
    spectrum = np.fft.fft2(rng.normal(size=(_SIDE, _SIDE))) * np.exp(-((rate * radius * np.pi) ** 2))
    noise: Map = np.fft.ifft2(spectrum).real
    return noise / noise.std()


def _normals(height: Map) -> Map:
    """A normal map, (H, W, 3) in [0, 1], of a height in sides of the face."""
    down, right = np.gradient(height, 1 / _SIDE)
    normal = np.stack([-right, -down, np.ones_like(height)], axis=2)
    packed: Map = normal / np.linalg.norm(normal, axis=2, keepdims=True) / 2 + 0.5
    return packed


def _grey(values: Map) -> Map:
    return np.repeat(values[..., None], 3, axis=2)
