# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The node group "RadTex Layered" in Cycles and in Eevee against the reference sampler."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import bpy
import numpy as np
import pytest

from radtex_addon.core.arrays import Floats
from radtex_addon.core.colour_spaces import LUMINANCE
from radtex_addon.core.errors import InputError
from radtex_addon.core.fragments import Fragments
from radtex_addon.core.frame import normalised
from radtex_addon.forms.layered.files.layered_files import read_layered, write_layered
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas, alpha_at, sample_layered
from radtex_addon.forms.layered.lookup.environment import MOST_LAMPS
from radtex_addon.forms.layered.lookup.ways import Through
from radtex_addon.forms.layered.preview.group import SHOWS_THROUGH, build_layered_group
from radtex_addon.forms.layered.preview.material import check_layered_previewable, load_images
from radtex_addon.forms.layered.preview.osl import add_layered_osl_node
from radtex_addon.forms.layered.preview.surroundings import MOST_SHADED
from radtex_addon.scene.nodes import NodeBuilder, Socket
from tests.blender.lookup_stage import ENGINES, Inputs, LookupStage, Shader, data_image
from tests.layered.made_up import made_up_atlas, made_up_fragments
from tests.layered_lookups import (
    CASES,
    FACTS,
    SIZE,
    TEXELS,
    brushed,
    in_a_room,
    of_one_lobe,
    off,
    with_rest_at_every_texel,
)
from tests.lookups import COUNT, SIDE, Lookups

_RNG = np.random.default_rng(7)


@pytest.fixture(scope="module")
def plain() -> LayeredAtlas:
    return made_up_atlas(TEXELS, SIZE)


def _values(*shape: int) -> Floats:
    return cast(Floats, _RNG.uniform(0.2, 1, shape).astype(np.float32))


def with_maps(atlas: LayeredAtlas) -> LayeredAtlas:
    fine = atlas.colour.shape[:2]
    normal = normalised(_values(*fine, 3) - np.array([0.6, 0.6, 0], np.float32)).astype(np.float32)
    width = 4 * _values(*fine, 1) - 2
    return replace(atlas, tint=_values(*fine, 3), normal=normal, width=width, alpha=_values(*fine, 1))


def bare_group(atlas: LayeredAtlas) -> LayeredAtlas:
    return replace(
        atlas,
        around=replace(atlas.around, layers=(), lamps=()),
        materials=atlas.materials[:1],
        falloff=atlas.falloff[:1],
    )


def clear_group(atlas: LayeredAtlas) -> LayeredAtlas:
    """Light comes through it: along rays that change slowly, and all of a sudden."""
    coarse = atlas.own.shape[:2]
    towards = normalised(_RNG.normal(size=(*coarse, 1, 1, 3)) + 4 * _RNG.normal(size=(1, 1, 16, 16, 3)))
    weight = _RNG.uniform(0.2, 1, (*coarse, 16, 16, 1))
    place = _RNG.normal(size=(*coarse, 16, 16, 3)) * 0.1
    parts = [towards * weight, weight, place * weight, 0.01 * weight]
    ways = np.concatenate(parts, axis=-1).astype(np.float32)
    return replace(atlas, through=Through(ways, _values(*coarse, 3), _values(*coarse, 8, 8, 3)))


def lit_from_inside(room: LayeredAtlas) -> LayeredAtlas:
    """Without a sun, which Blender 4.5's previews let furniture hide nowhere."""
    lamps = tuple(lamp for lamp in room.around.lamps if not lamp.behind)
    return replace(room, around=replace(room.around, lamps=lamps))


def unfurnished(room: LayeredAtlas) -> LayeredAtlas:
    """Walls, and a sun behind them."""
    return replace(room, around=replace(room.around, layers=room.around.layers[:1]))


def brushed_group(atlas: LayeredAtlas) -> LayeredAtlas:
    """Brushed metal above a plane, before five lamps: those that Blender 5.2's stack holds with all maps."""
    whole = brushed(atlas)
    behind = [lamp for lamp in whole.around.lamps if lamp.behind]
    behind.sort(key=lambda lamp: -float(LUMINANCE @ lamp.irradiance))
    lamps = [replace(lamp, behind=lamp in behind[:MOST_SHADED]) for lamp in whole.around.lamps[:5]]
    return unfurnished(replace(whole, around=replace(whole.around, lamps=tuple(lamps))))


GROUPS: dict[str, Callable[[LayeredAtlas], LayeredAtlas]] = {
    "plain": lambda atlas: atlas,
    "bare": bare_group,
    "one lobe": of_one_lobe,
    "a rest at every texel": with_rest_at_every_texel,
    "room": lambda atlas: (
        in_a_room(atlas) if bpy.app.version >= (5, 0) else lit_from_inside(in_a_room(atlas))
    ),
    "brushed": brushed_group,
    "walls": lambda atlas: unfurnished(in_a_room(atlas)),
    "all": lambda atlas: clear_group(with_maps(atlas)) if SHOWS_THROUGH else with_maps(atlas),
}


