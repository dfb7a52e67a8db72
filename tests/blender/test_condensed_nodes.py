# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group "RadTex Shared" of a condensed bake against the reference sampler, and its packed images."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.condensed import CondensedAtlas
from radtex_addon.core.errors import FormatError, InputError
from radtex_addon.core.shared import Axis
from radtex_addon.formats.shared_files import (
    read_condensed,
    read_shared_sidecar,
    texture_path,
    write_condensed,
)
from radtex_addon.preview.condensed_group import condensed_layers
from radtex_addon.preview.material import load_layers, preview_shared_material
from radtex_addon.preview.save import StandIn, save_preview
from radtex_addon.preview.shared_group import build_shared_group, check_shared_previewable
from tests.blender.lookup_stage import ENGINES, add_camera_above, render_exr, render_groups, set_up_render
from tests.lookups import relative_error
from tests.shared_atlases import facts_about, random_condensed_atlas
from tests.shared_lookups import random_fragments, shared_answers

WIDTH, HEIGHT = 7, 5
LOOKUPS = random_fragments(WIDTH, HEIGHT)
LAYERS = ["colour", "irradiance", "surroundings"] + [
    f"{axis}_{part}" for axis in ("mirror", "through") for part in ("weights", "ends", "gain", "rest")
]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "pane.radiance.json"


def small_atlas(**options: Any) -> CondensedAtlas:
    """An atlas of tiles of 8 x 8 pixels, unless `options` say otherwise."""
    return random_condensed_atlas(WIDTH, HEIGHT, **{"bucket": 6} | options)


def written(path: Path, atlas: CondensedAtlas) -> Path:
    write_condensed(path, atlas, facts_about(atlas))
    return path


def worst_errors(engine: str, atlases: list[CondensedAtlas], folder: Path) -> list[float]:
    """Each atlas's worst error, relative to the reference, in one render."""
    paths = [written(folder / f"{index}.json", atlas) for index, atlas in enumerate(atlases)]
    groups = [build_shared_group(*load_layers(path, half=False)) for path in paths]
    stored = [read_condensed(path)[0].expanded() for path in paths]
    return [
        float(relative_error(result, shared_answers(atlas, LOOKUPS)).max())
        for result, atlas in zip(render_groups(engine, groups, LOOKUPS, folder), stored, strict=True)
    ]


def values(image: bpy.types.Image) -> Floats:
    """An image's pixels, (height, width, 4) float32, row 0 at the bottom."""
    width, height = cast(Any, image).size
    pixels = np.empty(height * width * 4, dtype=np.float32)
    cast(Any, image.pixels).foreach_get(pixels)
    return pixels.reshape(height, width, 4)


@pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES)
def test_the_group_agrees_with_the_reference(engine: str, tmp_path: Path) -> None:
    (worst,) = worst_errors(engine, [small_atlas()], tmp_path)
    print(f"{engine}: worst error {worst:.1e}")
    assert worst <= 2e-3  # Eevee renders half floats


def test_any_lobes_ranks_and_clusters_will_do(tmp_path: Path) -> None:
    atlases = [
        small_atlas(lobes=()),
        small_atlas(lobes=(Axis.THROUGH,), rank=6, bucket=2),
        small_atlas(rank=6),  # of more lookups than Cycles could do all at once
        small_atlas(clusters=700, bucket=2),  # more than a byte counts, 46 tiles side by side
        small_atlas(clusters=1, lobes=(Axis.MIRROR,), bucket=14),
    ]
    for worst in worst_errors(ENGINES["Cycles"], atlases, tmp_path):
        print(f"worst error {worst:.1e}")
        assert worst <= 1e-3


