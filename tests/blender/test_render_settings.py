# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""No render setting of a scene reaches a bake but those that are kept by name, however odd it is."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import pytest

from radtex_addon.bake.layers import Layer
from radtex_addon.bake.progress import finished
from radtex_addon.core.sampler import Filter
from radtex_addon.job import bake_object
from radtex_addon.preview.save import render_picture
from radtex_addon.report.report_bake import ReportSpec, report_steps
from radtex_addon.scene.render_settings import (
    KEPT_OF_CYCLES,
    KEPT_OF_LAYER,
    KEPT_OF_RENDER,
    reset_render_settings,
    settings_of,
)
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec, Kind, Layout
from tests.blender import farming, stage

pytestmark = pytest.mark.usefixtures("temporary")
context: Any = bpy.context  # to the stubs, every pointer may be None

PLAIN = BakeSpec(uv_layer="UVMap", texels=6, bucket=4, samples=2)
SPECS = {
    "radiance": PLAIN,
    "layers": BakeSpec(uv_layer="UVMap", texels=6, bucket=4, samples=2, layers=(Layer.DIFFUSE, Layer.NORMAL)),
    "layered": BakeSpec(uv_layer="UVMap", texels=6, samples=1, layout=Layout.LAYERED),
    "ao": BakeSpec(uv_layer="UVMap", texels=6, bucket=4, samples=2, kind=Kind.AO, ao_distance=1.0),
}
GROUPS: dict[str, frozenset[str]] = {
    "render": KEPT_OF_RENDER,
    "render.image_settings": frozenset(),
    "cycles": KEPT_OF_CYCLES,
    "view_settings": frozenset(),
    "display_settings": frozenset(),
    "view_layers[0]": KEPT_OF_LAYER,
    "view_layers[0].cycles": frozenset(),
}
OTHERS = (  # that other settings make, or switch off
    "white_balance_temperature",
    "white_balance_tint",
    "white_balance_whitepoint",
    "threads",
)
UNUSED = ("debug_", "preview_")  # the machine's, and the viewport's


def small_scene() -> None:
    """A ball on a floor in a world, with a lamp and a camera."""
    stage.world((0.3, 0.5, 0.9))
    stage.lamps()
    bpy.ops.mesh.primitive_uv_sphere_add(segments=12, ring_count=6, radius=0.5)
    context.object.name = "Ball"
    context.object.data.materials.append(stage.material("b", "ShaderNodeBsdfPrincipled", Roughness=0.3))
    bpy.ops.mesh.primitive_plane_add(size=3, location=(0, 0, -0.6))
    bpy.ops.object.camera_add(location=(0, 0, 5))
    context.scene.camera = context.object


def leave_out_floor() -> None:
    """A layered bake would take half a minute to look at it from everywhere."""
    bpy.data.objects.remove(context.scene.objects["Plane"])


def every_setting() -> Iterator[tuple[Any, str]]:
    """All settings that no bake keeps: their owner and their name."""
    for path, kept in GROUPS.items():
        owner = context.scene.path_resolve(path)
        for name in settings_of(owner):
            if name not in kept and name not in OTHERS and not name.startswith(UNUSED):
                yield owner, name


def make_odd(owner: Any, name: str) -> bool:
    """Give a setting some other value; False where it takes none."""
    prop, before = owner.bl_rna.properties[name], getattr(owner, name)
    if prop.type == "ENUM":
        for choice in (item.identifier for item in prop.enum_items):
            try:
                setattr(owner, name, choice)
            except TypeError:  # not on this machine, or not with the other settings
                continue
            if getattr(owner, name) != before:
                return True
        return False
    if prop.type == "STRING":
        setattr(owner, name, "odd")
    elif prop.type == "BOOLEAN":
        setattr(owner, name, not before)
    elif prop.is_array:
        setattr(owner, name, [0.25] * len(before))
    else:
        odd = before / 2 + 3 if prop.type == "FLOAT" else before // 2 + 3
        setattr(owner, name, max(prop.hard_min, min(odd, prop.hard_max)))
    return bool(_value(owner, name) != before)


def _value(owner: Any, name: str) -> Any:
    found = getattr(owner, name)
    return list(found) if hasattr(found, "__len__") and not isinstance(found, str) else found


def make_all_odd() -> int:
    """Give every setting that no bake keeps an odd value; how many took one."""
    layer = context.scene.view_layers[0]
    layer.lightgroups.add(name="of the user")
    layer.aovs.add()
    changed = [name for owner, name in every_setting() if make_odd(owner, name)]
    context.scene.render.resolution_percentage = 1
    context.scene.render.use_border, context.scene.render.border_max_x = True, 0.1
    return len(changed)


def test_all_settings_but_the_kept_are_those_of_a_new_scene() -> None:
    small_scene()
    odd = make_all_odd()
    print(f"\n{odd} settings made odd")
    assert odd > 150
    fresh: Any = bpy.data.scenes.new("fresh")
    ours = {"use_compositing", "use_sequencer", "use_texture_cache", "use_grease_pencil", "filepath"}
    with scratch_scene(context.scene) as scratch:
        for path, kept in GROUPS.items():
            found, expected = scratch.path_resolve(path), fresh.path_resolve(path)
            for name in settings_of(found):
                if name in kept | ours or name in OTHERS or name.startswith(UNUSED):
                    continue
                assert _value(found, name) == _value(expected, name), f"{path}.{name}"
        layer: Any = scratch.view_layers[0]
        assert (len(layer.lightgroups), len(layer.aovs)) == (0, 0)


