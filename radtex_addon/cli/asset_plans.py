# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Plan a request's bakes, with one atlas for objects that touch, or a few for a scene, where asked for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import bpy

from ..core.errors import RadTexError
from ..core.messages import Message, Setting, do
from ..job.assets import Asset, asset_requests, rendered_assets
from ..job.bake_plan import BakePlan, plan_bakes
from ..job.bake_request import BakeRequest
from ..job.scene_atlases import SceneAtlas, rendered_atlases, requests_of
from .arguments import AUTO


def plans_of(
    scene: bpy.types.Scene, request: BakeRequest, atlases: Sequence[SceneAtlas] = ()
) -> list[BakePlan]:
    """A plan for each atlas of objects that touch, if the request asks for these, and one for all others.

    Likewise for each of the `atlases` of a scene. Of several plans, resuming leaves those out that are done.
    Raises as `plan_bakes` and `asset_requests` do.
    """
    requests = requests_of(request, atlases) if request.as_scene else asset_requests(scene, request)
    plans = [plan_bakes(scene, each) for each in requests]
    if not request.resume or len(plans) == 1:
        return plans
    return [replace(plan, wanted=()) if plan.is_done else plan for plan in plans]


def atlases_of(scene: bpy.types.Scene, request: BakeRequest) -> tuple[SceneAtlas, ...]:
    """The atlases of a scene, if the request asks for these. Raises as `rendered_atlases` does."""
    return rendered_atlases(scene, request) if request.as_scene else ()


def asset_lines(scene: bpy.types.Scene, request: BakeRequest, plans: Sequence[BakePlan]) -> Iterator[Message]:
    """A line on each group of objects that are baked as one, or that touch and would gain from that."""
    if request.assets:
        for plan in plans:
            if plan.request.shared is not None and plan.wanted:
                asset = Asset(plan.request.shared, plan.request.objects)
                yield Message(f"{asset.told} touch: they are baked as one asset, '{asset.name}'")
    elif request.shared is None and not request.as_scene and any(plan.replaced for plan in plans):
        for asset in _found(scene, request):
            problem = f"{asset.told} touch, and each is baked by itself: it mirrors but a blur of the others"
            yield Message(problem, (do("bake them as one asset", Setting.TOGETHER, value=AUTO),))


def _found(scene: bpy.types.Scene, request: BakeRequest) -> tuple[Asset, ...]:
    try:
        return rendered_assets(scene, request)
    except RadTexError:  # which the bake will raise
        return ()
