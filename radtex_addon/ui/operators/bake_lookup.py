# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the objects that an operator works on, and their bakes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, cast

import bpy

from ...scene.surfaces import may_have_faces
from ..settings.chosen_bakes import chosen_name
from ..settings.chosen_objects import chosen_meshes
from ..settings.object_settings import settings_for

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from ...core.errors import RadTexError


def originals(
    layer: bpy.types.ViewLayer, name: str, scene: bpy.types.Scene | None = None, bake: str = ""
) -> list[bpy.types.Object]:
    """The object called `name`; if empty, those that the panel has chosen.

    If `scene` is given, `name` may also be the name of a shared atlas in `bake`: then its objects. Previews
    are replaced by their originals, unless these were deleted. Raises InputError if no object is found, or
    several have the name.
    """
    from ...core.errors import InputError
    from ...core.messages import do
    from ...preview.swap import original_of
    from ...scene.objects import check_only_one

    if name:
        check_only_one(layer.objects, name)
        shared = () if scene is None else sharing(layer, name, scene, bake)
        chosen = [item for item in layer.objects if item.name in (shared or (name,))]
        if not chosen:
            raise InputError(
                f"no object '{name}' in view layer '{layer.name}'",
                do("name one that is there"),
                do("give the object that name again if you renamed it after its bake"),
            )
    else:
        chosen = chosen_meshes(cast(bpy.types.Scene, layer.id_data), layer)
    if not chosen:
        raise InputError("no mesh object is selected: select one that was baked")
    return list(dict.fromkeys(original_of(item) or item for item in chosen))


def sharing(layer: bpy.types.ViewLayer, name: str, scene: bpy.types.Scene, bake: str) -> tuple[str, ...]:
    """Names of the objects of the shared atlas `name`; empty if there is none, or an object has that name.

    But for what has no faces, such as an empty that holds the objects.
    """
    from ...core.errors import RadTexError
    from ...formats.sidecar_file import read_facts
    from ...job.variants import variants_in
    from ...report.shown import shown_bake

    if not name or any(item.name == name and may_have_faces(item) for item in layer.objects):
        return ()
    kind = settings_for(scene, name).kind
    try:
        place = bake_location(scene, bake, name)
        called = chosen_name(scene, place, name)
        variants = variants_in(place, name, kind, called) if place.is_dir() else ()
        facts = read_facts(variants[0] if variants else shown_bake(place, name, called))
        return facts.texts("objects") if "objects" in facts.values else ()
    except RadTexError:
        return ()


def bake_called(layer: bpy.types.ViewLayer, name: str, scene: bpy.types.Scene, bake: str) -> str:
    """Where an operator looks for bakes: the sidecar of the shared atlas `name` if there is one, else `bake`.

    The sidecar, because objects of a shared atlas may have their own bakes in the same folder. Raises
    RadTexError.
    """
    return str(sidecar_of(scene, name, bake)) if sharing(layer, name, scene, bake) else bake


def has_meshes(operator: type[bpy.types.Operator], context: bpy.types.Context | None) -> bool:
    """Poll: whether there is a mesh, in Object Mode; sets the operator's message if not.

    No selection is needed: scripts and the buttons of jobs name their object.
    """
    layer = context.view_layer if context is not None else None
    if layer is None or not any(map(may_have_faces, layer.objects)):
        operator.poll_message_set("Bake a mesh object first")
        return False
    return in_object_mode(operator, context)


def in_object_mode(operator: type[bpy.types.Operator], context: bpy.types.Context | None) -> bool:
    """Poll: whether Blender is in Object Mode; sets the operator's message if not."""
    if context is not None and context.mode != "OBJECT":
        operator.poll_message_set("Go back to Object Mode first")
        return False
    return True


def sidecar_of(scene: bpy.types.Scene, name: str, bake: str) -> Path:
    """The sidecar of a bake of `name`, of any kind: `bake` itself, or in that folder, or in the scene's.

    Of bakes of several names it is the one that *Finished Bake* has chosen.
    Raises InputError if there is none, FormatError for a file that is not a sidecar.
    """
    from ...report.shown import shown_bake

    place = bake_location(scene, bake, name)
    return shown_bake(place, name, chosen_name(scene, place, name)).path