def fragments_of(atlas: LayeredAtlas) -> Fragments:
    at = made_up_fragments(atlas, COUNT)
    tangent = normalised(np.cross(at.normal, [0.1, 0.2, 0.97])).astype(np.float32)
    return replace(at, tangent=tangent, bitangent=np.cross(at.normal, tangent).astype(np.float32))


def rendered(engine: str, path: Path, at: Fragments) -> Floats:
    """What the group answers for a bake at fragments, (K, 4)."""
    assert at.tangent is not None
    group = build_layered_group(*load_images(path, half=False))
    lookups = Lookups(at.uv, at.normal, at.tangent, np.ones(COUNT, np.float32), at.viewer)

    def shader(build: NodeBuilder, inputs: Inputs) -> tuple[Socket, ...]:
        place = build.vector("FRACTION", build.uv_map("places"))
        position = build.image(data_image("position", at.position), place)[0]
        material = build.image(data_image("material", at.material[:, None].astype(np.float32)), place)[0]
        number = build.separate(material)[0]
        return build.group(group, *inputs, position, number)

    stage = LookupStage(cast(bpy.types.Scene, bpy.context.scene), engine)
    stage.add(lookups, shader)
    return stage.render(path.parent / "answers.exr")[0]


@pytest.mark.parametrize(
    ("engine", "case"),
    [*(("Cycles", case) for case in GROUPS), ("Eevee", "all")],
)
def test_the_group_agrees_with_the_reference(
    engine: str, case: str, plain: LayeredAtlas, tmp_path: Path
) -> None:
    path = tmp_path / "Vase.radiance.json"
    write_layered(path, GROUPS[case](plain), FACTS, half=False)
    atlas, _ = read_layered(path)
    at = fragments_of(atlas)
    found, expected = rendered(ENGINES[engine], path, at), sample_layered(atlas, at)
    wrong = off(found[:, :3], expected)
    print(f"{engine}, {case}: worst {wrong.max():.1e}, mean {wrong.mean():.1e}")
    assert wrong.mean() < 1e-3
    assert wrong.max() < 5e-3  # Eevee renders half floats
    assert found[:, 3] == pytest.approx(alpha_at(atlas, at.uv), abs=2e-3)


@pytest.mark.one_blender
def test_an_image_of_another_bake_is_refused(plain: LayeredAtlas, tmp_path: Path) -> None:
    path = tmp_path / "Vase.radiance.json"
    write_layered(path, plain, FACTS)
    images, facts = load_images(path)
    with pytest.raises(InputError, match="112 x 112 pixels, but this bake's 'own' has 96 x 96"):
        build_layered_group(images, replace(facts, own_cells=12))


@pytest.mark.one_blender
def test_a_bake_beyond_the_gpu_is_refused(plain: LayeredAtlas, tmp_path: Path) -> None:
    path = tmp_path / "Vase.radiance.json"
    shapes = write_layered(path, plain, FACTS).shapes
    check_layered_previewable(shapes, max_pixels=128)
    with pytest.raises(InputError, match="'distances' has 128 x 128 pixels and cannot be previewed"):
        check_layered_previewable(shapes, max_pixels=127)


def test_the_curves_are_in_the_blend(plain: LayeredAtlas, tmp_path: Path) -> None:
    path = tmp_path / "Vase.radiance.json"
    write_layered(path, plain, FACTS)
    image: Any = load_images(path)[0]["curves"]
    assert image.packed_file is not None
    assert tuple(image.size) == (16, 12)


SHOWN = (
    *("everything", "parted ways", "glass ball", "made up", "things alone", "clear", "bare", "matt"),
    *("one lobe", "room", "brushed"),
)
NARROW = "narrow"
WORST = 1e-3
MATERIAL = 1


def narrow(atlas: LayeredAtlas) -> LayeredAtlas:
    """Seven texels have buckets across and five up: images are not square, and tiles are padded."""
    return replace(
        atlas,
        colour=atlas.colour[:40, :56],
        irradiance=atlas.irradiance[:10, :14],
        own=atlas.own[:5, :7],
        rest=atlas.rest[:5, :7],
    )


def layered_shader(path: Path, at: Fragments) -> Shader:
    def shader(build: NodeBuilder, inputs: Inputs) -> tuple[Socket, ...]:
        place = build.vector("FRACTION", build.uv_map("places"))
        position = build.image(data_image("position", at.position), place)[0]
        material = build.image(data_image("material", at.material[:, None].astype(np.float32)), place)[0]
        node = add_layered_osl_node(build.tree, path)
        sources = dict(zip(("UV", "Normal", "Tangent", "Sign", "Incoming"), inputs, strict=True))
        sources |= {"Position": position, "Material": build.separate(material)[0]}
        for name, source in sources.items():
            build.feed(node.inputs[name], source)
        return node.outputs["Color"], node.outputs["Alpha"]

    return shader