@pytest.mark.parametrize("half", [False, True])
def test_packed_images_survive_saving(path: Path, half: bool) -> None:
    """Also below 0, above 1, and where a half float cannot count."""
    bucket, clusters = 2, 2100
    atlas = small_atlas(bucket=bucket, clusters=clusters)
    images, sidecar = load_layers(written(path, atlas), half)
    stored, _ = read_condensed(path)
    assert sidecar.condensed is not None
    layers = condensed_layers(stored, sidecar.condensed.columns)
    assert list(images) == list(layers) == LAYERS
    assert layers["mirror_ends"].min() < 0
    assert min(layers["mirror_gain"].max() - 1, layers["mirror_weights"].max() - 2048) > 0
    names = {layer: image.name for layer, image in images.items()}
    material = bpy.data.materials.new("keeps the group, and so the images")
    material.use_fake_user = True
    if material.node_tree is None:
        material.use_nodes = True
    group = cast(Any, material.node_tree).nodes.new("ShaderNodeGroup")
    group.node_tree = build_shared_group(images, sidecar)
    blend = path.with_name("a.blend")
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))
    for layer in sidecar.shapes:
        texture_path(path, layer).unlink()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    for layer, pixels in layers.items():
        image = cast(Any, bpy.data.images[names[layer]])
        weights = layer.endswith("weights")
        assert image.packed_file
        assert not image.filepath
        assert image.colorspace_settings.name == "Non-Color"  # the nodes multiply in Rec.709
        assert (image.alpha_mode, image.use_half_precision) == ("CHANNEL_PACKED", half and not weights)
        kind = np.float16 if half and not weights else np.float32
        np.testing.assert_array_equal(values(image)[..., : pixels.shape[2]], pixels.astype(kind))


@pytest.mark.parametrize("saved", [False, True], ids=["a file never saved", "a saved file"])
def test_the_preview_needs_no_file_beside_it(path: Path, saved: bool) -> None:
    """2 wherever one looks: 1 scattered, 1/2 met, 1/2 of the texel's own."""
    scene = cast(Any, bpy.context.scene)
    if saved:
        bpy.ops.wm.save_as_mainfile(filepath=str(path.with_name("user.blend")))
    mesh = bpy.data.meshes.new("pane")
    mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
    mesh.uv_layers.new(name="RadTex")
    pane = bpy.data.objects.new("pane", mesh)
    scene.collection.objects.link(pane)
    material = preview_shared_material("RadTex pane", written(path, even_light()), "RadTex")
    folder = path.with_name("elsewhere")
    save_preview(scene, [StandIn(pane, pane.copy(), (material,))], folder / "pane.preview.blend")
    bpy.ops.wm.open_mainfile(filepath=str(folder / "pane.preview.blend"))
    scene = cast(Any, bpy.context.scene)
    add_camera_above(scene, (0, 0), (2, 2), 8)
    set_up_render(scene, "CYCLES")
    image = render_exr(scene, folder / "view.exr")
    np.testing.assert_allclose(image, np.broadcast_to([2, 2, 2, 1], image.shape), rtol=2e-2)


def even_light() -> CondensedAtlas:
    random = small_atlas(lobes=(Axis.MIRROR,))
    (lobe,) = random.lobes
    even = replace(
        lobe,
        gain=np.full_like(lobe.gain, 0.25) * [[[[[1]]], [[[0]]], [[[0]]]]],
        rest=np.full_like(lobe.rest, 0.5) * [[[[[1]]], [[[0]]], [[[0]]]]],
    )
    return replace(
        random,
        colour=np.full_like(random.colour, 0.5),
        irradiance=np.full_like(random.irradiance, 2),
        falloff=np.ones_like(random.falloff),
        surroundings=tuple(np.full_like(level, 2) for level in random.surroundings),
        lobes=(even,),
    )


def test_a_texture_of_another_bake_is_refused(path: Path) -> None:
    written(path, small_atlas())
    texture_path(path, "mirror_gain").write_bytes(texture_path(path, "through_gain").read_bytes())
    with pytest.raises(FormatError, match="of another bake than"):
        preview_shared_material("preview", path, "RadTex")
    assert not bpy.data.images
    assert not bpy.data.node_groups


def test_a_bake_beyond_the_gpu_is_refused(path: Path) -> None:
    """700 clusters of 3 tiles of 4 x 4 pixels lie in 46 columns."""
    sidecar = read_shared_sidecar(written(path, small_atlas(clusters=700, bucket=2)))
    check_shared_previewable(sidecar, max_pixels=184)
    with pytest.raises(InputError, match="'mirror_ends_xy' has 184 x 184 pixels and cannot be previewed"):
        check_shared_previewable(sidecar, max_pixels=183)
