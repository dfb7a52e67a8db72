# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What can be known to fail before a bake starts."""

from __future__ import annotations

from pathlib import Path

import bpy

from ..bake.rays import FINER
from ..bake.spec import OCCLUSION, BakeSpec, CaptureMethod, Kind, Layout
from ..core.atlas import AtlasLayout
from ..core.errors import InputError
from ..core.shared import LEAST_LEVEL, Axis
from ..formats.atomic import check_writable
from ..formats.shared_sidecar import SharedSidecar
from ..preview.node_group import check_previewable
from ..preview.shared_group import check_shared_previewable
from ..scene.copy import UV_LAYER
from ..scene.enclosed import find_content
from ..scene.fog import volumes_around
from ..scene.light import is_dark
from ..scene.objects import find_object
from ..scene.scratch import find_view_layer
from ..scene.source import find_source
from ..scene.xatlas_process import check_xatlas
from .files import OutputFiles, facts_of
from .unfinished import check_files


def check_request(
    scene: bpy.types.Scene,
    name: str,
    spec: BakeSpec,
    folder: Path,
    preview: bool,
    overwrite: bool,
    view_layer: str | None = None,
    resume: bool = False,
) -> list[str]:
    """Everything that can be known to fail before a bake starts; returns warnings.

    Raises InputError for an object or a view layer that is not there, an object that cannot be baked, for
    files that would be lost or cannot be written, and where it is to `resume` a bake that differs.
    """
    item = find_object(scene, name)
    layer = find_view_layer(scene, view_layer)
    if spec.uv_layer is None:
        check_xatlas()
    files = OutputFiles.of(name, spec, folder, preview)
    check_writable(folder)
    if files.preview is not None and _is_open(files.preview):
        raise InputError(
            f"{files.preview} is the open file, which a bake never changes: choose another folder"
        )
    check_files(name, spec, files, overwrite, resume)
    if preview:
        _check_previewable(name, spec)
    if spec.kind is Kind.PROXY:
        find_content(layer, item, spec.content)
    if spec.source is not None:
        find_source(scene, item, spec.source, view_layer)
    warnings = []
    if spec.kind not in (*OCCLUSION, Kind.TRANSFER) and is_dark(scene, layer):
        warnings.append(f"scene '{scene.name}' has no light: no lamp, a black world, nothing that emits")
    if spec.capture is CaptureMethod.PORTAL:
        warnings.extend(
            f"object '{name}' stands in the volume of '{fog}', which the bake will not show: "
            "make it the world's volume, or hide it from render"
            for fog in volumes_around(layer, item)
        )
    return warnings


def _is_open(path: Path) -> bool:
    return bool(bpy.data.filepath) and path.resolve() == Path(bpy.data.filepath).resolve()


def _check_previewable(name: str, spec: BakeSpec) -> None:
    """Refuse what no GPU takes, were the atlas square."""
    side = spec.texels
    if spec.layout is Layout.BUCKETS:
        check_previewable(AtlasLayout(side, side, 1 if spec.kind is Kind.AO else spec.bucket))
        return
    largest = SharedSidecar(
        bake=facts_of(name, spec, side, side, spec.uv_layer or UV_LAYER),
        colour=(FINER * side, FINER * side),
        surroundings=LEAST_LEVEL,
        levels=1,
        sharpest=1.0,
        falloff=((1.0, 1.0, 1.0),),
        lobes=() if spec.condensed else tuple(Axis),  # few tiles, not a bucket a texel
    )
    check_shared_previewable(largest)
