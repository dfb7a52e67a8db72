# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The objects of the collections that a command line names."""

from __future__ import annotations

from dataclasses import replace

import bpy

from ..preview.collection_meshes import meshes_named
from .arguments import Request


def with_collections(scene: bpy.types.Scene, request: Request) -> Request:
    """The request with the meshes of its collections behind the objects that it names, each once.

    Raises InputError for a collection that is not there or has no mesh.
    """
    found = (item.name for name in request.collections for item in meshes_named(scene, name))
    objects = tuple(dict.fromkeys((*request.bakes.objects, *found)))
    return replace(request, bakes=replace(request.bakes, objects=objects), collections=())