def bake_location(scene: bpy.types.Scene, bake: str, name: str = "") -> Path:
    """The folder or file that `bake` names; if empty, the output folder of the object `name`, or the scene's.

    Where the default folder has no bake of the object, that is the folder of earlier versions, if it has one.
    Raises InputError if the output folder does not exist yet, or the path cannot be read.
    """
    from ...core.errors import InputError
    from ..settings.preferences import preferred
    from ..settings.request import former_places, output_folder

    chosen = bake or settings_for(scene, name).directory
    place = output_folder(chosen, preferred().output)
    try:
        for former in () if bake else former_places(chosen):
            place = _where_found(place, former, name)
        is_there = place.exists()
    except OSError as error:
        raise InputError(
            f"{place} cannot be read: {error.strerror or error}; choose another folder"
        ) from error
    if not bake and not is_there:
        raise InputError(f"nothing was baked into {place} yet: bake first")
    return place


def _where_found(place: Path, former: Path, name: str) -> Path:
    """The folder `former` if it has a bake of the object, or any if that is empty, and `place` has not."""
    from ...report.shown import has_bakes
    from ...store.ownership import open_blend

    names, blend = [name] if name else [], open_blend()
    return place if has_bakes(place, names, blend) or not has_bakes(former, names, blend) else former


def sidecars_of(
    scene: bpy.types.Scene, items: Iterable[bpy.types.Object], bake: str
) -> tuple[dict[bpy.types.Object, Path], list[RadTexError]]:
    """The sidecars of all objects that have a bake, and the errors for the others.

    Raises the first error if no object has a bake.
    """
    from ...core.errors import RadTexError

    found: dict[bpy.types.Object, Path] = {}
    errors: list[RadTexError] = []
    chosen = list(items)
    assets = asset_bakes(scene, [item.name for item in chosen], bake)
    for item in chosen:
        try:
            found[item] = assets.get(item.name) or sidecar_of(scene, item.name, bake)
        except RadTexError as error:
            errors.append(error)
    if errors and not found:
        raise errors[0]
    return found, errors


def asset_bakes(scene: bpy.types.Scene, names: Sequence[str], bake: str) -> dict[str, Path]:
    """The sidecars of the assets that chosen objects make by touching, by the objects' names.

    These go before bakes of the objects by themselves. Objects whose asset was not baked are missing; there
    are none if `bake` is a sidecar.
    """
    from ...core.errors import RadTexError
    from ...formats.sidecar import file_name
    from ...formats.sidecar_file import read_facts
    from ..settings.baked_groups import baked_groups

    if len(names) < 2 or Path(bake).suffix == ".json":
        return {}
    found: dict[str, Path] = {}
    for values, group, is_asset in baked_groups(scene, names):
        if not is_asset:
            continue
        try:
            place = bake_location(scene, bake, group[0])
            called = chosen_name(scene, place, values["atlas_name"]) or values["atlas_name"]
            sidecar = place / file_name(called, values["kind"], "json")
            if sidecar.is_file():
                inside = read_facts(sidecar).texts("objects")
                found |= {name: sidecar for name in group if name in inside}
        except RadTexError:  # which the look for a bake of each will raise
            continue
    return found


def bake_of_copy(scene: bpy.types.Scene, copy: bpy.types.Object) -> Path | None:
    """The sidecar of the bake that a copy shows, or if that is gone of its object's bake; None if neither."""
    from ...core.errors import RadTexError
    from ...preview.kept_copies import original_of_copy, shown_by

    shown = shown_by(copy)
    if shown is None:
        return None
    try:
        if shown.sidecar.is_file():
            return shown.sidecar
        original = original_of_copy(copy, scene)
        return sidecar_of(scene, shown.name if original is None else original.name, "")
    except (RadTexError, OSError):
        return None
