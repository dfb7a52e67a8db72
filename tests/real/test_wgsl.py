# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/*.wgsl by wgpu, on a real Vulkan, against the reference samplers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import astuple, replace
from pathlib import Path

import numpy as np
import pytest

from radtex_addon.core.arrangements import Pages, fitting_pages, padded_layout, to_slices
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.frame import normalised, orthonormal_frame, to_frame
from radtex_addon.core.sampler import Filter, sample
from radtex_addon.forms.layered.files.arrangement import CHANNELS
from radtex_addon.forms.layered.lookup.atlas import look_at, shading_normal
from radtex_addon.forms.layered.shader_values import (
    BAKE_BUFFER,
    DEFAULT,
    FULL,
    MATERIAL_BUFFER,
    THROUGH_BUFFER,
    LookupCost,
    Values,
    bake_values,
    buffer_of,
    definitions,
    material_values,
)
from tests.layered_lookups import USUAL, Case, assert_agrees, case_of, off
from tests.lookups import (
    COUNT,
    LAYOUT,
    SIDE,
    Lookups,
    constant_buckets,
    hit_answers,
    random_atlas,
    random_lookups,
    relative_error,
    squared_steps,
    worst_error,
)
from tests.real.root import Root
from tests.real.shadows import (
    ACROSS,
    ANGLE,
    CORNER,
    ONE,
    POINTS,
    RECTANGLE,
    SUN,
    UP,
    check,
    expected,
    random_words,
    stacked,
)
from tests.real.webgpu import Resource, Sampler, Texture, drawn, fields, image
from tests.reference.levels import level_chain, sample_level
from tests.reference.pages import split_pages
from tests.reference.slices import mip_chain, sample_slices

FOLDER = Path(__file__).parents[2] / "shaders"
FILES = ("radtex", "radtex_pages", "radtex_transfer")  # all in one: names do not clash
QUADS = COUNT // 4  # derivatives are those within 2 x 2 fragments
LEVELS = 4  # 13 x 7 texels are stored as 16 x 8
PAGES = fitting_pages(LAYOUT, limit=40)
TALL_PAGES = fitting_pages(LAYOUT, limit=48, levels=LEVELS)
WORST = 2e-3
FRAGMENT = """
struct Settings { texels: vec2i, n: i32, mode: i32, pages: vec4i }
@group(0) @binding(0) var<uniform> s: Settings;
@group(0) @binding(1) var fields: texture_2d_array<f32>;
@group(0) @binding(2) var atlas: %s;
@group(0) @binding(3) var filtering: sampler;
@fragment fn main(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let here = vec2i(at.xy);
    let place = textureLoad(fields, here, 0, 0);
    let uv = place.xy;
    let level = place.z;
    let normal = textureLoad(fields, here, 1, 0);
    let tangent = textureLoad(fields, here, 2, 0).xyz;
    let viewer = textureLoad(fields, here, 3, 0).xyz;
    let I = radtex_incidence(viewer, normal.xyz, tangent, normal.w);
    let result = %s;
    if s.n < 0 { return vec4f(level); }  // never: all bindings are in use
    return result;
}
"""
SINGLE, ARRAY = "texture_2d<f32>", "texture_2d_array<f32>"


def run(
    root: Root,
    lookup: str,
    atlas: Texture,
    lookups: Lookups,
    *,
    kind: Filter = Filter.QUADRILINEAR,
    level: Floats | float = 0.0,
    pages: Pages = PAGES,
) -> Floats:
    """What the expression `lookup` is for each of the lookups, (K, 4) float32."""
    places = np.concatenate([lookups.uv, np.broadcast_to(level, COUNT)[:, None]], axis=1)
    normals = np.concatenate([lookups.normal, lookups.sign[:, None]], axis=1)
    settings = [LAYOUT.width, LAYOUT.height, LAYOUT.bucket, list(Filter).index(kind), *astuple(pages)]
    resources: dict[int | str, Resource] = {
        "s": np.array(settings, np.int32),
        "fields": fields(SIDE, places, normals, lookups.tangent, lookups.viewer),
        "atlas": atlas,
    }
    if "filtering" in lookup:
        resources["filtering"] = Sampler("linear")
    code = "".join(FOLDER.joinpath(f"{name}.wgsl").read_text(encoding="utf-8") for name in FILES)
    return drawn(root, code + FRAGMENT % (ARRAY if atlas.array else SINGLE, lookup), resources, SIDE)


