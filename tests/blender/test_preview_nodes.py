# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group "RadTex Sample" in Cycles and in Eevee against the reference sampler."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import pytest

from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.errors import FormatError, InputError
from radtex_addon.core.sampler import Filter
from radtex_addon.formats.sidecar import Sidecar
from radtex_addon.formats.transfer_files import TransferSidecar, write_transfer
from radtex_addon.forms.sphere.preview import build_transfer_group
from radtex_addon.job import bake_object
from radtex_addon.preview.lit_material import DIRECTION, IRRADIANCE, first_sun
from radtex_addon.preview.material import load_atlas
from radtex_addon.preview.node_group import build_sample_group
from radtex_addon.preview.swap import switch_off, switch_on
from radtex_addon.scene.nodes import NodeBuilder, Socket
from radtex_addon.settings.spec import BakeSpec, Kind
from tests.blender import stage
from tests.blender.lookup_stage import ENGINES, Inputs, LookupStage, Shader, write_exr
from tests.lookups import (
    COUNT,
    LAYOUT,
    constant_buckets,
    random_atlas,
    random_lookups,
    relative_error,
    worst_error,
)
from tests.reference.relighting import sample_transfer
from tests.transfer_lookups import Way, questions

context: Any = bpy.context  # to the stubs, every pointer may be None
# Of the groups, the plain one asks the Eevee of each Blender, whose nodes the others have too.
NEWEST_EEVEE = [ENGINES["Cycles"], pytest.param(ENGINES["Eevee"], marks=pytest.mark.one_blender)]


def group_shader(image: bpy.types.Image, kind: Filter) -> Shader:
    def shader(build: NodeBuilder, inputs: Inputs) -> tuple[Socket, ...]:
        return build.group(build_sample_group(image, LAYOUT, kind), *inputs)

    return shader


@pytest.mark.parametrize("engine", ENGINES.values(), ids=ENGINES)
def test_the_group_agrees_with_the_reference_and_never_bleeds(engine: str, tmp_path: Path) -> None:
    varied, constant, lookups = random_atlas(), constant_buckets(), random_lookups()
    places = LookupStage(context.scene, engine)
    planes = [(varied, kind) for kind in Filter]
    planes += [(constant, kind) for kind in (Filter.LINEAR, Filter.QUADRILINEAR)]
    for index, (atlas, kind) in enumerate(planes):
        image = load_atlas(write_exr(tmp_path / f"atlas {index}.exr", atlas))
        places.add(lookups, group_shader(image, kind))
    results = places.render(tmp_path / "answers.exr")
    for (atlas, kind), result in zip(planes, results, strict=True):
        worst, across = worst_error(result, atlas, lookups, kind)
        print(f"{engine} {kind}: worst error {worst:.1e}, across an edge {across:.2%}")
        assert worst <= 2e-3
        assert across <= 2e-3
        if atlas is constant and kind is Filter.LINEAR:
            assert worst <= 1e-6  # whatever lies in the bucket beside it


def test_an_image_that_is_not_this_atlas_is_refused(tmp_path: Path) -> None:
    image = load_atlas(write_exr(tmp_path / "random.exr", random_atlas()))
    with pytest.raises(InputError, match="78 x 42 pixels, but 13 x 6 texels of 6 cells have 78 x 36"):
        build_sample_group(image, AtlasLayout(13, 6, 6), Filter.NEAREST)
    assert not bpy.data.node_groups


def test_an_atlas_beyond_the_gpu_is_refused_with_the_size_that_fits(tmp_path: Path) -> None:
    image = load_atlas(write_exr(tmp_path / "random.exr", random_atlas()))
    with pytest.raises(InputError, match=r"78 x 42 pixels cannot be previewed.*at most 11 texels of 6 cells"):
        build_sample_group(image, LAYOUT, Filter.NEAREST, max_pixels=70)


def test_a_preview_is_made_without_reading_the_atlas(tmp_path: Path) -> None:
    """Blender would take 16 bytes for each pixel: 4 GiB where the side has 16384."""
    image = load_atlas(write_exr(tmp_path / "random.exr", random_atlas()))
    build_sample_group(image, LAYOUT, Filter.QUADRILINEAR)
    assert not image.has_data
    assert tuple(cast(Any, image).size) == (LAYOUT.pixel_width, LAYOUT.pixel_height)
    assert image.has_data


def test_a_missing_or_broken_atlas_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.exr: no atlas"):
        load_atlas(tmp_path / "none.exr")
    (tmp_path / "broken.exr").write_text("no image")
    with pytest.raises(FormatError, match=r"broken\.exr: Blender reads no image"):
        load_atlas(tmp_path / "broken.exr")
    assert not bpy.data.images


def test_an_atlas_baked_again_is_read_again(tmp_path: Path) -> None:
    def corner(image: bpy.types.Image) -> list[float]:
        return list(cast(Any, image.pixels)[:4])

    first = load_atlas(write_exr(tmp_path / "a.exr", random_atlas(1)))
    before = corner(first)
    again = load_atlas(write_exr(tmp_path / "a.exr", random_atlas(2)))
    assert again == first
    assert corner(again) != before


