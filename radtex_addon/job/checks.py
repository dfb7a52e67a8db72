# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Preflight checks of one bake: find what would make it fail before it starts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

import bpy

from ..core.errors import InputError
from ..core.messages import Message, Setting, do
from ..cycles.device import check_device
from ..formats.disk.atomic import check_writable
from ..formats.disk.path_checks import check_saveable
from ..forms import form_for
from ..preview.linked import check_replaceable
from ..scene.camera_place import find_camera_place
from ..scene.checks.camera_checks import camera_dependent, camera_materials
from ..scene.checks.file_checks import check_outside_files, file_warnings
from ..scene.checks.finite_light import refuse_unfinite_light
from ..scene.checks.refusals import refuse_see_through
from ..scene.checks.see_through import volumes_around, why_no_surface
from ..scene.lights.lamps import find_lamps, refuse_negative, rendered_lamps
from ..scene.lights.light import is_dark
from ..scene.mesh.cage import find_cage
from ..scene.mesh.named_regions import check_where
from ..scene.mesh.painted_weights import check_painted
from ..scene.mesh.source_hits import find_source
from ..scene.objects import find_object
from ..scene.proxy_content import find_content
from ..scene.scratch import find_view_layer
from ..scene.surfaces import may_have_faces
from ..scene.uv.unwrap import check_unwrapper
from ..settings.cost import check_disk, check_memory
from ..settings.spec import BakeSpec, CaptureMethod, View
from ..store.bake_folder import BakeFolder
from ..store.ownership import Overwrite
from ..textures.export_spec import Target


def check_request(
    scene: bpy.types.Scene,
    name: str,
    spec: BakeSpec,
    folder: Path,
    preview: bool,
    overwrite: bool | Overwrite,
    view_layer: str | None = None,
    resume: bool = False,
    exports: Iterable[Target] = (),
) -> list[Message]:
    """Check everything that could make a bake or its `exports` fail, before it starts; returns warnings.

    Raises InputError for an object or a view layer that does not exist, an object that cannot be baked, a
    shared atlas with the name of an object with faces that has no part in it, files that would be lost or
    cannot be written, exports that are not possible, and if the bake to `resume` differs or is finished.
    """
    check_memory(spec)
    check_device(spec.device)
    items = [find_object(scene, each) for each in spec.objects or (name,)]
    named = scene.objects.get(name)
    if spec.objects and name not in spec.objects and named is not None and may_have_faces(named):
        raise InputError(
            f"the atlas cannot be called '{name}', as an object that has no part in it",
            do("give it another name", Setting.TOGETHER),
        )
    layer = find_view_layer(scene, view_layer)
    if spec.uv_layer is None:
        check_unwrapper(spec.unwrap)
    place = BakeFolder(name, spec, folder, preview)
    check_outside_files()
    check_writable(folder)
    check_disk(spec, folder)
    if (shown := place.files.preview) is not None:
        check_saveable(shown)
        if _is_open(shown):
            raise InputError(f"{shown} is the open file, which a bake never changes: choose another folder")
    place.check_may_write(Overwrite.of(overwrite), resume, tuple(exports))
    if preview:
        form_for(spec).check_previewable(spec)
        check_replaceable(items)
    _check_names(scene, layer, items, spec)
    if spec.kind.traits.needs_light:
        refuse_unfinite_light(scene, layer)
    return _warnings(scene, layer, items, spec)


def _warnings(
    scene: bpy.types.Scene,
    layer: bpy.types.ViewLayer,
    items: Sequence[bpy.types.Object],
    spec: BakeSpec,
) -> list[Message]:
    """Warnings about a bake that is possible, but hardly as intended."""
    warnings = [*file_warnings(), *map(Message, camera_dependent(layer))]
    if spec.kind.traits.looks_at_surface:
        warnings.extend(Message(line) for item in items for line in camera_materials(item))
    if spec.kind.traits.needs_light and not spec.lights and is_dark(scene, layer):
        warnings.append(
            Message(f"scene '{scene.name}' has no light: no lamp, a black world, nothing that emits")
        )
    if spec.capture is CaptureMethod.PORTAL:
        warnings.extend(
            Message(
                f"object '{item.name}' stands in the volume of '{fog}', which the bake will not show",
                (do("make it the world's volume"), do("hide it from render")),
            )
            for item in items
            for fog in volumes_around(layer, item)
        )
    if spec.form.by_paths:
        warnings.extend(
            Message(
                f"object '{item.name}' will look like a solid surface in {spec.form.title}: {reason}",
                (do("choose layout buckets", Setting.LAYOUT, value="buckets"),),
            )
            for item in items
            if may_have_faces(item) and (reason := why_no_surface(scene, item))
        )
    return warnings


def _check_names(
    scene: bpy.types.Scene,
    layer: bpy.types.ViewLayer,
    items: Sequence[bpy.types.Object],
    spec: BakeSpec,
) -> None:
    """Check all else that a specification refers to: camera, content, source, cage, faces, lamps."""
    item = items[0]
    if spec.frame is None:  # visibility may be animated: at another frame the bake checks it
        check_seen(scene, layer, items, spec)
    if spec.view is View.CAMERA:
        find_camera_place(scene)
    if spec.kind.traits.content:
        find_content(layer, item, spec.content)
    if spec.source is not None:
        find_source(scene, item, spec.source, layer.name)
    if spec.cage is not None:
        find_cage(scene, item, spec.source, spec.cage)
    if spec.where is not None:
        check_where(items, spec.where)
    if spec.texel_weights is not None:
        check_painted(items, scene.objects, spec.texel_weights)
    if spec.lights:
        find_lamps(layer, spec.lights)
    if spec.form.by_paths:
        refuse_negative(rendered_lamps(layer))


def check_seen(
    scene: bpy.types.Scene,
    layer: bpy.types.ViewLayer,
    items: Sequence[bpy.types.Object],
    spec: BakeSpec,
) -> None:
    """Make sure that the objects, or the source if there is one, are visible to cameras.

    Kinds for arriving light, occlusion and hulls do not need it. Raises InputError.
    """
    if not spec.kind.traits.needs_camera_rays:
        return
    for item in items if spec.source is None else [find_source(scene, items[0], spec.source, layer.name)]:
        refuse_see_through(layer, item)


def _is_open(path: Path) -> bool:
    return bool(bpy.data.filepath) and path.resolve() == Path(bpy.data.filepath).resolve()
