# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a picture is from its reference, inside a mask.

Pictures are (H, W, 3) float64 in linear light, masks (H, W). PSNR and FLIP judge what a display shows; HDR
FLIP judges all exposures.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

try:
    import flip_evaluator
except ImportError:  # it has no wheels for Intel Macs
    flip_evaluator = None

Picture = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

CAP = 99.0  # decibels: the PSNR of equal pictures
_GLINT = 1.0  # radiance that displays show as white: what is brighter in the reference is a glint


@dataclass(frozen=True)
class Figures:
    """The figures of one picture: PSNR in decibels inside the eroded and the whole mask, FLIP, and energy.

    All but one are inside the eroded mask. `flip` is None if FLIP is not available. `energy` is the mean
    radiance divided by the reference's, NaN if that is black. `glints` is what is kept of the light of the
    reference's glints, pixels that a display shows as white: no more of any than its own; None without any.
    """

    psnr: float
    psnr_uneroded: float
    flip: float | None
    energy: float
    glints: float | None


def compare(picture: Picture, reference: Picture, inside: Mask, eroded: Mask) -> Figures:
    """Compare a picture with its reference; the picture's pixels outside `inside` are ignored."""
    shown = np.where(inside[..., None], picture, reference)
    light = float(reference[eroded].mean())
    return Figures(
        psnr=psnr(shown, reference, eroded),
        psnr_uneroded=psnr(shown, reference, inside),
        flip=float(flip_map(shown, reference)[eroded].mean()) if has_flip() else None,
        energy=float(shown[eroded].mean()) / light if light else float("nan"),
        glints=glints_kept(shown, reference, eroded),
    )


def glints_kept(picture: Picture, reference: Picture, mask: Mask) -> float | None:
    """`Figures.glints` inside a mask."""
    bright = mask & (reference.max(axis=2) > _GLINT)
    if not bright.any():
        return None
    return float(np.minimum(picture, reference)[bright].sum() / reference[bright].sum())


def display(picture: Picture) -> Picture:
    """Display values of a picture: clipped to 0..1, gamma 2.2."""
    shown: Picture = np.clip(picture, 0, 1) ** (1 / 2.2)
    return shown


def psnr(picture: Picture, reference: Picture, mask: Mask) -> float:
    """PSNR of display values inside the mask, in decibels, at most CAP."""
    squared = float(np.mean((display(picture) - display(reference))[mask] ** 2))
    return min(CAP, -10 * float(np.log10(max(squared, 1e-12))))


def has_flip() -> bool:
    """Whether FLIP can be measured here."""
    return flip_evaluator is not None


def flip_map(picture: Picture, reference: Picture, hdr: bool = False) -> npt.NDArray[np.float32]:
    """FLIP's error at each pixel, (H, W) in 0..1, at 67 pixels per degree; only if `has_flip`."""
    prepared = [
        np.ascontiguousarray(np.maximum(image, 0) if hdr else display(image), dtype=np.float32)
        for image in (reference, picture)
    ]
    error = flip_evaluator.evaluate(*prepared, "HDR" if hdr else "LDR", applyMagma=False)[0]
    shaped: npt.NDArray[np.float32] = np.asarray(error, dtype=np.float32).reshape(picture.shape[:2])
    return shaped