@pytest.mark.parametrize("engine", NEWEST_EEVEE, ids=ENGINES)
def test_the_group_of_a_transfer_agrees_with_the_reference(engine: str, tmp_path: Path) -> None:
    atlas = random_atlas()
    around = np.random.default_rng(8).normal(size=(COUNT, 3)).astype(np.float32)
    lookups = replace(random_lookups(), viewer=around)
    facts = Sidecar(
        "A", "transfer", LAYOUT.width, LAYOUT.height, LAYOUT.bucket, "UV", 1, 0, "portal", "t", "5"
    )
    write_transfer(tmp_path / "A.transfer.json", atlas.astype(np.float32), TransferSidecar(facts, 36))
    group = build_transfer_group(load_atlas(tmp_path / "A.transfer.exr"), LAYOUT)
    places = LookupStage(context.scene, engine)
    places.add(lookups, lambda build, inputs: build.group(group, *inputs))
    (result,) = places.render(tmp_path / "answers.exr")
    expected = sample_transfer(atlas.astype(float), LAYOUT, lookups.uv.astype(float), lookups.incidence)
    error = relative_error(result, expected)
    print(f"{engine}: worst error {error.max():.1e}, mean {error.mean():.1e}")
    assert error.max() <= 4e-3  # Eevee renders half floats


@pytest.mark.parametrize("engine", NEWEST_EEVEE, ids=ENGINES)
def test_the_group_of_several_views_agrees_with_the_reference(engine: str, tmp_path: Path) -> None:
    question = next(each for each in questions() if each.way is Way.AROUND)
    light = np.tile(np.array([[0.3, -0.5, -0.2]], np.float32), (COUNT, 1))  # for all: there is no input more
    question = replace(question, light=light)
    path = write_exr(tmp_path / "A.exr", question.atlas)
    group = build_transfer_group(load_atlas(path), LAYOUT, question.views)

    def shader(build: NodeBuilder, inputs: Inputs) -> tuple[Socket, ...]:
        *frame, viewer = inputs
        return build.group(group, *frame, (0.3, -0.5, -0.2), viewer)

    places = LookupStage(context.scene, engine)
    places.add(question.lookups, shader)
    (result,) = places.render(tmp_path / "answers.exr")
    error = relative_error(result, question.answers)
    print(f"{engine}: worst error {error.max():.1e}, mean {error.mean():.1e}")
    assert error.max() <= 4e-3


def test_an_image_of_another_size_is_refused(tmp_path: Path) -> None:
    facts = Sidecar("A", "transfer", 2, 2, 4, "UV", 1, 0, "portal", "t", "5")
    write_transfer(tmp_path / "A.transfer.json", np.ones((8, 8, 4), np.float32), TransferSidecar(facts, 16))
    with pytest.raises(InputError, match="8 x 8 pixels, but 13 x 7 texels"):
        build_transfer_group(load_atlas(tmp_path / "A.transfer.exr"), LAYOUT)


def driven(material: bpy.types.Material) -> tuple[list[float], list[float]]:
    """Direction and irradiance as the evaluated material has them."""
    graph = context.evaluated_depsgraph_get()
    graph.update()
    nodes: Any = material.evaluated_get(graph).node_tree.nodes
    direction, irradiance = (
        [socket.default_value for socket in nodes[name].inputs] for name in (DIRECTION, IRRADIANCE)
    )
    return direction, irradiance


@pytest.mark.usefixtures("temporary")
def test_the_preview_follows_the_scenes_sun(tmp_path: Path) -> None:
    bpy.ops.mesh.primitive_plane_add(size=2)
    card = context.object
    card.name = "Card"
    card.data.materials.append(stage.material("Card", "ShaderNodeBsdfDiffuse"))
    bpy.ops.object.light_add(type="SUN", rotation=(0.3, 0.4, 0.5))
    sun = context.object
    sun.data.energy, sun.data.color = 4.0, (1.0, 0.5, 0.25)
    spec = BakeSpec(kind=Kind.TRANSFER, texels=6, bucket=3, samples=4)
    result = bake_object(context.scene, "Card", spec, tmp_path, preview=Filter.QUADRILINEAR)
    assert result.files.preview is not None
    names = {item.name for item in bpy.data.objects}

    copy = switch_on(card, result.files.sidecar).copy
    assert {item.name for item in bpy.data.objects} == names | {"Card (baked)"}  # no second sun came along
    material: Any = copy.data.materials[0]
    for turn in ((0.3, 0.4, 0.5), (2.5, 0.1, -1.0)):
        sun.rotation_euler = turn
        direction, irradiance = driven(material)
        np.testing.assert_allclose(direction, sun.rotation_euler.to_matrix().col[2], atol=1e-6)
        np.testing.assert_allclose(irradiance, (4.0, 2.0, 1.0), rtol=1e-6)
    switch_off(card)
    assert {item.name for item in bpy.data.objects} == names

    bpy.ops.wm.open_mainfile(filepath=str(result.files.preview))
    shown = context.scene.objects["Card"].material_slots[0].material
    found = first_sun(context.scene)
    assert found is not None
    found.rotation_euler = (1.0, 0.0, 0.0)
    np.testing.assert_allclose(driven(shown)[0], (0, -np.sin(1.0), np.cos(1.0)), atol=1e-6)