def osl_stage() -> LookupStage:
    stage = LookupStage(cast(bpy.types.Scene, bpy.context.scene), "CYCLES")
    cast(Any, stage.scene).cycles.shading_system = True
    return stage


def answers(
    atlases: dict[str, LayeredAtlas], folder: Path
) -> dict[str, tuple[LayeredAtlas, Fragments, Floats]]:
    """Of each atlas, as it is read from its files: itself, where it is looked up, what is found (K, 4)."""
    stage, asked = osl_stage(), {}
    for name, atlas in atlases.items():
        path = folder / f"{name}.radiance.json"
        height, width = atlas.irradiance.shape[:2]
        write_layered(path, atlas, replace(FACTS, width=width, height=height))
        at = fragments_of(atlas)
        assert at.tangent is not None
        lookups = Lookups(at.uv, at.normal, at.tangent, np.ones(COUNT, np.float32), at.viewer)
        stage.add(lookups, layered_shader(path, at))
        asked[name] = (read_layered(path)[0], at)
    found = stage.render(folder / "answers.exr")
    return {name: (*asked[name], one) for name, one in zip(asked, found, strict=True)}


@pytest.mark.parametrize(
    "names",
    [SHOWN[:1], pytest.param((*SHOWN[1:], NARROW), marks=pytest.mark.one_blender)],  # of one shader
    ids=[SHOWN[0], "others"],
)
def test_the_script_node_agrees_with_the_reference(
    names: tuple[str, ...], plain: LayeredAtlas, tmp_path: Path
) -> None:
    atlases = {name: narrow(plain) if name == NARROW else CASES[name](plain) for name in names}
    for name, (atlas, at, found) in answers(atlases, tmp_path).items():
        wrong = off(found[:, :3], sample_layered(atlas, at))
        print(f"OSL, {name}: worst error of {COUNT} lookups {wrong.max():.1e}, mean {wrong.mean():.1e}")
        assert wrong.max() <= WORST
        assert found[:, 3] == pytest.approx(alpha_at(atlas, at.uv), abs=1e-4)


@pytest.mark.one_blender
def test_what_is_not_linked_is_the_shaded_point_s_own(plain: LayeredAtlas, tmp_path: Path) -> None:
    """Seen from straight above, on the faces of one material."""
    path = tmp_path / "Vase.radiance.json"
    write_layered(path, plain, FACTS)
    atlas, at = read_layered(path)[0], fragments_of(plain)
    up = np.tile(np.array([0, 0, 1], np.float32), (COUNT, 1))
    places = (np.arange(COUNT)[:, None] // [1, SIDE] % SIDE + 0.5) / SIDE  # of the stage's first plane
    position = np.concatenate([places, np.zeros((COUNT, 1))], axis=1).astype(np.float32)
    material = np.full(COUNT, MATERIAL)

    def shader(build: NodeBuilder, inputs: Inputs) -> tuple[Socket, ...]:
        node = add_layered_osl_node(build.tree, path)
        build.feed(node.inputs["UV"], inputs[0])
        return node.outputs["Color"], node.outputs["Alpha"]

    stage = osl_stage()
    stage.add(Lookups(at.uv, up, up, np.ones(COUNT, np.float32), up), shader)
    mesh = cast(bpy.types.Mesh, stage.columns[0].data)
    cast(Any, mesh.attributes.new("radtex_material", "INT", "FACE")).data[0].value = MATERIAL
    (found,) = stage.render(tmp_path / "answers.exr")
    expected = sample_layered(atlas, Fragments(at.uv, up, up, position, material))
    assert off(found[:, :3], expected).max() <= WORST


@pytest.mark.one_blender
def test_more_lamps_than_shaders_take_are_refused(plain: LayeredAtlas, tmp_path: Path) -> None:
    path = tmp_path / "Vase.radiance.json"
    lamps = plain.around.lamps * (MOST_LAMPS + 1)
    write_layered(path, replace(plain, around=replace(plain.around, lamps=lamps)), FACTS)
    with pytest.raises(
        InputError, match=f'"Vase" mirrors {MOST_LAMPS + 1} lamps, shaders at most {MOST_LAMPS}'
    ):
        add_layered_osl_node(empty_tree(), path)


def empty_tree() -> bpy.types.NodeTree:
    return cast(bpy.types.NodeTree, bpy.data.node_groups.new("tree", "ShaderNodeTree"))