@pytest.mark.parametrize("kind", list(Filter))
def test_wgsl_agrees_with_the_reference(root: Root, kind: Filter) -> None:
    atlas, lookups = random_atlas(), random_lookups()
    result = run(root, "radtex_sample(atlas, s.texels, s.n, uv, I, s.mode)", image(atlas), lookups, kind=kind)
    worst, across = worst_error(result, atlas, lookups, kind)
    print(f"{kind}: worst error {worst:.1e}, across an edge {across:.2%}")
    assert worst <= WORST
    assert across <= 2e-3


@pytest.mark.parametrize("kind", list(Filter))
def test_pages_agree_with_the_reference(root: Root, kind: Filter) -> None:
    atlas, lookups = random_atlas(), random_lookups()
    lookup = "radtex_sample_paged(atlas, s.pages, s.texels, s.n, uv, I, s.mode)"
    result = run(root, lookup, image(split_pages(atlas, LAYOUT, PAGES)), lookups, kind=kind)
    worst, across = worst_error(result, atlas, lookups, kind)
    print(f"{PAGES.layers} pages, {kind}: worst error {worst:.1e}, across an edge {across:.2%}")
    assert worst <= WORST
    assert across <= 2e-3


def test_levels_agree_with_the_reference(root: Root) -> None:
    lookups, level = random_lookups(), random_levels(LEVELS)
    chain = level_chain(random_atlas(), LAYOUT, LEVELS)
    expected = sample_level(chain, LAYOUT, lookups.uv.astype(float), lookups.incidence, level)
    lookup = "radtex_sample_level(atlas, s.texels, s.n, uv, I, level)"
    error = relative_error(run(root, lookup, image(*chain), lookups, level=level), expected)
    stored = padded_layout(LAYOUT, LEVELS)
    parts = [AtlasLayout(stored.width >> k, stored.height >> k, LAYOUT.bucket) for k in range(LEVELS)]
    split = [split_pages(chain[k], parts[k], TALL_PAGES.at_level(k)) for k in range(LEVELS)]
    lookup = "radtex_sample_level_paged(atlas, s.pages, s.texels, s.n, uv, I, level)"
    paged = run(root, lookup, image(*split), lookups, level=level, pages=TALL_PAGES)
    print(
        f"{LEVELS} levels: worst error {error.max():.1e}, paged {relative_error(paged, expected).max():.1e}"
    )
    assert error.max() <= WORST
    assert relative_error(paged, expected).max() <= WORST


def test_rays_find_what_the_reference_does(root: Root) -> None:
    atlas, lookups = random_atlas(), random_lookups()
    expected = hit_answers(atlas, lookups)
    arguments = "s.texels, s.n, uv, -viewer, normal.xyz, tangent, normal.w, s.mode"
    error = relative_error(run(root, f"radtex_hit(atlas, {arguments})", image(atlas), lookups), expected)
    split = image(split_pages(atlas, LAYOUT, PAGES))
    paged = relative_error(
        run(root, f"radtex_hit_paged(atlas, s.pages, {arguments})", split, lookups), expected
    )
    print(f"rays: worst error {error.max():.1e}, paged {paged.max():.1e}")
    assert max(error.max(), paged.max()) <= WORST
    filtered = run(root, f"radtex_hit_filtered(atlas, filtering, {arguments})", image(atlas), lookups)
    np.testing.assert_allclose(filtered, expected, rtol=0, atol=float(atlas.max()) * 2 / 256)