def test_what_is_kept_stays() -> None:
    small_scene()
    scene = context.scene
    kept = [
        (scene.cycles, "max_bounces", 3),
        (scene.cycles, "use_light_tree", False),
        (scene.cycles, "sample_clamp_indirect", 2.5),
        (scene.render, "film_transparent", True),
        (scene.render, "use_simplify", True),
        (scene.render, "simplify_subdivision_render", 1),
        (scene.render, "fps", 7),
        (scene.render, "frame_map_new", 50),
        (scene.view_layers[0], "use_volumes", False),
    ]
    for owner, name, value in kept:
        setattr(owner, name, value)
    with scratch_scene(scene) as scratch:
        copies = {scene.cycles: scratch.cycles, scene.render: scratch.render}
        for owner, name, value in kept:
            assert getattr(copies.get(owner, scratch.view_layers[0]), name) == value, name


def files_in(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


@pytest.mark.parametrize("name", SPECS)
def test_odd_settings_change_no_bit(name: str, tmp_path: Path) -> None:
    small_scene()
    if name == "layered":
        leave_out_floor()
    bake_object(context.scene, "Ball", SPECS[name], tmp_path / "plain")
    make_all_odd()
    bake_object(context.scene, "Ball", SPECS[name], tmp_path / "odd")
    plain = files_in(tmp_path / "plain")
    assert plain == files_in(tmp_path / "odd")
    assert len(plain) > 1


@pytest.mark.one_blender
def test_odd_settings_change_no_bit_of_a_farm(tmp_path: Path) -> None:
    small_scene()
    bpy.data.objects["Ball"].name = farming.BOX
    bake_object(context.scene, farming.BOX, PLAIN, tmp_path / "local")
    make_all_odd()
    farm = farming.prepared(context.scene, PLAIN, tmp_path / "farm")
    farming.render(farm.files.folder, f"1-{farm.manifest.sheets}")
    farming.assembled(farm.files.folder, tmp_path / "joined")
    assert files_in(tmp_path / "local") == files_in(tmp_path / "joined")


@pytest.mark.one_blender
def test_a_report_is_the_same(tmp_path: Path) -> None:
    small_scene()
    sidecar = bake_object(context.scene, "Ball", PLAIN, tmp_path / "bake").files.sidecar
    spec, found = ReportSpec(views=1, pixels=32, samples=2), []
    for odd in (False, True):
        if odd:
            make_all_odd()
        found.append(finished(cast(Any, report_steps(context.scene, sidecar, spec, tmp_path / "page.html"))))
    assert found[0].psnr == found[1].psnr
    assert found[0].energy == found[1].energy


@pytest.mark.one_blender
def test_a_picture_of_a_preview_has_the_size_that_is_asked_for(tmp_path: Path) -> None:
    small_scene()
    pictures = []
    for number, odd in enumerate((False, True)):
        if odd:
            make_all_odd()
        view = context.scene.view_settings
        view.view_transform, view.look, view.exposure, view.gamma = "Standard", "None", 0, 1
        view.use_curve_mapping = view.use_white_balance = False
        made = bake_object(
            context.scene, "Ball", PLAIN, tmp_path / str(number), preview=Filter.QUADRILINEAR, overwrite=True
        )
        assert made.files.preview is not None
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "kept.blend"))
        picture = tmp_path / f"{number}.png"
        render_picture(made.files.preview, picture, pixels=32, samples=4)
        image: Any = bpy.data.images.load(str(picture))
        assert tuple(image.size) == (32, 32)
        pictures.append(np.array(image.pixels[:]))
        bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "kept.blend"))
    np.testing.assert_array_equal(pictures[0], pictures[1])


@pytest.mark.one_blender
def test_a_view_layer_s_own_world_is_the_one_that_lights(tmp_path: Path) -> None:
    small_scene()
    for item in [item for item in bpy.data.objects if item.type == "LIGHT"]:
        bpy.data.objects.remove(item)
    leave_out_floor()
    for name, spec in SPECS.items():
        stage.world((0.3, 0.5, 0.9))
        context.view_layer.world_override = None
        bake_object(context.scene, "Ball", spec, tmp_path / name)
        context.view_layer.world_override = context.scene.world
        stage.world((0, 0, 0))
        bake_object(context.scene, "Ball", spec, tmp_path / f"{name} override")
        assert files_in(tmp_path / name) == files_in(tmp_path / f"{name} override"), name


def test_a_graded_reset_keeps_how_colours_are_shown() -> None:
    scene: Any = context.scene
    scene.view_settings.exposure, scene.render.resolution_percentage = 2.0, 30
    reset_render_settings(scene, graded=True)
    assert (scene.view_settings.exposure, scene.render.resolution_percentage) == (2.0, 100)
