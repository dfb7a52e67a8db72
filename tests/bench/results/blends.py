# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The scenes as .blend files that one can open, with their images in them."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import bpy

from .scenes import DRAWN_WITH, REFERENCE_SAMPLES, SCENES, cameras_of

_TEXT = """{name}: a scene of RadTex's Results (docs/results.md), drawn by chance with seed {seed}.

Bake the object "{subject}". Pictures are compared through the cameras {cameras}.
References have {samples} samples a pixel, denoised, a box filter of one pixel, {pixels} x {pixels} pixels.

License: CC0 1.0, https://creativecommons.org/publicdomain/zero/1.0/
The script that built it is GPL-3.0-or-later; what it draws is nobody's. The HDRI is one that Blender ships,
CC0, by Greg Zaal (Poly Haven).
"""


def write_blends(folder: Path) -> list[Path]:
    """Save each scene; returns the paths."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for name, build in SCENES.items():
        stage = build()
        told = _TEXT.format(
            name=name,
            seed=DRAWN_WITH,
            subject=stage.subject.name,
            cameras=", ".join(camera.name for camera in cameras_of(stage)),
            samples=REFERENCE_SAMPLES,
            pixels=cast(bpy.types.Scene, bpy.context.scene).render.resolution_x,
        )
        bpy.data.texts.new("README").write(told)
        cast(Any, bpy.ops.file).pack_all()
        paths.append(folder / f"{name}.blend")
        cast(Any, bpy.ops.wm).save_as_mainfile(filepath=str(paths[-1]), copy=True, compress=True)
    return paths
