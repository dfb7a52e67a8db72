# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the finished bakes that are to be exported, and queue their exports."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from ..jobs import jobs
from ..settings.chosen_bakes import chosen_name
from ..settings.object_settings import settings_for
from .bake_lookup import asset_bakes, bake_location, originals, sharing

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    import bpy

    from ...export.exporting import ExportSource
    from ...textures.export_spec import ExportSpec


class Place(NamedTuple):
    """An object's name, the sidecar of its bake, and the folder to make."""

    name: str
    sidecar: Path
    out: Path


def export_sources(
    scene: bpy.types.Scene, layer: bpy.types.ViewLayer, name: str, bake: str
) -> list[ExportSource]:
    """The bakes of the object or shared atlas called `name`, or of all selected meshes, each once.

    `bake` is their folder, or a sidecar; the scene's output folder if it is empty. Where it is given, the
    object need not be there: it may have been renamed since. Parts and variants are bakes of their own.
    Raises RadTexError if one of the objects has no bake.
    """
    from ...export.exporting import ExportSource

    is_gone = bool(name and bake) and all(item.name != name for item in layer.objects)
    if is_gone or sharing(layer, name, scene, bake):
        names = [name]
    else:
        names = [item.name for item in originals(layer, name, scene, bake)]
    assets = asset_bakes(scene, names, bake)
    found = [ExportSource.of(sidecar) for sidecar in dict.fromkeys(assets.values())]
    alone = (one for one in names if one not in assets)
    found += [source for one in alone for source in _sources_of(scene, one, bake)]
    return list({source.sidecar.path: source for source in found}.values())  # objects may share an atlas


def place_for(source: ExportSource, out: Path) -> Place:
    """Where an export of the bake goes."""
    from ...report.finished_bake import object_of

    return Place(object_of(source.sidecar), source.sidecar.path, out)


def submit(
    places: Iterable[Place],
    spec: ExportSpec,
    *,
    overwrite: bool,
    completion: jobs.Completion | None = None,
) -> None:
    """Queue the exports, one job for all in a folder. Raises BakeError if no work folder can be created."""
    from ...worker.handover import work_folder
    from ...worker.orders import order_export
    from ..settings.preferences import preferred

    by_folder: dict[Path, list[Place]] = {}
    for place in places:
        by_folder.setdefault(place.out.absolute().parent, []).append(place)
    folder = work_folder(preferred().cache)
    orders = [order_export(folder, group, spec, overwrite=overwrite) for group in by_folder.values()]
    jobs.add(orders, completion)


def submit_scene(
    sidecars: Sequence[Path], spec: ExportSpec, name: str, out: Path, *, overwrite: bool
) -> None:
    """Queue an export as one scene as a background job. Raises BakeError as `submit` does."""
    from ...worker.handover import work_folder
    from ...worker.orders import order_scene_export
    from ..settings.preferences import preferred

    folder = work_folder(preferred().cache)
    jobs.add([order_scene_export(folder, sidecars, name, spec, out, overwrite=overwrite)], None)


def _sources_of(scene: bpy.types.Scene, name: str, bake: str) -> list[ExportSource]:
    """The bakes of `name`, one for each part or variant; of several kinds the panel's.

    Of bakes of several names those of the one that *Finished Bake* has chosen.
    """
    from ...export.exporting import ExportSource
    from ...formats.sidecar import file_name
    from ...job.variants import variants_in
    from ...report.finished_bake import find_bakes, is_bake_of
    from ...settings.spec import Kind

    place, kind = bake_location(scene, bake, name), settings_for(scene, name).kind
    called = chosen_name(scene, place, name)
    chosen_kind = place / file_name(called or name, kind, "json")
    variants = variants_in(place, name, kind, called) if place.is_dir() else ()
    if chosen_kind.is_file() and is_bake_of(chosen_kind, name):
        place = chosen_kind
    found = variants or find_bakes(place, name if place.is_dir() else None, "exported", tuple(Kind), called)
    return [ExportSource.of(file) for file in found]