def test_slices_agree_with_the_reference(root: Root) -> None:
    chain = mip_chain(to_slices(random_atlas(), LAYOUT))
    lookups, level = random_lookups(), random_levels(len(chain))
    lookup = "radtex_slices_level(atlas, filtering, s.n, uv, I, level)"
    result = run(root, lookup, image(*chain), lookups, level=level)
    error = relative_error(result, sample_slices(chain, lookups.uv.astype(float), lookups.incidence, level))
    print(f"slices: worst error {error.max():.1e}, median {np.median(error):.1e}")
    assert error.max() <= WORST


def test_fragments_know_their_level(root: Root) -> None:
    rng = np.random.default_rng(6)
    across, up = (np.exp(rng.uniform(-1, 3, (QUADS, 1))) * turned(rng) for _ in "xy")
    longer = np.maximum(np.linalg.norm(across, axis=1), np.linalg.norm(up, axis=1))
    expected = np.clip(np.log2(longer), 0, LEVELS - 1)
    lookup = f"vec4f(radtex_level(uv, s.texels, {LEVELS}) + 0.0 * textureLoad(atlas, vec2i(0), 0))"
    result = run(root, lookup, image(random_atlas()), in_quads(across, up, rng))
    error = np.abs(result[:, 0] - of_quads(expected))
    print(f"levels by derivatives: worst error {error.max():.1e}")
    assert error.max() <= 1e-3


def test_slices_are_filtered_by_the_hardware(root: Root) -> None:
    """Places half a texel to nine texels apart. Mesa's logarithm, hence its level, is 0.04 off at most."""
    rng = np.random.default_rng(7)
    across, up = np.exp(rng.uniform(-0.7, 2.2, (2, QUADS, 1))) * np.eye(2)[:, None]
    chain, lookups = mip_chain(to_slices(random_atlas(), LAYOUT)), in_quads(across, up, rng)
    lookup = "radtex_slices(atlas, filtering, s.n, uv, I)"
    numbers = [np.full_like(slices, number) for number, slices in enumerate(chain)]
    level = run(root, lookup, image(*numbers), lookups)[:, 0]
    exact = np.log2(np.maximum(across[:, 0], up[:, 1]))
    apart = np.abs(level - np.clip(of_quads(exact), 0, len(chain) - 1)).max()
    result = run(root, lookup, image(*chain), lookups)
    error = relative_error(result, sample_slices(chain, lookups.uv.astype(float), lookups.incidence, level))
    print(f"mipmapped slices: worst error {error.max():.1e}, of the level {apart:.2f}")
    assert error.max() <= WORST
    assert apart <= 0.05


@pytest.mark.parametrize(
    ("lookup", "rounding"),
    [
        ("radtex_sample(atlas, s.texels, s.n, uv, I, s.mode)", 1e-7),
        ("radtex_sample_filtered(atlas, filtering, s.texels, s.n, uv, I, s.mode)", 5e-4),
    ],
)
def test_buckets_do_not_bleed(root: Root, lookup: str, rounding: float) -> None:
    atlas, lookups = constant_buckets(), random_lookups()
    result = run(root, lookup, image(atlas), lookups, kind=Filter.LINEAR)
    assert worst_error(result, atlas, lookups, Filter.LINEAR)[0] <= rounding


@pytest.mark.parametrize("kind", [Filter.LINEAR, Filter.QUADRILINEAR])
def test_one_hardware_lookup_is_as_good_as_its_weights(root: Root, kind: Filter) -> None:
    atlas, lookups = random_atlas(), random_lookups()
    lookup = "radtex_sample_filtered(atlas, filtering, s.texels, s.n, uv, I, s.mode)"
    result = run(root, lookup, image(atlas), lookups, kind=kind)
    expected = sample(atlas.astype(float), LAYOUT, lookups.uv.astype(float), lookups.incidence, kind)
    np.testing.assert_allclose(result, expected, rtol=0, atol=float(atlas.max()) * 2 / 256)


