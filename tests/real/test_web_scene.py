# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A whole scene exported for the web: the page shows each of its objects by its own bake."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import pytest
from scipy.ndimage import binary_dilation

from radtex_addon.bake.progress import finished
from radtex_addon.core.sampler import Filter
from radtex_addon.export.exporting import export_steps
from radtex_addon.export.exporting_scene import export_scene_steps
from radtex_addon.job import bake_object
from radtex_addon.settings.spec import BakeSpec
from radtex_addon.textures.export_spec import ExportSpec, Target
from tests.blender import stage
from tests.real.exhibit import CAMERAS, Bake, Exhibit, Form, decibels
from tests.real.web import Site, save

LEAST = 38.0  # dB
SPEC = BakeSpec(texels=32, bucket=2, samples=1)


@pytest.mark.parametrize("form", Form)
def test_an_object_in_a_scene_looks_as_the_reference(
    form: Form, web: Site, exhibit: Exhibit, room: list[Path]
) -> None:
    bake: Bake = getattr(exhibit, form)
    sidecars = [room[-3], bake.sidecar, *room[-2:]]
    name = f"scene-{form}"
    finished(export_scene_steps(sidecars, ExportSpec(Target.WEB), "Room", web.folder / name))
    with web.opened(f"{name}/") as shown:
        shown.wait()
        assert "bakes" in shown.text("facts")
        if form is Form.PLAIN:
            shown.page.get_by_role("button", name="Quadrilinear").click()
        for camera in CAMERAS:
            shown.set_camera(camera)
            light = shown.pixels()[..., :3].astype(np.float64)
            found = decibels(light, bake.picture(camera), bake.eroded(camera))
            print(f"{form}, {camera.name}: {found:.1f} dB")
            assert found >= LEAST
            beside = light[~binary_dilation(bake.inside(camera), iterations=2)]
            assert (beside.max() > 0.1) == (camera.name == "left"), "behind the head are the trees"


def test_a_room_of_all_layouts_is_one_page(web: Site, room: list[Path]) -> None:
    """Bakes that share an atlas load it once; the inspector tells of the object that was clicked."""
    folder = web.folder / "room"
    finished(export_scene_steps(room, ExportSpec(Target.WEB), "Room (1)", folder))
    asked: list[str] = []
    with web.opened("room/", 1000, 700) as shown:
        shown.wait()
        shown.page.on("request", lambda request: asked.append(request.url))
        shown.page.reload()
        shown.wait()
        textures = [address for address in asked if address.endswith(".ktx2")]
        assert len(textures) == len(set(textures))
        assert len([address for address in asked if address.endswith(".glb")]) == 1, "as it was preloaded"
        parts = json.loads(next(folder.glob("*.export.json")).read_text())["scene"]
        files = {entry["file"] for part in parts for entry in part["textures"].values()}
        assert {Path(address).name for address in textures} == files
        seen = set()
        for x in range(60, 760, 25):
            found = shown.page.evaluate("x => radtex.inspect(x, 380)", x)
            if found:
                seen.add(found["side"])
        assert len(seen) > 1, "buckets, and the layered gem"
        shown.page.keyboard.press("Escape")
        save(shown, "room")
    with web.opened("room/?lamp=Key=key/Vase.export.json") as shown:
        message = shown.page.locator("#message")
        message.wait_for(state="visible", timeout=20_000)
        assert "Room (1) is a whole scene, to which lamps cannot be added" in message.inner_text()


def test_objects_of_one_atlas_are_shown_each_in_its_place(web: Site, room: list[Path]) -> None:
    finished(export_steps(room[1], ExportSpec(Target.WEB), web.folder / "furniture"))
    with web.opened("furniture/", 800, 600) as shown:
        shown.wait()
        row = [shown.page.evaluate("x => Boolean(radtex.inspect(x, 300))", x) for x in range(10, 790, 10)]
    runs = [met for met, before in zip(row, [False, *row], strict=False) if met and not before]
    assert len(runs) == 2, "the chair, a gap, the table"


def test_one_walks_through_a_room(web: Site, tmp_path: Path) -> None:
    """It begins inside; walls and a block stop one, a double-click stands on the floor, Walk leaves it."""
    stage.world()
    bpy.ops.mesh.primitive_cube_add(size=4, location=(0, 0, 1.5))
    context: Any = bpy.context
    room = context.object
    room.data.flip_normals()
    bpy.ops.mesh.primitive_cube_add(size=0.8, location=(0, 1.5, 0.4))
    names = []
    for item, name in ((room, "Walls"), (context.object, "Block")):
        item.name = name
        item.data.materials.append(stage.material(name, "ShaderNodeEmission", Strength=0.3))
        bake_object(context.scene, name, SPEC, tmp_path, preview=Filter.QUADRILINEAR)
        names.append(tmp_path / f"{name}.radiance.json")
    finished(export_scene_steps(names, ExportSpec(Target.WEB), "Cell", web.folder / "cell"))
    with web.opened("cell/", 1000, 700) as shown:
        shown.wait()
        page = shown.page

        def eye() -> list[float]:
            found: list[float] = page.evaluate("radtex.eye()")
            return found

        def hold(key: str, seconds: float) -> None:
            page.keyboard.down(key)
            page.wait_for_timeout(1000 * seconds)
            page.keyboard.up(key)
            shown.still()

        floor = -0.5
        begin = eye()
        assert max(abs(begin[0]), abs(begin[2])) < 2
        assert begin[1] == pytest.approx(floor + 1.6, abs=1e-3)
        assert page.get_by_role("button", name="Walk").get_attribute("aria-pressed") == "true"
        hold("w", 8)
        after = eye()
        assert after != begin
        assert max(abs(after[0]), abs(after[2])) < 2 - 0.1, "walls stop one"
        page.keyboard.press("r")
        shown.still()
        assert eye() == begin
        page.mouse.move(200, 350)
        page.mouse.down()
        page.mouse.move(200, 150, steps=2)
        page.mouse.up()
        page.mouse.dblclick(200, 560)
        shown.still()
        stood = eye()
        assert stood != begin
        assert stood[1] == pytest.approx(floor + 1.6, abs=1e-3)
        page.get_by_role("button", name="Walk").click()
        shown.still()
        assert np.linalg.norm(eye()) > 4, "outside, around the whole"


def test_one_does_not_begin_inside_what_is_solid(web: Site, tmp_path: Path) -> None:
    stage.world()
    bpy.ops.mesh.primitive_cube_add(size=4)
    context: Any = bpy.context
    context.object.name = "Solid"
    context.object.data.materials.append(stage.material("Solid", "ShaderNodeEmission", Strength=0.3))
    sidecar = tmp_path / "Solid.radiance.json"
    bake_object(context.scene, "Solid", SPEC, tmp_path, preview=Filter.QUADRILINEAR)
    finished(export_steps(sidecar, ExportSpec(Target.WEB), web.folder / "solid"))
    with web.opened("solid/", 1000, 700) as shown:
        shown.wait()
        assert shown.page.get_by_role("button", name="Walk").get_attribute("aria-pressed") == "false"
        assert np.linalg.norm(shown.page.evaluate("radtex.eye()")) > 4
