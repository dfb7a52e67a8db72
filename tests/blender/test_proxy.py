# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Proxies: a hull bakes what is inside it, itself unseen, with an alpha that says where nothing is."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import bpy
import numpy as np
import PIL.Image
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.errors import InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.formats.sidecar import Content, read_sidecar
from radtex_addon.job import bake_object
from radtex_addon.preview.save import render_picture
from radtex_addon.preview.swap import copy_of, originals_rendered, switch_off, switch_on
from radtex_addon.settings.spec import BakeSpec, CaptureMethod, Kind, Layout
from tests.blender import stage
from tests.blender.fingerprint import differences, fingerprint

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None

SPEC = BakeSpec(kind=Kind.PROXY, texels=32, bucket=8, samples=4, half=False)


def thing(shape: str, name: str, colour: tuple[float, ...], **options: Any) -> Any:
    """A primitive that glows in one colour."""
    getattr(bpy.ops.mesh, f"primitive_{shape}_add")(**options)
    made = context.object
    made.name = name
    made.data.materials.append(stage.material(name, "ShaderNodeEmission", Color=(*colour, 1)))
    return made


def hull_around_a_ball() -> None:
    """A cube of side 2 around a green ball of radius 0.5, over a red floor, in a blue world."""
    stage.world((0, 0, 1))
    thing("cube", "Hull", (1, 1, 1), size=2)
    thing("uv_sphere", "Ball", (0, 1, 0), radius=0.5, segments=64, ring_count=32)
    thing("plane", "Floor", (1, 0, 0), size=20, location=(0, 0, -3))


def bake(out: Path, spec: BakeSpec = SPEC) -> Floats:
    return read_buckets(bake_object(context.scene, "Hull", spec, out).files.sidecar)[0]


def test_a_hull_shows_what_is_inside_and_nothing_else(out: Path) -> None:
    hull_around_a_ball()
    before = fingerprint()
    pixels = bake(out)
    assert differences(before, fingerprint()) == {}
    assert pixels[..., [0, 2]].max() == 0, "the floor or the world is seen"
    np.testing.assert_allclose(pixels[..., 1], pixels[..., 3], atol=1e-5)  # the ball's light is 1
    share = pixels[..., 3].mean()
    print(f"\nof all directions {share:.3f} meet the ball")
    assert 0.05 < share < 0.4
    assert {0.0, 1.0} <= set(np.unique(pixels[..., 3]))


@pytest.mark.one_blender
def test_the_content_is_a_collection_or_all_that_is_behind_the_hull(out: Path) -> None:
    hull_around_a_ball()
    chosen = bpy.data.collections.new("Shown")
    chosen.objects.link(bpy.data.objects["Floor"])
    pixels = bake(out, BakeSpec(**{**vars(SPEC), "content": "Shown"}))
    assert pixels[..., [1, 2]].max() == 0
    assert pixels[..., 0].max() == 1
    pixels = bake(out / "window", BakeSpec(**{**vars(SPEC), "content": "*"}))
    assert (pixels[..., :3].max(axis=(0, 1)) == 1).all()
    np.testing.assert_allclose(pixels[..., 3], 1)
    np.testing.assert_allclose(pixels[..., :3].sum(axis=-1), 1, atol=1e-5)


@pytest.mark.one_blender
def test_what_is_not_content_still_lights_it(out: Path) -> None:
    hull_around_a_ball()
    bpy.data.objects["Ball"].data.materials[0] = stage.material(
        "white", "ShaderNodeBsdfDiffuse", Color=(1, 1, 1, 1)
    )
    pixels = bake(out)
    light = pixels[..., :3].sum(axis=(0, 1)) / pixels[..., 3].sum()
    assert light[0] > 0.1, "no light of the floor"
    assert light[2] > 0.3, "no light of the world"


