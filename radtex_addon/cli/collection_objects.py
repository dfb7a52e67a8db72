# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The objects of the collections or the scene that a command line names, and lines on those left out."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import bpy

from ..core.errors import InputError
from ..core.messages import Message
from ..job.instances import join_instances, names_joined
from ..job.left_out import find_bakeable, left_out_lines
from ..preview.collection_meshes import objects_named
from .arguments import Request
from .reporting import Report
from .wording import told

_NO_SURFACE = frozenset(("LIGHT", "LIGHT_PROBE", "CAMERA", "ARMATURE", "LATTICE", "SPEAKER"))


def with_collections(scene: bpy.types.Scene, request: Request, report: Report) -> Request:
    """The request with the meshes of its collections behind the objects that it names, each once.

    A request for everything gets all meshes of the scene. What cannot be baked of these is left out, and
    `report` says why; objects that are named are not looked at. Instances become meshes of the scene. Raises
    InputError for a collection that is not there or has no mesh, and if nothing is left.
    """
    request, hidden = _with_instances(scene, request, report)
    bakes = request.bakes
    collections = (scene.collection.name,) if request.everything else request.collections
    if not collections:
        return request
    inside = [item for name in collections for item in objects_named(scene, name)]
    inside = [item for item in dict.fromkeys(inside) if item.name not in {*bakes.objects, *hidden}]
    surfaces = [item.name for item in inside if not _has_no_surface(item)]
    found = find_bakeable(
        scene, surfaces, bakes.spec, preview=bakes.saves_preview, now=not bakes.frames, evaluate=True
    )
    if found.left_out and not found.kept and not bakes.objects:
        raise InputError.of(found.left_out[0].why)
    for line in left_out_lines(found.left_out):
        report.event("warning", **told(line))
    _tell_others([item.name for item in inside if _has_no_surface(item)], report)
    bakes = replace(bakes, objects=(*bakes.objects, *found.kept))
    return replace(request, bakes=bakes, collections=(), everything=False)


def _with_instances(scene: bpy.types.Scene, request: Request, report: Report) -> tuple[Request, set[str]]:
    """Make meshes of the instances that these objects show, and report it.

    Returns the request, which names all of them, and the names of the objects that are hidden now. For
    several frames nothing is done, as instances may be others in each; nor for the panel, which has asked.
    """
    bakes = request.bakes
    if bakes.frames or request.parent_pipe:
        return request, set()
    known, layers = scene.objects, (scene.collection, *scene.collection.children_recursive)
    of = [each for each in layers if request.everything or each.name in request.collections]
    asked = [known[name] for name in bakes.objects if name in known]
    if len(asked) < len(bakes.objects):  # which may be one of those to be made
        asked = list(known)
    made, messages = join_instances(scene, [*asked, *(item for each in of for item in each.all_objects)])
    for one in made:
        report.event("note", message=one.told)
    for message in messages:
        report.event("warning", **told(message))
    bakes = replace(bakes, objects=tuple(names_joined(made, bakes.objects)))
    return replace(request, bakes=bakes), {one.hidden for one in made}


def _has_no_surface(item: bpy.types.Object) -> bool:
    """Whether nobody expects a bake of an object of this sort; an empty may show instances."""
    return item.type in _NO_SURFACE or (item.type == "EMPTY" and item.instance_type == "NONE")


def _tell_others(names: Iterable[str], report: Report) -> None:
    listed = ", ".join(f"'{name}'" for name in names)
    if listed:
        report.event("note", **told(Message(f"left out, as they have no surface: {listed}")))
