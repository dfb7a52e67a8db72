# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that work in ACEScg or Rec.2020: whatever is baked holds Rec.709, and previews show it right.

`python -m tests.bench.working_spaces` has all kinds, layouts and layers.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import pytest
from mathutils import Color

from radtex_addon.bake.layers import Layer
from radtex_addon.bake.progress import finished
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.colour_spaces import matrix_to_rec709
from radtex_addon.core.errors import InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.formats.bucket_files import read_layer
from radtex_addon.formats.containers.exr import read_buckets
from radtex_addon.forms.layered.files.layered_files import read_layered
from radtex_addon.job import bake_object
from radtex_addon.preview.osl import add_osl_node
from radtex_addon.report.side_by_side import ComparisonSpec, compare_steps
from radtex_addon.report.viewpoint import Viewpoint
from radtex_addon.scene import working_space
from radtex_addon.scene.digests import scene_digests
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.settings.spec import BakeSpec, Layout
from radtex_addon.ui.jobs.comparison import make_images
from tests.blender import stage
from tests.blender.working_space_cases import REC_709, WIDE, WORLD, Images, images_of, work_in, worst

pytestmark = [
    pytest.mark.usefixtures("temporary"),
    pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="Blender 4.5 works in Rec.709 only"),
]
context: Any = bpy.context  # to the stubs, every pointer may be None

LAMBERT = 0.8 * np.array(WORLD)


@cache
def in_rec709(name: str, folder: Path) -> Images:
    return images_of(name, REC_709, folder)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    yield tmp_path_factory.mktemp("rec709")
    in_rec709.cache_clear()


def lambert_ball(space: str) -> None:
    stage.world(WORLD)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=12, ring_count=6)
    context.object.name = "Ball"
    grey = stage.material("grey", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8, 1))
    context.object.data.materials.append(grey)
    work_in(space)


@pytest.mark.parametrize(
    ("name", "space"),
    [
        ("radiance, all layers", WIDE[0]),
        ("radiance, a lamp", WIDE[1]),
        ("radiance by a farm, all layers", WIDE[1]),
        ("transfer", WIDE[0]),
    ],
)
def test_a_bake_is_what_it_is_in_rec709(name: str, space: str, out: Path, folder: Path) -> None:
    expected = in_rec709(name, folder / name)
    gaps = worst(images_of(name, space, out), expected)
    print("\n" + "\n".join(f"{name}, {image}: {gap:.1e}" for image, gap in gaps.items()))
    for image, gap in gaps.items():
        assert gap < 1e-3, image


@pytest.mark.parametrize("space", WIDE)
def test_a_lambert_ball_has_the_worlds_colour(out: Path, space: str) -> None:
    lambert_ball(space)
    spec = BakeSpec(uv_layer="UVMap", texels=8, bucket=4, samples=4, layers=(Layer.DIFFUSE,))
    sidecar = bake_object(context.scene, "Ball", spec, out).files.sidecar
    for pixels in (read_buckets(sidecar)[0][..., :3], read_layer(sidecar, Layer.DIFFUSE)):
        np.testing.assert_allclose(pixels.mean(axis=(0, 1), dtype=np.float64), LAMBERT, rtol=5e-3)
    spec = BakeSpec(uv_layer="UVMap", layout=Layout.LAYERED, texels=8, samples=4)
    atlas, _ = read_layered(bake_object(context.scene, "Ball", spec, out / "layered").files.sidecar)
    np.testing.assert_allclose(atlas.irradiance.mean(axis=(0, 1)), WORLD, rtol=5e-3)
    panorama = atlas.around.world.levels[0]
    np.testing.assert_allclose(panorama, np.broadcast_to(WORLD, panorama.shape), rtol=1e-3)


def test_a_comparison_sees_both_in_rec709(out: Path) -> None:
    lambert_ball("ACEScg")
    spec = BakeSpec(uv_layer="UVMap", texels=8, bucket=4, samples=4)
    made = bake_object(context.scene, "Ball", spec, out, preview=Filter.QUADRILINEAR)
    sidecar = made.files.sidecar
    bpy.ops.object.camera_add(location=(0, 0, 4))
    context.scene.camera = context.object
    eye = Viewpoint.of_camera(context.scene, context.view_layer)
    steps = compare_steps(
        context.scene, {bpy.data.objects["Ball"]: sidecar}, eye, ComparisonSpec(pixels=16, samples=4)
    )
    found = finished(steps)
    for picture in (found.traced, found.baked):
        np.testing.assert_allclose(picture[found.inside].mean(axis=0), LAMBERT, rtol=6e-2)
    traced = cast(Any, make_images(found.traced, found.baked)[0])
    assert traced.colorspace_settings.name == REC_709


def test_our_matrices_are_blenders() -> None:
    for space, identifier in zip(WIDE, ("lin_ap1_scene", "lin_rec2020_scene"), strict=True):
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        work_in(space)
        rows = [
            Color(row).from_scene_linear_to_rec709_linear()[:] for row in ((1, 0, 0), (0, 1, 0), (0, 0, 1))
        ]
        np.testing.assert_allclose(matrix_to_rec709(identifier), np.array(rows).T, atol=5e-6)


def test_a_bake_is_not_resumed_in_another_space() -> None:
    lambert_ball(REC_709)
    found = []
    for space in (REC_709, "ACEScg"):
        work_in(space)
        with scratch_scene(context.scene) as scratch:
            found.append(scene_digests(scratch)["working colour space"])
    assert found == [REC_709, "ACEScg"]


def test_a_space_that_is_not_known_is_refused(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    lambert_ball("ACEScg")
    monkeypatch.setattr(working_space, "KNOWN", frozenset({"lin_rec709_scene"}))
    with pytest.raises(
        InputError, match="the file works in the colour space 'ACEScg', which RadTex does not"
    ):
        bake_object(context.scene, "Ball", BakeSpec(texels=8, bucket=2, samples=1), out)
    assert not out.exists()


def test_osl_is_refused_in_another_space(tmp_path: Path) -> None:
    lambert_ball("ACEScg")
    tree = cast(Any, bpy.data.materials["grey"].node_tree)
    with pytest.raises(
        InputError, match=r"OSL shows Rec.709, and the file works in ACEScg: use the node group"
    ):
        add_osl_node(tree, tmp_path / "a.exr", AtlasLayout(1, 1, 1), Filter.NEAREST)