@pytest.mark.one_blender
def test_hidden_things_and_things_that_hide_others_stay_what_they_are(out: Path) -> None:
    hull_around_a_ball()
    bpy.data.objects["Ball"].hide_render = True
    thing("uv_sphere", "Small", (0, 1, 0), radius=0.2)
    away = bpy.data.collections.new("Away")
    context.scene.collection.children.link(away)
    away.objects.link(bpy.data.objects["Small"])
    context.scene.collection.objects.unlink(bpy.data.objects["Small"])
    context.view_layer.layer_collection.children["Away"].holdout = True
    pixels = bake(out)
    assert pixels.max() == 0, "a holdout is a hole"


def test_instances_are_content(out: Path) -> None:
    stage.world((0, 0, 0))
    thing("cube", "Hull", (1, 1, 1), size=2)
    thing("uv_sphere", "Ball", (0, 1, 0), radius=0.5)
    group = bpy.data.collections.new("Group")
    group.objects.link(bpy.data.objects["Ball"])
    context.scene.collection.objects.unlink(bpy.data.objects["Ball"])
    empty = bpy.data.objects.new("Instance", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", group
    context.scene.collection.objects.link(empty)
    assert bake(out)[..., 1].max() == 1


@pytest.mark.one_blender
def test_a_hull_with_nothing_inside_is_refused_and_the_old_atlas_stays(out: Path) -> None:
    hull_around_a_ball()
    bake(out)
    before = {path: path.read_bytes() for path in out.iterdir()}
    bpy.data.objects["Ball"].location.x = 5
    with pytest.raises(InputError, match="object 'Hull' has nothing inside it: put it around"):
        bake_object(context.scene, "Hull", SPEC, out, overwrite=True)
    assert {path: path.read_bytes() for path in out.iterdir()} == before


@pytest.mark.parametrize("content", [None, "*"])
def test_the_preview_shows_the_hull_in_the_contents_place(out: Path, content: str | None) -> None:
    hull_around_a_ball()
    bpy.ops.object.camera_add(location=(0, -6, 0), rotation=(np.pi / 2, 0, 0))
    context.scene.camera = context.object
    context.scene.view_settings.view_transform = "Standard"
    before = fingerprint()
    spec = BakeSpec(**{**vars(SPEC), "content": content})
    made = bake_object(context.scene, "Hull", spec, out, preview=Filter.QUADRILINEAR)
    assert differences(before, fingerprint()) == {}
    picture = out.parent / "picture.png"
    assert made.files.preview is not None
    render_picture(made.files.preview, picture, pixels=64, samples=8)
    assert ("Ball" in bpy.data.objects) == (content is not None)
    assert not bpy.data.objects["Floor"].hide_render
    with PIL.Image.open(picture) as opened:
        seen = np.asarray(opened.convert("RGB"))
    assert seen[32, 32, 1] > 200, "no ball in the middle"
    assert seen[32, 32, [0, 2]].max() < 60
    assert seen[20, 16, 1] < 50, "green beside the ball"
    assert seen[20, 16, 2] > 200, "the world is not seen beside the ball"


def previewed(out: Path, name: str = "Hull", content: str | None = None) -> Path:
    """The sidecar of a small bake with a preview."""
    spec = BakeSpec(kind=Kind.PROXY, texels=16, bucket=2, samples=1, content=content)
    return bake_object(context.scene, name, spec, out, preview=Filter.NEAREST).files.sidecar


def hidden(name: str) -> tuple[bool, bool]:
    item = bpy.data.objects[name]
    return item.hide_render, item.hide_viewport


@pytest.mark.parametrize(("content", "objects"), [(None, ("Ball",)), ("Shown", ("Ball", "Floor")), ("*", ())])
def test_switched_on_in_the_scene_the_content_is_hidden(
    out: Path, content: str | None, objects: tuple[str, ...]
) -> None:
    hull_around_a_ball()
    chosen = bpy.data.collections.new("Shown")
    for name in ("Ball", "Floor"):
        chosen.objects.link(bpy.data.objects[name])
    sidecar = previewed(out, content=content)
    bpy.data.objects["Ball"].hide_viewport = True
    assert read_sidecar(sidecar).content == Content(content or "", objects)
    before = fingerprint()
    hull = bpy.data.objects["Hull"]
    switch_on(hull, sidecar)
    switch_on(hull, sidecar)  # anew
    for name in ("Ball", "Floor"):
        assert hidden(name) == ((True, True) if name in objects else (False, name == "Ball"))
    with originals_rendered([hull]):
        assert not bpy.data.objects["Ball"].hide_render
        assert hull.hide_render is bool(objects)
    switch_off(hull)
    assert {path for path in differences(before, fingerprint()) if "users" not in path} == set()


def test_content_comes_back_when_no_hull_shows_it_any_more(out: Path) -> None:
    """Two hulls around one ball: one preview is switched off, the other deleted by hand."""
    hull_around_a_ball()
    other = bpy.data.objects["Hull"].copy()
    other.name = "Husk"
    context.scene.collection.objects.link(other)
    bpy.data.objects["Husk"].hide_render = True  # or each would be the other's content
    sidecars = {"Hull": previewed(out)}
    bpy.data.objects["Husk"].hide_render, bpy.data.objects["Hull"].hide_render = False, True
    sidecars["Husk"] = previewed(out, "Husk")
    bpy.data.objects["Hull"].hide_render = False
    before = fingerprint()
    hulls = [bpy.data.objects[name] for name in sidecars]
    for hull in hulls:
        switch_on(hull, sidecars[hull.name])
    switch_off(hulls[0])
    assert hidden("Ball") == (True, True)
    copy = copy_of(hulls[1])
    assert copy is not None
    bpy.data.objects.remove(copy)
    switch_off(hulls[1])
    assert {path for path in differences(before, fingerprint()) if "users" not in path} == set()


@pytest.mark.parametrize("lost", ["Hull", "Ball"])
def test_what_is_deleted_meanwhile_keeps_nothing_hidden(out: Path, lost: str) -> None:
    hull_around_a_ball()
    thing("cube", "Box", (1, 1, 0), size=0.2)
    sidecar = previewed(out)
    copy = switch_on(bpy.data.objects["Hull"], sidecar).copy
    assert hidden("Ball") == hidden("Box") == (True, True)
    bpy.data.objects.remove(bpy.data.objects[lost])
    switch_off(copy)
    left = {"Hull", "Ball", "Box", "Floor"} - {lost}
    assert {item.name for item in bpy.data.objects} == left
    assert {hidden(name) for name in left} == {(False, False)}


def test_undo_and_a_saved_file_know_what_was_hidden(out: Path) -> None:
    hull_around_a_ball()
    sidecar = previewed(out)
    bpy.ops.ed.undo_push(message="before")
    switch_on(bpy.data.objects["Hull"], sidecar)
    bpy.ops.ed.undo_push(message="on")
    bpy.ops.ed.undo()
    assert hidden("Ball") == hidden("Hull") == (False, False)
    bpy.ops.ed.redo()
    assert hidden("Ball") == (True, True)
    bpy.ops.wm.save_as_mainfile(filepath=str(out / "user.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(out / "user.blend"))
    switch_off(bpy.data.objects["Hull"])
    assert hidden("Ball") == hidden("Hull") == (False, False)


@pytest.mark.one_blender
@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("Nowhere", "there is no collection 'Nowhere'"),
        ("Empty", "has nothing that renders"),
        ("*", "is alone in the scene"),
    ],
)
def test_content_that_is_none_is_named(out: Path, content: str, words: str) -> None:
    if content == "*":
        thing("cube", "Hull", (1, 1, 1), size=2)
    else:
        hull_around_a_ball()
    bpy.data.collections.new("Empty")
    with pytest.raises(InputError, match=words):
        bake(out, BakeSpec(**{**vars(SPEC), "content": content}))


@pytest.mark.one_blender
def test_what_does_not_fit_a_proxy_is_refused() -> None:
    with pytest.raises(InputError, match="radiance shows the object itself: bake a proxy"):
        BakeSpec(content="*")
    with pytest.raises(InputError, match="cannot bake proxy"):
        BakeSpec(kind=Kind.PROXY, capture=CaptureMethod.PANORAMIC)
    with pytest.raises(InputError, match="knows kind radiance only, not proxy"):
        BakeSpec(kind=Kind.PROXY, layout=Layout.LAYERED)