def test_one_hardware_lookup_at_a_level(root: Root) -> None:
    lookups, level = random_lookups(), random_levels(LEVELS)
    chain = level_chain(random_atlas(), LAYOUT, LEVELS)
    expected = sample_level(chain, LAYOUT, lookups.uv.astype(float), lookups.incidence, level)
    lookup = "radtex_sample_level_filtered(atlas, filtering, s.texels, s.n, uv, I, level)"
    result = run(root, lookup, image(*chain), lookups, level=level)
    np.testing.assert_allclose(result, expected, rtol=0, atol=float(chain[0].max()) * 2 / 256)


def test_the_example_draws_an_object(root: Root) -> None:
    """A stretched and mirrored square before the camera; normals lean, and v grows downwards as in glTF."""
    model = np.diag([-1.6, 0.8, 1.2, 1])
    model[:3, 3] = 0.3, -0.2, 0.1
    camera, normal, tangent = np.array([0.4, -0.3, 1.1]), np.array([0.3, 0.2, 1.0]), np.array([1.0, 0.4, 0.2])
    corners = np.array([[-1, -1], [1, -1], [-1, 1], [-1, 1], [1, -1], [1, 1]], float)
    world = np.column_stack([corners, np.zeros(6), np.ones(6)])
    vertices = [
        (world @ np.linalg.inv(model).T)[:, :3],
        np.tile(normal, (6, 1)),
        np.tile([*tangent, 1.0], (6, 1)),
        (corners * [1, -1] + 1) / 2,
    ]
    flat = np.diag([1.0, 1, 0, 1])  # what is seen is what lies in [-1, 1]²
    scene = b"".join([
        np.array([flat.T, model.T], np.float32).tobytes(),
        np.array(camera, np.float32).tobytes(),
        np.array([LAYOUT.bucket, LAYOUT.width, LAYOUT.height, LEVELS, 0], np.int32).tobytes(),
    ])  # fmt: skip
    chain = level_chain(random_atlas(), LAYOUT, LEVELS)
    resources: dict[int | str, Resource] = {"scene": np.frombuffer(scene, np.uint8), "atlas": image(*chain)}
    files = (FOLDER / "radtex.wgsl", FOLDER / "examples" / "object.wgsl")
    code = "".join(path.read_text(encoding="utf-8") for path in files)
    result = drawn(root, code, resources, SIDE, "fragment", vertices=vertices)

    y, x = np.divmod(np.arange(COUNT), SIDE)
    seen = np.stack([(x + 0.5) / SIDE, 1 - (y + 0.5) / SIDE], axis=1)
    viewer = normalised(camera - np.column_stack([2 * seen - 1, np.zeros(COUNT)]))
    upright, along = np.linalg.inv(model[:3, :3]).T @ normal, model[:3, :3] @ tangent
    t, bt, n = orthonormal_frame(upright[None], along[None], np.array([-1.0]))
    expected = sample_level(chain, LAYOUT, seen, to_frame(viewer, t, bt, n), np.array(0.0))
    error = relative_error(result, expected)
    print(f"example: worst error {error.max():.1e}")
    assert error.max() <= WORST


def test_what_is_wrong_with_a_shader_is_told(root: Root) -> None:
    with pytest.raises(ValueError, match="radtex_bukcet"):
        run(root, "vec4f(radtex_bukcet(I), 0.0, 0.0)", image(random_atlas()), random_lookups())


