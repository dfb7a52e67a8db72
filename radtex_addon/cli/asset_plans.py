# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Plan a request's bakes, with one atlas for objects that touch where asked for, and tell of such objects."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import bpy

from ..core.errors import RadTexError
from ..core.messages import Message, Setting, do
from ..job.assets import Asset, asset_requests, rendered_assets
from ..job.bake_plan import BakePlan, plan_bakes
from ..job.bake_request import BakeRequest
from .arguments import AUTO


def plans_of(scene: bpy.types.Scene, request: BakeRequest) -> list[BakePlan]:
    """A plan for each atlas of objects that touch, if the request asks for these, and one for all others.

    Of several plans, resuming leaves those out that are done. Raises as `plan_bakes` and `asset_requests` do.
    """
    plans = [plan_bakes(scene, each) for each in asset_requests(scene, request)]
    if not request.resume or len(plans) == 1:
        return plans
    return [replace(plan, wanted=()) if plan.is_done else plan for plan in plans]


def asset_lines(scene: bpy.types.Scene, request: BakeRequest, plans: Sequence[BakePlan]) -> Iterator[Message]:
    """A line on each group of objects that are baked as one, or that touch and would gain from that."""
    if request.assets:
        for plan in plans:
            if plan.request.shared is not None and plan.wanted:
                asset = Asset(plan.request.shared, plan.request.objects)
                yield Message(f"{asset.told} touch: they are baked as one asset, '{asset.name}'")
    elif request.shared is None and any(plan.replaced for plan in plans):
        for asset in _found(scene, request):
            problem = f"{asset.told} touch, and each is baked by itself: it mirrors but a blur of the others"
            yield Message(problem, (do("bake them as one asset", Setting.TOGETHER, value=AUTO),))


def _found(scene: bpy.types.Scene, request: BakeRequest) -> tuple[Asset, ...]:
    try:
        return rendered_assets(scene, request)
    except RadTexError:  # which the bake will raise
        return ()
