# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What to expect of the next bake, computed for the panel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import reduce
from operator import add
from typing import TYPE_CHECKING

import bpy

from ..settings.chosen_objects import chosen_by, chosen_names, selected_meshes
from .not_baked import not_baked
from .panel_state import Forecast, Made, Next, ShownAsset, ShownCopy

if TYPE_CHECKING:
    from ...job.bake_request import BakeRequest
    from ...job.left_out import LeftOut
    from ...settings.cost import Cost
    from ...settings.estimate import Basis
    from ...settings.spec import BakeSpec
    from ..settings.baked_groups import BakedGroup
    from .layouts import Chosen

_PATIENCE = 0.05  # seconds that examining the objects may take


def compute_forecast(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Forecast:
    """Check and estimate a bake of the chosen objects, each with its settings. Changes nothing."""
    from ...core.messages import Message, Setting, do
    from ...preview.swap import is_on
    from ..jobs.jobs import is_being_baked, look_at_files
    from ..settings.baked_groups import baked_groups
    from ..settings.object_settings import own_settings, settings_for
    from .request_checks import scale_notes, sort_out

    look_at_files()
    if copies := _copies(scene, view_layer):
        return Forecast((), copies=copies)
    chosen = chosen_names(scene, view_layer)
    sorted_out = sort_out(scene, chosen, patience=_PATIENCE)
    names, left_out = sorted_out.kept, sorted_out.left_out
    if left_out and not names:
        return _of_none(scene, view_layer, chosen, left_out)
    busy = tuple(name for name in names if is_being_baked(name, settings_for(scene, name)))
    free = tuple(name for name in names if name not in busy)
    groups = baked_groups(scene, free or names)
    patience = _PATIENCE / len(groups)
    found = _joined([_of_group(scene, group, patience) for group in groups])
    if any(not settings_for(scene, name).atlas_layout for name in names):
        told = Message("the storage that an earlier version of RadTex kept in this file is no longer there")
        told = replace(told, remedies=(do("Automatic is used; choose one", Setting.LAYOUT),))
        found = replace(found, warnings=(*found.warnings, told))
    if busy and not free:
        found = replace(found, errors=(), next=Next.WAIT)
    shown = tuple(name for name in free if is_on(scene.objects[name]))
    others = not_baked(_selected(scene, view_layer))
    notes = scale_notes(view_layer, [scene.objects[name] for name in names], _PATIENCE)
    found = replace(found, warnings=(*found.warnings, *notes), flat=_flat(scene, left_out))
    own = tuple(name for name in names if own_settings(scene.objects.get(name)) is not None)
    found = _with_named(scene, view_layer, groups, found)
    return replace(found, objects=names, busy=busy, shown=shown, not_baked=others, left_out=left_out, own=own)


def _with_named(
    scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, groups: Sequence[BakedGroup], found: Forecast
) -> Forecast:
    """The forecast with the named bakes of the active object, or of the asset that it is part of."""
    from ...core.errors import InputError
    from ...preview.swap import original_of
    from ..operators.bake_lookup import bake_location
    from ..settings.chosen_bakes import bakes_by_name

    active = view_layer.objects.active
    item = None if active is None else original_of(active)
    if item is None:
        return found
    assets = [group.values["atlas_name"] for group in groups if group.is_asset and item.name in group.names]
    for name in (*assets, item.name):
        try:
            named = bakes_by_name(bake_location(scene, "", name), name)
        except InputError:
            continue
        if named:
            return replace(found, named=named, named_of=(item.name, name))
    return found


def _of_none(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    chosen: tuple[str, ...],
    left_out: Sequence[LeftOut],
) -> Forecast:
    """The forecast where none of the chosen objects can be baked: the reasons are errors."""
    from ...job.left_out import reasons
    from ..settings.baked_groups import BakedGroup
    from ..settings.object_settings import settings_for
    from ..settings.request import values_of

    found = _of_group(scene, BakedGroup(values_of(settings_for(scene, chosen[0])), ()), _PATIENCE)
    errors = dict.fromkeys((*found.errors, *reasons(left_out)))
    others = not_baked(_selected(scene, view_layer))
    return replace(
        found,
        objects=chosen,
        errors=tuple(errors),
        next=Next.NOTHING,
        not_baked=others,
        flat=_flat(scene, left_out),
    )


def _flat(scene: bpy.types.Scene, left_out: Sequence[LeftOut]) -> tuple[str, ...]:
    """Those of the objects that are left out whose own scale is 0 along an axis."""
    from ..operators.remedy_operator import has_zero_scale

    items: list[bpy.types.Object | None] = [scene.objects.get(one.name) for one in left_out]
    return tuple(item.name for item in items if item is not None and has_zero_scale(item))


def _copies(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> tuple[ShownCopy, ...]:
    """The selected copies that show a bake; none if anything else is to be baked."""
    from ...preview.kept_copies import digest_of, original_of_copy, shown_by
    from ..operators.bake_lookup import bake_of_copy

    items = selected_meshes(view_layer) if chosen_by(scene).source == "selection" else []
    found = [(item, shown) for item in items if (shown := shown_by(item)) is not None]
    if len(found) < len(items):
        return ()
    copies = []
    for item, shown in found:
        original, sidecar = original_of_copy(item, scene), bake_of_copy(scene, item)
        bake = "" if sidecar is None else "same" if digest_of(sidecar) == shown.digest else "newer"
        name = shown.name if original is None else original.name
        copies.append(ShownCopy(item.name, name, original is not None, bake))
    return tuple(copies)


def _selected(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Sequence[bpy.types.Object]:
    """The selected objects, or else the active one; none where the panel bakes something else."""
    if chosen_by(scene).source != "selection":
        return ()
    active = view_layer.objects.active
    return list(view_layer.objects.selected) or ([active] if active is not None else [])


def _of_group(scene: bpy.types.Scene, group: BakedGroup, patience: float) -> Forecast:
    """The forecast of objects that are baked by one request."""
    from ...core.errors import InputError
    from ..jobs import estimates
    from ..settings.request import has_folder, request_of, spec_of
    from .atlas_sizes import told_sizes
    from .layouts import chosen_layouts, told_layouts

    names = group.names
    values = group.values | {"overwrite": False, "resume": False}  # the panel's buttons decide that
    try:
        asked = spec_of(values)
        chosen = chosen_layouts(scene, names, values, asked, patience)
    except InputError as error:
        return Forecast(names, (error.message,))
    spec, cost = _dearest(chosen)
    found = Forecast(names, (), (), spec, cost, layout=told_layouts(values, chosen), atlases=group.atlases)
    if group.is_asset:
        asset = ShownAsset(values["atlas_name"], len(names), chosen[0][1].spec.texels)
        found = replace(found, assets=(asset,))
    if names and asked.split is None and (len(chosen) >= len(names) or chosen[0][1].spec.objects):
        known = estimates.seconds_known(scene, [(name, choice.spec) for name, choice in chosen if name])
        if known is not None:
            found = replace(found, seconds=known.seconds, range=known.range, basis=known.basis)
    try:
        request = request_of(values, names)
    except InputError as error:
        return replace(found, errors=(error.message,), needs_folder=not has_folder(values))
    if not names:
        return replace(found, folder=request.folder)
    found = _with_files(scene, request, found, patience)
    if found.next is Next.RESUME:  # in the layout that was begun
        there = str(_where_begun(scene, request).folder)
        begun = chosen_layouts(scene, names, values | {"resume": True, "directory": there}, asked, patience)
        found = replace(found, layout=told_layouts(values, begun))
    if found.seconds is not None and found.range is not None and not found.errors:
        count = _count_of_variants(scene, request)
        found = replace(found, seconds=count * found.seconds, range=found.range * count)
    unseen = 0 if spec.objects else max(len(names) - len(chosen), 0)
    return replace(
        found,
        folder=request.folder,
        sizes=told_sizes(scene, chosen, request.folder, unseen),
        made=_made(chosen, request, max(found.bakes // max(group.atlases, 1), 1)),
        unseen=unseen,
    )


def _made(chosen: Chosen, request: BakeRequest, times: int) -> tuple[Made, ...]:
    """The atlases that a request makes; each is baked so many `times`, such as once for each frame."""
    from ...forms import cost_of
    from ...settings.bake_names import filled

    return tuple(
        Made(
            filled(choice.spec.bake_name, name),
            choice.spec.texels,
            cost_of(choice.spec).disk * times,
            request.folder,
        )
        for name, choice in chosen
        if name
    )


def _count_of_variants(scene: bpy.types.Scene, request: BakeRequest) -> int:
    """How many frames or lamps each object is baked for; 1 where that cannot be found out."""
    from ...core.errors import InputError

    try:
        return len(request.specs(scene))
    except InputError:
        return 1


def _with_files(scene: bpy.types.Scene, request: BakeRequest, found: Forecast, patience: float) -> Forecast:
    """The forecast with what the bakes that are there leave to do, and what stands in the way of that."""
    from ...job.preflight import Preflight
    from ...preview.swap import is_on
    from .request_checks import files_there, foreseen

    files = files_there(scene, request)
    begun = _where_begun(scene, request)
    if begun.folder != request.folder:  # where an earlier version left it
        files = files_there(scene, begun)
    # Where a bake is shown in the object's place, the button shows the object first: then it can be checked.
    checked = tuple(name for name in request.objects if not is_on(scene.objects[name]))
    request = replace(request, objects=checked)
    seen = foreseen(scene, request, patience) if checked else Preflight()
    found = replace(
        found,
        warnings=seen.warnings,
        bakes=files.bakes,
        finished=files.finished,
        unfinished=files.unfinished,
        done=files.done,
        former=files.former,
        next=Next.BAKE,
    )
    adds = request.spec.incremental  # to bakes that are there
    there = files.finished + files.unfinished > 0 and not adds
    if not seen.errors and not there:
        return found
    anew = replace(request, overwrite=True, overwrite_any=True)  # the button asks first
    left = foreseen(scene, anew, patience).errors if checked else ()
    if left:
        return replace(found, errors=left, next=Next.NOTHING)
    resumable = checked and (files.unfinished or 0 < files.finished < files.bakes)
    if resumable and not foreseen(scene, replace(request, resume=True), patience).errors:
        return replace(found, next=Next.RESUME)
    return replace(found, next=Next.REPLACE)


def _where_begun(scene: bpy.types.Scene, request: BakeRequest) -> BakeRequest:
    """The request into the folder in which resuming would go on."""
    from ...core.errors import InputError

    try:
        return replace(request, folder=replace(request, resume=True).where_begun(scene, guess=True).folder)
    except InputError:
        return request


def _dearest(chosen: Chosen) -> tuple[BakeSpec, Cost]:
    """The specification that takes most of a GPU's memory, and its cost."""
    from ...forms import cost_of

    costs = {choice.spec: cost_of(choice.spec) for _, choice in chosen}
    spec = max(costs, key=lambda one: costs[one].gpu)
    return spec, costs[spec]


def _joined(groups: Sequence[Forecast]) -> Forecast:
    """The forecast of all objects from those of each group."""
    if len(groups) == 1:
        return groups[0]
    dearest = max(groups, key=lambda group: group.cost.gpu if group.cost is not None else -1)
    seconds = [group.seconds for group in groups if group.seconds is not None]
    ranges = [group.range for group in groups if group.range is not None]
    return replace(
        dearest,
        objects=tuple(name for group in groups for name in group.objects),
        errors=tuple(dict.fromkeys(error for group in groups for error in group.errors)),
        warnings=tuple(dict.fromkeys(warning for group in groups for warning in group.warnings)),
        seconds=sum(seconds) if len(seconds) == len(groups) else None,
        range=reduce(add, ranges) if len(ranges) == len(groups) else None,
        basis=_vaguest([group.basis for group in groups]),
        next=_joint(groups),
        needs_folder=any(group.needs_folder for group in groups),
        bakes=sum(group.bakes for group in groups),
        finished=sum(group.finished for group in groups),
        unfinished=sum(group.unfinished for group in groups),
        done=sum(group.done for group in groups),
        former=sum(group.former for group in groups),
        layout="",
        sizes=tuple(line for group in groups for line in group.sizes),
        assets=tuple(asset for group in groups for asset in group.assets),
        atlases=sum(group.atlases for group in groups),
        made=tuple(one for group in groups for one in group.made),
        unseen=sum(group.unseen for group in groups),
    )


def _vaguest(bases: Sequence[Basis | None]) -> Basis | None:
    """What the least certain of several estimates rests on; None if one of them has none."""
    from ...settings.estimate import Basis

    known = [basis for basis in bases if basis is not None]
    return max(known, key=list(Basis).index) if len(known) == len(bases) else None


def _joint(groups: Sequence[Forecast]) -> Next:
    """What the button does for several groups of objects; resuming leaves out groups that are done."""
    if any(group.next is Next.NOTHING for group in groups):
        return Next.NOTHING
    left = {group.next for group in groups if group.done < group.bakes}
    there = any(group.finished or group.unfinished for group in groups)
    if not left or Next.REPLACE in left:
        return Next.REPLACE
    return Next.RESUME if there else Next.BAKE