def random_levels(levels: int) -> Floats:
    """A level for each lookup, whole ones and the last among them, (K,) float32."""
    rng = np.random.default_rng(5)
    level = rng.uniform(0, levels - 1, COUNT)
    level[: COUNT // 4] = rng.integers(0, levels, COUNT // 4)
    return level.astype(np.float32)


def turned(rng: np.random.Generator) -> Floats:
    """Unit vectors, one a quad, (QUADS, 2)."""
    angle = rng.uniform(0, 2 * np.pi, QUADS)
    return np.stack([np.cos(angle), np.sin(angle)], axis=1)


def of_quads(values: Floats) -> Floats:
    """A value of each 2 x 2 fragments (QUADS, ...) for all four, (K, ...)."""
    grid = values.reshape(SIDE // 2, SIDE // 2, *values.shape[1:])
    return grid.repeat(2, axis=0).repeat(2, axis=1).reshape(COUNT, *values.shape[1:])


def in_quads(across: Floats, up: Floats, rng: np.random.Generator) -> Lookups:
    """Lookups `across` and `up` (QUADS, 2), in texels, from the next fragment of the same quad."""
    y, x = np.divmod(np.arange(COUNT), SIDE)
    step = of_quads(across) * (x % 2)[:, None] + of_quads(up) * (y % 2)[:, None]
    uv = of_quads(rng.uniform(0, 1, (QUADS, 2))) + step / [LAYOUT.width, LAYOUT.height]
    return replace(random_lookups(), uv=uv.astype(np.float32))


FOLDER = Path(__file__).parents[2] / "shaders"
LAYERED = """
@group(0) @binding(30) var fields: texture_2d_array<f32>;
@fragment fn main(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let here = vec2i(at.xy);
    let uv = textureLoad(fields, here, 0, 0).xy;
    let position = textureLoad(fields, here, 1, 0).xyz;
    let N = textureLoad(fields, here, 2, 0).xyz;
    let V = textureLoad(fields, here, 3, 0).xyz;
    let T = textureLoad(fields, here, 4, 0).xyz;
    let B = textureLoad(fields, here, 5, 0).xyz;
    return vec4f(%s, 1.0);
}
"""
LOOKUP, THROUGH, STEADY = (
    "radtex_layered(uv, position, N, V)",
    "radtex_layered_through(uv, position, N, V, T, B)",
    "radtex_layered_steady(uv, position, N, V, 0.002)",
)


def run_layered(root: Root, case: Case, cost: LookupCost, lookup: str = "") -> Floats:
    """The shader's answers, (N, 3) float32; by another `lookup` than the one that exports name if told."""
    names = ["radtex_layered", *(["radtex_layered_through"] if case.through else [])]
    code = "".join((FOLDER / f"{name}.wgsl").read_text(encoding="utf-8") for name in names)
    code = code.replace("@group(1)", "@group(0)") + LAYERED % (
        lookup or (THROUGH if case.through else LOOKUP)
    )
    constants = {name: float(value) for name, value in definitions(case.sidecar, cost).items()}
    constants.pop("RADTEX_THROUGH", None)
    values = bake_values(case.sidecar, case.stored, cost)
    resources: dict[int | str, Resource] = {
        "radtex": packed(values, BAKE_BUFFER),
        "radtex_filtering": Sampler("linear"),
        "fields": fields(SIDE, *case.fields.values()),
    }
    if case.through:
        resources["radtex_exit"] = packed(values, THROUGH_BUFFER)
    lacking = image(np.zeros((1, 1, 4), np.float16))
    for layer in CHANNELS:
        if f"radtex_{layer}_map" in code:
            levels = case.textures.get(layer)
            resources[f"radtex_{layer}_map"] = lacking if levels is None else image(*levels)

    def with_material(number: int) -> Floats:
        of_material = packed(material_values(case.sidecar, number, cost), MATERIAL_BUFFER)
        return drawn(root, code, resources | {"radtex_of": of_material}, SIDE, constants=constants)

    return case.by_material(with_material)


def packed(values: Values, layout: Mapping[str, int]) -> Floats:
    return np.array(buffer_of(values, layout), dtype=np.float32)


@pytest.mark.parametrize("name", USUAL)
def test_the_layered_layout_agrees_with_the_reference(root: Root, name: str) -> None:
    case = case_of(name)
    assert_agrees(name, run_layered(root, case, FULL), case)


def test_lobes_widen_where_normals_differ_within_a_pixel(root: Root) -> None:
    case = case_of("made up")
    normal = shading_normal(look_at(case.atlas, case.at), case.at)
    spread = 0.002 * squared_steps(normal, np.ones(COUNT, dtype=bool), SIDE)
    assert np.median(spread) > 1e-3
    wider = replace(case, at=replace(case.at, spread=spread.astype(np.float32)))
    found = run_layered(root, case, FULL, STEADY)
    assert_agrees("steady", found, wider)
    assert off(found, case.answers()).mean() > 0.01, "without, they are not the same"


def test_thrift_changes_little_of_the_layered_layout(root: Root) -> None:
    case = case_of("everything")
    wrong = off(run_layered(root, case, DEFAULT), case.answers())
    print(f"as it is by default: mean error {wrong.mean():.1e}")
    assert wrong.mean() < 0.01
    noise = off(run_layered(root, case, replace(DEFAULT, temporal=True)), case.answers())
    print(f"drawn by chance: mean error {noise.mean():.1e}")
    assert 0.01 < noise.mean() < 0.05


FOLDER = Path(__file__).parents[2] / "shaders"
SHADOW = """
struct Settings { corner: vec4f, across: vec4f, up: vec4f, texels: vec2i, n: i32, mode: i32 }
@group(0) @binding(0) var<uniform> s: Settings;
@group(0) @binding(1) var fields: texture_2d_array<f32>;
@group(0) @binding(2) var bits: texture_2d_array<u32>;
@fragment fn main(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(at.xy);
    let normal = textureLoad(fields, pixel, 1, 0);
    let light = textureLoad(fields, pixel, 3, 0).xyz;
    let frame = radtex_frame(normal.xyz, textureLoad(fields, pixel, 2, 0).xyz, normal.w);
    let here = radtex_shadow(bits, s.texels, textureLoad(fields, pixel, 0, 0).xy);
    if s.mode == 0 { return vec4f(radtex_visible(bits, here, s.n, normalize(light) * frame)); }
    if s.mode == 1 { return vec4f(radtex_sun(bits, here, s.n, frame, light, s.corner.w, i32(s.up.w))); }
    let side = s.across.xyz;
    return vec4f(radtex_rectangle(bits, here, s.n, frame, light, s.corner.xyz, side, s.up.xyz, i32(s.up.w)));
}
"""


@pytest.mark.parametrize("mode", [ONE, SUN, RECTANGLE])
@pytest.mark.parametrize("cells", [5, 8, 12])
def test_shadows_agree_with_the_reference(root: Root, cells: int, mode: int) -> None:
    layout, lookups = AtlasLayout(13, 7, cells), random_lookups()
    words = random_words(layout)
    settings = np.array([*CORNER, ANGLE, *ACROSS, 0, *UP, POINTS], np.float32).tobytes()
    settings += np.array([layout.width, layout.height, cells, mode], np.int32).tobytes()
    normals = np.concatenate([lookups.normal, lookups.sign[:, None]], axis=1)
    resources: dict[int | str, Resource] = {
        "s": np.frombuffer(settings, np.uint8),
        "fields": fields(SIDE, lookups.uv, normals, lookups.tangent, lookups.viewer),
        "bits": image(stacked(words)),
    }
    code = "".join(
        FOLDER.joinpath(f"{name}.wgsl").read_text(encoding="utf-8") for name in ("radtex", "radtex_shadow")
    )
    found = drawn(root, code + SHADOW, resources, SIDE)[:, 0]
    wanted = expected(words, layout, lookups, mode, cells > 8)
    check(found, wanted, mode, cells > 8, f"WGSL, {cells} cells")
