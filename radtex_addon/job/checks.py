# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What can be known to fail before a bake starts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import bpy

from ..bake.memory_limits import check_memory
from ..bake.spec import BakeSpec, CaptureMethod, View
from ..core.errors import InputError
from ..formats.disk.atomic import check_writable
from ..formats.disk.path_checks import check_saveable
from ..forms import form_for
from ..preview.linked import check_replaceable
from ..scene.checks.active_camera import camera_dependent
from ..scene.checks.camera_nodes import camera_materials
from ..scene.checks.enclosing_volumes import volumes_around
from ..scene.checks.missing_files import lacking
from ..scene.checks.outside import check_outside_files
from ..scene.checks.refusals import refuse_unseen
from ..scene.eye import find_eye
from ..scene.lights.lamps import find_lamps
from ..scene.lights.light import is_dark
from ..scene.mesh.cage import find_cage
from ..scene.mesh.named_regions import check_where
from ..scene.mesh.source import find_source
from ..scene.objects import find_object
from ..scene.proxy_content import find_content
from ..scene.scratch import find_view_layer
from ..scene.uv.xatlas_process import check_xatlas
from ..textures.spec import Target
from .files import OutputFiles
from .finished import check_exports
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
    exports: Iterable[Target] = (),
) -> list[str]:
    """Everything that can be known to fail before a bake with its `exports` starts; returns warnings.

    Raises InputError for an object or a view layer that is not there, an object that cannot be baked, a
    shared atlas that bears a stranger's name, for files that would be lost or cannot be written, for targets
    that cannot be served, and where it is to `resume` a bake that differs, or that is there whole.
    """
    check_memory(spec)
    targets = tuple(exports)
    items = [find_object(scene, each) for each in spec.objects or (name,)]
    if spec.objects and name not in spec.objects and name in scene.objects:
        raise InputError(
            f"the atlas cannot be called '{name}', as an object that has no part in it: "
            "give it another name (--together)"
        )
    layer = find_view_layer(scene, view_layer)
    if spec.uv_layer is None:
        check_xatlas()
    files = OutputFiles.of(name, spec, folder, preview)
    check_outside_files()
    check_writable(folder)
    if files.preview is not None:
        check_saveable(files.preview)
    if files.preview is not None and _is_open(files.preview):
        raise InputError(
            f"{files.preview} is the open file, which a bake never changes: choose another folder"
        )
    check_files(name, spec, files, overwrite, resume, targets)
    check_exports(spec, files, targets, overwrite, resume)
    if preview:
        form_for(spec).check_previewable(spec)
        check_replaceable(items)
    _check_names(scene, layer, items, spec)
    return _warnings(scene, layer, items, spec)


def _warnings(
    scene: bpy.types.Scene,
    layer: bpy.types.ViewLayer,
    items: Sequence[bpy.types.Object],
    spec: BakeSpec,
) -> list[str]:
    """What bakes, but hardly as it is meant."""
    warnings = [*lacking(), *camera_dependent(layer)]
    if spec.kind.traits.looks_at_surface:
        warnings.extend(line for item in items for line in camera_materials(item))
    if spec.kind.traits.needs_light and not spec.lights and is_dark(scene, layer):
        warnings.append(f"scene '{scene.name}' has no light: no lamp, a black world, nothing that emits")
    if spec.capture is CaptureMethod.PORTAL:
        warnings.extend(
            f"object '{item.name}' stands in the volume of '{fog}', which the bake will not show: "
            "make it the world's volume, or hide it from render"
            for item in items
            for fog in volumes_around(layer, item)
        )
    return warnings


def _check_names(
    scene: bpy.types.Scene,
    layer: bpy.types.ViewLayer,
    items: Sequence[bpy.types.Object],
    spec: BakeSpec,
) -> None:
    """Find all that a bake names, or takes for granted, beside its objects."""
    item = items[0]
    if spec.frame is None:  # else it may be another then
        check_seen(scene, layer, items, spec)
    if spec.view is View.CAMERA:
        find_eye(scene)
    if spec.kind.traits.content:
        find_content(layer, item, spec.content)
    if spec.source is not None:
        find_source(scene, item, spec.source, layer.name)
    if spec.cage is not None:
        find_cage(scene, item, spec.source, spec.cage)
    if spec.where is not None:
        check_where(items, spec.where)
    if spec.lights:
        find_lamps(layer, spec.lights)


def check_seen(
    scene: bpy.types.Scene,
    layer: bpy.types.ViewLayer,
    items: Sequence[bpy.types.Object],
    spec: BakeSpec,
) -> None:
    """Make sure that cameras see whose light is baked: the objects, or the source of it.

    Light that arrives, occlusion and hulls do not depend on camera visibility. Raises InputError.
    """
    if not spec.kind.traits.needs_camera_rays:
        return
    for item in items if spec.source is None else [find_source(scene, items[0], spec.source, layer.name)]:
        refuse_unseen(layer, item)


def _is_open(path: Path) -> bool:
    return bool(bpy.data.filepath) and path.resolve() == Path(bpy.data.filepath).resolve()
