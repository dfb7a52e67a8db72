# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects that cameras see through: refused by name where their own light is baked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest

from radtex_addon.bake.spec import BakeSpec, Kind, Layout
from radtex_addon.core.errors import InputError
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.job import bake_object, check_request
from tests.blender import stage

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None

TINY = BakeSpec(texels=16, bucket=2, samples=1, half=False)


def card() -> Any:
    """A plane that glows, in a collection "Inner" of a collection "Home"."""
    bpy.ops.mesh.primitive_plane_add(size=2)
    made = context.object
    made.name = "Card"
    made.data.materials.append(stage.material("Glow", "ShaderNodeEmission", Color=(1, 1, 1, 1)))
    home, inner = bpy.data.collections.new("Home"), bpy.data.collections.new("Inner")
    context.scene.collection.children.link(home)
    home.children.link(inner)
    inner.objects.link(made)
    context.scene.collection.objects.unlink(made)
    stage.world()
    return made


def home() -> Any:
    return context.view_layer.layer_collection.children["Home"]


def no_camera(item: Any) -> None:
    item.visible_camera = False


def catcher(item: Any) -> None:
    item.is_shadow_catcher = True


def holdout(item: Any) -> None:
    item.is_holdout = True


def held_out(_: Any) -> None:
    home().children["Inner"].holdout = True


def indirect(_: Any) -> None:
    home().children["Inner"].indirect_only = True


UNSEEN = [
    (no_camera, r"cameras do not see it; enable Ray Visibility > Camera \(Object Properties > Visibility\)"),
    (catcher, "it is a shadow catcher; disable that"),
    (holdout, "it is a holdout; disable that"),
    (held_out, "in view layer 'ViewLayer' Holdout of its collection 'Inner' is on; disable that"),
    (indirect, "in view layer 'ViewLayer' Indirect Only of its collection 'Inner' is on; disable that"),
]


@pytest.mark.parametrize(
    "spec",
    [TINY, replace(TINY, layout=Layout.LAYERED, bucket=14), replace(TINY, kind=Kind.TRANSFER, bucket=3)],
    ids=["plain", "layered", "transfer"],
)
@pytest.mark.parametrize(("hide", "words"), UNSEEN)
def test_what_cameras_see_through_is_refused(
    hide: Callable[[Any], None], words: str, spec: BakeSpec, out: Path
) -> None:
    item = card()
    hide(item)
    context.view_layer.update()
    with pytest.raises(InputError, match=f"^a bake of object 'Card' would be see-through: {words}"):
        bake_object(context.scene, "Card", spec, out)
    assert not out.exists()


@pytest.mark.one_blender
@pytest.mark.parametrize("kind", [Kind.INCIDENT, Kind.REFLECTION, Kind.AO, Kind.SHADOW])
@pytest.mark.parametrize(("hide", "_words"), UNSEEN)
def test_what_asks_no_camera_is_baked_all_the_same(
    hide: Callable[[Any], None], _words: str, kind: Kind, out: Path
) -> None:
    hide(card())
    context.view_layer.update()
    check_request(
        context.scene, "Card", replace(TINY, kind=kind, half=True), out, preview=False, overwrite=False
    )


def test_a_hull_need_not_be_seen_and_neither_need_who_wears_another_s_light(out: Path) -> None:
    item = card()
    bpy.ops.mesh.primitive_cube_add(size=4)
    context.object.name, context.object.visible_camera = "Hull", False
    hull = replace(TINY, kind=Kind.PROXY)
    made = bake_object(context.scene, "Hull", hull, out).files.sidecar
    assert read_buckets(made)[0][..., 0].max() == pytest.approx(1)
    worn = replace(TINY, texels=24, source="Card", extrusion=5.0)
    made = bake_object(context.scene, "Hull", worn, out).files.sidecar
    np.testing.assert_allclose(read_buckets(made)[0][..., :3].max(), 1)
    item.is_shadow_catcher = True
    with pytest.raises(InputError, match="a bake of object 'Card' would be see-through: it is a shadow catc"):
        bake_object(context.scene, "Hull", worn, out, overwrite=True)


def test_a_frame_is_asked_for_what_is_seen_then(out: Path) -> None:
    item = card()
    for frame, seen in ((1, True), (2, False)):
        item.visible_camera = seen
        item.keyframe_insert("visible_camera", frame=frame)
    context.scene.frame_set(2)
    made = bake_object(context.scene, "Card", replace(TINY, frame=1), out).files.sidecar
    np.testing.assert_allclose(read_buckets(made)[0], 1)
    context.scene.frame_set(1)
    with pytest.raises(InputError, match="a bake of object 'Card' would be see-through: cameras do not see"):
        bake_object(context.scene, "Card", replace(TINY, frame=2), out)
