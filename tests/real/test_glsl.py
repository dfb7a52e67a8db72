# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""shaders/*.glsl on a real OpenGL, over EGL, against the references."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple, replace
from pathlib import Path

import moderngl
import numpy as np
import pytest

from radtex_addon.core.arrangements import fitting_pages, to_slices
from radtex_addon.core.arrays import Floats
from radtex_addon.core.atlas import AtlasLayout
from radtex_addon.core.sampler import Filter
from radtex_addon.formats.shadow_files import Words
from radtex_addon.formats.transfer_files import with_views
from radtex_addon.forms.layered.shader_values import (
    DEFAULT,
    FULL,
    LookupCost,
    bake_values,
    definitions,
    layers_read,
    material_values,
)
from tests import transfer_lookups
from tests.bench.fidelity.layered.conditions import fetches
from tests.layered_lookups import CASES, Case, assert_agrees, case_of, image_case, off, variants
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
    worst_error,
)
from tests.real.opengl import VERSIONS, Texture, compiled, drawn, mipmapped, set_values
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
from tests.reference.levels import level_chain, sample_level
from tests.reference.pages import page_chain
from tests.reference.slices import mip_chain, sample_slices
from tests.transfer_lookups import VIEWS, Question, Way, questions, random_lights

SHADERS = Path(__file__).parents[2] / "shaders"
SHADER = SHADERS / "radtex.glsl"
WORST = 2e-3
LEVELS = 4  # 13 x 7 texels are stored as 16 x 8, and the last level as 2 x 1
PAGED, HARDWARE = "#define RADTEX_PAGES\n", "#define RADTEX_HARDWARE_LINEAR\n"
WAYS = {"one texture": "", "pages": PAGED}
FRAGMENT = """
#ifdef RADTEX_PAGES
uniform highp sampler2DArray atlas;
uniform ivec4 pages;
#else
uniform sampler2D atlas;
#endif
uniform sampler2D uvs, normals, tangents, viewers;
uniform ivec2 texels;
uniform int n, mode;
out vec4 result;
void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec4 normal = texelFetch(normals, here, 0), tangent = texelFetch(tangents, here, 0);
    vec3 viewer = texelFetch(viewers, here, 0).xyz;
    vec3 I = radtex_incidence(viewer, normal.xyz, tangent.xyz, normal.w);
    vec3 uv = texelFetch(uvs, here, 0).xyz;  // and the level
    if (mode < 3) result = radtex_sample(RADTEX_PASSED, texels, n, uv.xy, I, mode);
    else if (mode == 3) result = radtex_sample_level(RADTEX_PASSED, texels, n, uv.xy, I, uv.z);
    else result = radtex_hit(RADTEX_PASSED, texels, n, uv.xy, -viewer, normal.xyz, tangent.xyz, normal.w,
                             RADTEX_QUADRILINEAR);
}
"""
BY_LEVEL, BY_RAY = 3, 4  # the shader's modes, after the filters


def run(
    context: moderngl.Context, head: str, atlas: Floats, lookups: Lookups, mode: int, level: Floats
) -> Floats:
    """The shader's answers, (K, 4) float32; `head` is a version and defines, `level` (K,)."""
    program = compiled(context, head, SHADER.read_text(encoding="utf-8") + FRAGMENT)
    program["texels"], program["n"], program["mode"] = (LAYOUT.width, LAYOUT.height), LAYOUT.bucket, mode
    if PAGED in head:
        pages = fitting_pages(LAYOUT, 50, LEVELS)
        program["pages"] = (pages.columns, pages.rows, pages.width, pages.height)
        chain = page_chain(atlas, LAYOUT, pages, LEVELS)
    else:
        chain = level_chain(atlas, LAYOUT, LEVELS)
    signed = np.concatenate([lookups.normal, lookups.sign[:, None]], axis=1)
    places = np.concatenate([lookups.uv, level[:, None]], axis=1).astype(np.float32)
    inputs = {"uvs": places, "normals": signed, "tangents": lookups.tangent, "viewers": lookups.viewer}
    fields = {name: values.reshape(SIDE, SIDE, -1) for name, values in inputs.items()}
    sampled = moderngl.LINEAR_MIPMAP_NEAREST if HARDWARE in head else moderngl.NEAREST
    stored = mipmapped(context, [image.astype(np.float16) for image in chain], sampled)
    return drawn(context, program, {"atlas": stored, **fields}, SIDE)


def filtered(context: moderngl.Context, head: str, atlas: Floats, lookups: Lookups, kind: Filter) -> Floats:
    return run(context, head, atlas, lookups, list(Filter).index(kind), np.zeros(COUNT))


def random_levels(seed: int = 5) -> Floats:
    """Levels (K,) float32, many of them whole, one for 2 x 2 pixels: Mesa reads no more."""
    level = np.random.default_rng(seed).uniform(0, LEVELS - 1, (SIDE // 2, SIDE // 2))
    level[::3] = np.round(level[::3])
    return np.kron(level, np.ones((2, 2))).ravel().astype(np.float32)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", list(Filter))
def test_glsl_agrees_with_the_reference(
    context: moderngl.Context, version: str, kind: Filter, way: str
) -> None:
    atlas, lookups = random_atlas(), random_lookups()
    result = filtered(context, VERSIONS[version] + WAYS[way], atlas, lookups, kind)
    worst, across = worst_error(result, atlas, lookups, kind)
    print(f"{version} {kind}, {way}: worst error {worst:.1e}, across an edge {across:.2%}")
    assert worst <= WORST
    assert across <= 2e-3


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("version", VERSIONS)
def test_levels_agree_with_the_reference(context: moderngl.Context, version: str, way: str) -> None:
    atlas, lookups, level = random_atlas(), random_lookups(), random_levels()
    result = run(context, VERSIONS[version] + WAYS[way], atlas, lookups, BY_LEVEL, level)
    chain = [image.astype(np.float16).astype(float) for image in level_chain(atlas, LAYOUT, LEVELS)]
    expected = sample_level(chain, LAYOUT, lookups.uv.astype(float), lookups.incidence, level.astype(float))
    worst = float(relative_error(result, expected).max())
    print(f"{version} levels, {way}: worst error {worst:.1e}")
    assert worst <= WORST


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("version", VERSIONS)
def test_rays_find_what_the_reference_does(context: moderngl.Context, version: str, way: str) -> None:
    atlas, lookups = random_atlas(), random_lookups()
    result = run(context, VERSIONS[version] + WAYS[way], atlas, lookups, BY_RAY, np.zeros(COUNT))
    error = relative_error(result, hit_answers(atlas, lookups))
    print(f"{version} rays, {way}: worst error {error.max():.1e}, median {np.median(error):.1e}")
    assert error.max() <= WORST


@pytest.mark.parametrize(("defines", "rounding"), [("", 1e-7), (HARDWARE, 5e-4), (HARDWARE + PAGED, 5e-4)])
def test_buckets_do_not_bleed(context: moderngl.Context, defines: str, rounding: float) -> None:
    atlas, lookups = constant_buckets(), random_lookups()
    result = filtered(context, VERSIONS["GLSL 330"] + defines, atlas, lookups, Filter.LINEAR)
    assert worst_error(result, atlas, lookups, Filter.LINEAR)[0] <= rounding


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("mode", [1, 2, BY_LEVEL])
def test_one_hardware_lookup_is_as_good_as_its_weights(
    context: moderngl.Context, mode: int, way: str
) -> None:
    atlas, lookups, level = random_atlas(), random_lookups(), random_levels()
    head = VERSIONS["GLSL 330"] + WAYS[way]
    result = run(context, head + HARDWARE, atlas, lookups, mode, level)
    exact = run(context, head, atlas, lookups, mode, level)
    range_of_colours = float(atlas.max())
    np.testing.assert_allclose(result, exact, rtol=0, atol=range_of_colours * 2 / 256)


BY_DERIVATIVES = """
uniform highp sampler2DArray slices;
uniform sampler2D uvs, incidences;
uniform ivec2 texels;
uniform int n, mode;
out vec4 result;
void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec2 uv = texelFetch(uvs, here, 0).xy;
    if (mode == 1) result = vec4(radtex_level(uv, texels, 4));
#if __VERSION__ >= 400
    else if (mode == 2) result = vec4(textureQueryLod(slices, uv).x);
#endif
    else result = radtex_slices(slices, n, uv, texelFetch(incidences, here, 0).xyz);
}
"""
SLICES, LEVEL, LEVEL_OF_HARDWARE = range(3)
QUERIES = "#version 400\n"
WIDEST = 5  # log2 of the widest pixel, in texels


def uvs_of_quads(axis: bool, whole: bool, seed: int = 4) -> tuple[Floats, Floats]:
    """Texture coordinates (SIDE, SIDE, 2) float32 and the level (SIDE, SIDE) of their derivatives.

    Hardware takes the derivatives from each quad of 2 x 2 pixels: each has its own. `axis`: along the axes
    of the texture, so that every measure of length agrees; `whole`: so that the levels are whole numbers.
    """
    rng = np.random.default_rng(seed)
    count, size = SIDE // 2, np.array([LAYOUT.width, LAYOUT.height])
    level = rng.uniform(-2, WIDEST, (count, count))
    level = np.round(level) if whole else level
    turn = (
        rng.integers(0, 4, (count, count)) * np.pi / 2 if axis else rng.uniform(0, 2 * np.pi, (count, count))
    )
    longer = np.exp2(level)[..., None] * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    shorter = longer[..., ::-1] * [-1, 1] * rng.uniform(0, 0.9, (count, count, 1))
    swapped = rng.random((count, count, 1)) < 0.5
    across, up = np.where(swapped, shorter, longer), np.where(swapped, longer, shorter)
    base = rng.uniform(0, 1, (count, count, 2))
    base[:9] = (np.round(base[:9] * size) + rng.uniform(-2e-3, 2e-3, base[:9].shape)) / size  # seams, borders
    y, x = np.indices((SIDE, SIDE))
    grown = [np.repeat(np.repeat(values, 2, axis=0), 2, axis=1) for values in (base, across, up, level)]
    uv = grown[0] + ((x % 2)[..., None] * grown[1] + (y % 2)[..., None] * grown[2]) / size
    return uv.astype(np.float32), np.maximum(grown[3], 0)


def run_by_derivatives(
    context: moderngl.Context, version: str, chain: list[Floats], uv: Floats, mode: int = SLICES
) -> Floats:
    """The shader's answers, (SIDE², 4) float32."""
    program = compiled(
        context, VERSIONS.get(version, version), SHADER.read_text(encoding="utf-8") + BY_DERIVATIVES
    )
    program["texels"], program["n"] = (LAYOUT.width, LAYOUT.height), LAYOUT.bucket
    program["mode"] = mode
    incidence = random_lookups().incidence.astype(np.float32).reshape(SIDE, SIDE, 3)
    slices = mipmapped(context, chain, moderngl.LINEAR_MIPMAP_LINEAR)
    return drawn(context, program, {"slices": slices, "uvs": uv, "incidences": incidence}, SIDE)


def half_slices() -> list[Floats]:
    return [level.astype(np.float16) for level in mip_chain(to_slices(random_atlas(), LAYOUT))]


def of_slices(chain: list[Floats], uv: Floats, level: Floats) -> Floats:
    exact = [values.astype(float) for values in chain]
    incidence = random_lookups().incidence.astype(np.float32).astype(float)
    return sample_slices(exact, uv.reshape(-1, 2).astype(float), incidence, level.ravel())


@pytest.mark.parametrize("version", VERSIONS)
def test_the_level_is_where_a_texel_is_as_wide_as_a_pixel(context: moderngl.Context, version: str) -> None:
    uv, level = uvs_of_quads(axis=False, whole=False)
    found = run_by_derivatives(context, version, half_slices(), uv, LEVEL)[:, 0]
    np.testing.assert_allclose(found, np.minimum(level, 3).ravel(), atol=1e-4)


@pytest.mark.parametrize("version", VERSIONS)
def test_slices_agree_with_the_reference(context: moderngl.Context, version: str) -> None:
    uv, level = uvs_of_quads(axis=True, whole=True)
    chain = half_slices()
    error = relative_error(run_by_derivatives(context, version, chain, uv), of_slices(chain, uv, level))
    print(f"{version} slices: worst error {error.max():.1e}, median {np.median(error):.1e}")
    assert error.max() <= WORST


def test_between_levels_slices_agree_at_the_level_that_the_hardware_takes(context: moderngl.Context) -> None:
    """Drivers are free to measure how wide a pixel is; this one says what it found."""
    uv, level = uvs_of_quads(axis=True, whole=False)
    chain = half_slices()
    result = run_by_derivatives(context, QUERIES, chain, uv)
    taken = run_by_derivatives(context, QUERIES, chain, uv, mode=LEVEL_OF_HARDWARE)[:, 0]
    off = np.abs(taken - np.clip(level, 0, len(chain) - 1).ravel())
    error = relative_error(result, of_slices(chain, uv, taken.astype(float)))
    print(f"worst error {error.max():.1e}; the hardware's level is off by {off.max():.3f} at most")
    assert error.max() <= WORST
    assert off.max() <= 0.1


LAYERED = """
uniform sampler2D uvs, positions, normals, viewers, tangents, bitangents;
out vec4 result;
void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec2 uv = texelFetch(uvs, here, 0).xy;
    vec3 position = texelFetch(positions, here, 0).xyz;
    vec3 N = texelFetch(normals, here, 0).xyz, V = texelFetch(viewers, here, 0).xyz;
#ifdef RADTEX_THROUGH
    vec3 T = texelFetch(tangents, here, 0).xyz, B = texelFetch(bitangents, here, 0).xyz;
    result = vec4(radtex_layered_through(uv, position, N, V, T, B), 1.0);
#else
    result = vec4(radtex_layered(uv, position, N, V), 1.0);
#endif
}
"""


def code_of(case: Case, cost: LookupCost) -> str:
    """The shader's text, without a version."""
    head = "".join(f"#define {name} {value}\n" for name, value in definitions(case.sidecar, cost).items())
    names = ["radtex_layered", *(["radtex_layered_through"] if case.through else [])]
    return head + "".join((SHADERS / f"{name}.glsl").read_text(encoding="utf-8") for name in names)


def layered_textures(
    context: moderngl.Context, case: Case, layers: Sequence[str]
) -> dict[str, Floats | Texture]:
    """Textures of a case's layers, and of what lookups take, by their samplers' names."""
    textures: dict[str, Floats | Texture] = {
        f"radtex_{layer}_map": mipmapped(
            context,
            case.textures[layer],
            moderngl.LINEAR_MIPMAP_LINEAR if len(case.textures[layer]) > 1 else moderngl.LINEAR,
        )
        for layer in layers
    }
    return textures | {name: values.reshape(SIDE, SIDE, -1) for name, values in case.fields.items()}


def run_layered(context: moderngl.Context, version: str, case: Case, cost: LookupCost) -> Floats:
    """The shader's answers, (N, 3) float32."""
    (found,) = run_frames(context, version, case, cost, 1)
    return found


def run_frames(
    context: moderngl.Context, version: str, case: Case, cost: LookupCost, count: int
) -> list[Floats]:
    """The same for each of so many frames, as RADTEX_FRAME tells them apart."""
    told = "uniform highp int frame;\n#define RADTEX_FRAME frame\n"
    program = compiled(context, VERSIONS[version], told + code_of(case, cost) + LAYERED)
    textures = layered_textures(context, case, layers_read(case.sidecar, cost))
    textures = {name: texture for name, texture in textures.items() if name in program}
    set_values(program, bake_values(case.sidecar, case.stored, cost))

    def with_material(number: int) -> Floats:
        set_values(program, material_values(case.sidecar, number, cost))
        return drawn(context, program, textures, SIDE)

    found = []
    for frame in range(count):
        if "frame" in program:
            program["frame"] = frame
        found.append(case.by_material(with_material))
    return found


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", CASES)
def test_the_layered_layout_agrees(context: moderngl.Context, version: str, name: str) -> None:
    case = case_of(name)
    assert_agrees(f"{version}, {name}", run_layered(context, version, case, FULL), case)


BY_IMAGES = """
uniform sampler2D uvs, positions, normals, viewers, tangents, bitangents, places;
out vec4 result;
void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec3 N = texelFetch(normals, here, 0).xyz, V = texelFetch(viewers, here, 0).xyz;
    vec3 T = texelFetch(tangents, here, 0).xyz, B = texelFetch(bitangents, here, 0).xyz;
    vec2 uv = texelFetch(uvs, here, 0).xy, place = texelFetch(places, here, 0).xy;
    result = vec4(radtex_layered_images(uv, place, texelFetch(positions, here, 0).xyz, T, B, N, V), 1.0);
}
"""


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", ["made up", "clear", "opaque, in ranges", "everything"])
def test_materials_of_images_agree(context: moderngl.Context, version: str, name: str) -> None:
    """Also where light comes through other materials of the bake."""
    of_images = image_case(name)
    case = of_images.case
    names = set(definitions(case.sidecar, FULL)) - {"RADTEX_TINT", "RADTEX_NORMAL"}
    told = {name: value for name, value in definitions(case.sidecar, FULL).items() if name in names}
    told |= {"RADTEX_IMAGES": 1, "RADTEX_NO_DERIVATIVES": 1}
    head = "".join(f"#define {key} {value}\n" for key, value in told.items())
    stems = ("radtex_layered", *(["radtex_layered_through"] if case.through else []))
    text = "".join((SHADERS / f"{stem}.glsl").read_text(encoding="utf-8") for stem in stems)
    program = compiled(context, VERSIONS[version], head + text + BY_IMAGES)
    textures = layered_textures(context, case, layers_read(case.sidecar, FULL))
    textures |= {key: mipmapped(context, [each], moderngl.LINEAR) for key, each in of_images.images.items()}
    textures["places"] = of_images.place.reshape(SIDE, SIDE, 2)
    textures = {key: texture for key, texture in textures.items() if key in program}
    assert "radtex_colour_map" not in textures
    set_values(program, bake_values(case.sidecar, case.stored, FULL))

    def with_material(number: int) -> Floats:
        values = material_values(case.sidecar, number, FULL)
        set_values(program, values | {"radtex_images": of_images.looks[number].rows})
        return drawn(context, program, textures, SIDE)

    assert_agrees(f"{version}, {name}, by images", case.by_material(with_material), of_images)


@pytest.mark.parametrize(
    ("cost", "most"),
    [
        (DEFAULT, 5e-3),
        (replace(FULL, exit_taps=4), 5e-3),
        (replace(DEFAULT, steps=0), 0.02),
        (replace(DEFAULT, second_lobe=False), 0.04),
    ],
)
def test_thrift_changes_little(context: moderngl.Context, cost: LookupCost, most: float) -> None:
    case = case_of("everything")
    wrong = off(run_layered(context, "GLSL 330", case, cost), case.answers())
    print(f"{cost}: mean error {wrong.mean():.1e}, 99 % {np.quantile(wrong, 0.99):.1e}")
    assert wrong.mean() < most


@pytest.mark.parametrize("name", ["made up", "clear", "everything"])
def test_what_chance_draws_is_right_in_the_mean(context: moderngl.Context, name: str) -> None:
    """But where a lobe sees how much of a bucket is free, which is no sum of its cells."""
    case = case_of(name)
    frames = run_frames(context, "GLSL ES 300", case, replace(DEFAULT, temporal=True), 48)
    exact = run_layered(context, "GLSL ES 300", case, DEFAULT)
    one, mean = off(frames[0], exact).mean(), off(np.mean(frames, axis=0), exact).mean()
    print(f"{name}: off by {one:.1e} in a frame, by {mean:.1e} in the mean of {len(frames)}")
    assert (frames[0] != frames[1]).any()
    assert mean < 0.3 * one


def test_a_filter_does_not_follow_ways_that_part(context: moderngl.Context) -> None:
    case = case_of("parted ways")
    found = run_layered(context, "GLSL 330", case, replace(FULL, exit_taps=4))
    assert off(found, case.answers()).mean() > 0.03


@pytest.mark.parametrize("version", VERSIONS)
def test_any_two_parts_of_a_bake_compile_together(context: moderngl.Context, version: str) -> None:
    names = ("radtex_layered", "radtex_layered_through")
    layered, through = ((SHADERS / f"{name}.glsl").read_text(encoding="utf-8") for name in names)
    for defines in variants():
        by_images, clear = "RADTEX_IMAGES" in defines, "RADTEX_THROUGH" in defines
        code = defines + layered + (through if clear and not by_images else "")
        compiled(context, VERSIONS[version], code + (BY_IMAGES if by_images else LAYERED)).release()
    print(f"{len(variants())} variants")


@pytest.mark.parametrize(
    ("name", "counts"),
    [
        ("everything", (23, 20, 19, 17, 16)),
        ("brushed", (87, 68, 51, 41, 64)),  # eight lamps that layers may hide, for each lobe
        ("clear", (19, 16, 15, 13, 12)),
        ("made up", (18, 15, 14, 12, 11)),
        ("things alone", (16, 13, 12, 11, 9)),
        ("bare", (8, 7, 7, 6, 5)),
        ("matt", (6, 5, 5, 5, 3)),
        ("one lobe", (15, 12, 11, 12, 8)),
    ],
)
def test_fetches_are_those_of_the_parts(name: str, counts: tuple[int, ...]) -> None:
    thrifty = (replace(DEFAULT, second_lobe=False), replace(DEFAULT, temporal=True))
    costs = (FULL, DEFAULT, replace(DEFAULT, steps=0), *thrifty)
    assert tuple(fetched(case_of(name), cost, "radtex_layered") for cost in costs) == counts


def test_light_that_comes_through_costs_more() -> None:
    case = case_of("everything")
    more = {
        taps: fetched(case, replace(DEFAULT, exit_taps=taps), "radtex_layered_through")
        - fetched(case, DEFAULT, "radtex_layered")
        for taps in (16, 4)
    }
    # exits, colour, the rest, alpha once more, the world, the plane, things and their distance
    assert more == {16: 32 + 1 + 3 + 1 + 4, 4: 8 + 1 + 3 + 1 + 4}


def fetched(case: Case, cost: LookupCost, function: str) -> int:
    return fetches(code_of(case, cost), definitions(case.sidecar, cost), function)


SHADOW_LAYERS = "#define RADTEX_SHADOW_LAYERS\n"
SHADOW = """
#ifdef RADTEX_SHADOW_LAYERS
uniform highp usampler2DArray bits;
#else
uniform highp usampler2D bits;
#endif
uniform sampler2D uvs, normals, tangents, viewers;
uniform ivec2 texels;
uniform int n, mode, count;
uniform float angle;
uniform vec3 corner, across, up;
out vec4 result;
void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 normal = texelFetch(normals, at, 0);
    vec3 tangent = texelFetch(tangents, at, 0).xyz, light = texelFetch(viewers, at, 0).xyz;
    mat3 frame = radtex_frame(normal.xyz, tangent, normal.w);
    RadtexShadow here = radtex_shadow(bits, texels, texelFetch(uvs, at, 0).xy);
    float value = mode == 0 ? radtex_visible(RADTEX_HERE, n, normalize(light) * frame)
        : mode == 1 ? radtex_sun(RADTEX_HERE, n, frame, light, angle, count)
        : radtex_rectangle(RADTEX_HERE, n, frame, light, corner, across, up, count);
    result = vec4(value);
}
"""


def run_shadow(
    context: moderngl.Context, head: str, words: Words, layout: AtlasLayout, lookups: Lookups, mode: int
) -> Floats:
    """The shader's answers, (K,)."""
    source = "".join(
        (SHADERS / name).read_text(encoding="utf-8") for name in ("radtex.glsl", "radtex_shadow.glsl")
    )
    program = compiled(context, head + "#define RADTEX_NO_DERIVATIVES\n", source + SHADOW)
    values = {
        "texels": (layout.width, layout.height),
        "n": layout.bucket,
        "mode": mode,
        "count": POINTS,
        "angle": ANGLE,
        "corner": CORNER,
        "across": ACROSS,
        "up": UP,
    }
    for name, value in values.items():
        program[name] = value
    layers, size = stacked(words), (layout.width, layout.height)
    texture: moderngl.Texture | moderngl.TextureArray
    if SHADOW_LAYERS in head:
        texture = context.texture_array((*size, len(layers)), 2, layers.tobytes(), alignment=1, dtype="u4")
    else:
        texture = context.texture(size, 2, layers.tobytes(), alignment=1, dtype="u4")
    texture.filter = (moderngl.NEAREST, moderngl.NEAREST)
    signed = np.concatenate([lookups.normal, lookups.sign[:, None]], axis=1)
    inputs = {"uvs": lookups.uv, "normals": signed, "tangents": lookups.tangent, "viewers": lookups.viewer}
    fields = {name: field.reshape(SIDE, SIDE, -1) for name, field in inputs.items()}
    fields["uvs"] = np.concatenate([fields["uvs"], np.zeros((SIDE, SIDE, 1), np.float32)], axis=2)
    return drawn(context, program, {"bits": texture, **fields}, SIDE)[:, 0]


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("mode", [ONE, SUN, RECTANGLE])
@pytest.mark.parametrize(("cells", "define"), [(5, ""), (8, ""), (8, SHADOW_LAYERS), (12, SHADOW_LAYERS)])
def test_shadows_agree_with_the_reference(
    context: moderngl.Context, version: str, mode: int, cells: int, define: str
) -> None:
    layout, lookups = AtlasLayout(13, 7, cells), random_lookups()
    words = random_words(layout)
    found = run_shadow(context, VERSIONS[version] + define, words, layout, lookups, mode)
    wanted = expected(words, layout, lookups, mode, bool(define))
    check(found, wanted, mode, bool(define), f"{version}, {cells} cells")


TRANSFER = """
#ifdef RADTEX_PAGES
uniform sampler2DArray atlas;
uniform ivec4 pages;
#else
uniform sampler2D atlas;
#endif
uniform sampler2D uvs, normals, tangents, viewers, lights;
uniform ivec2 texels;
uniform int n, mode, views;
out vec4 result;
void main() {
    ivec2 here = ivec2(gl_FragCoord.xy);
    vec4 normal = texelFetch(normals, here, 0);
    vec4 tangent = vec4(texelFetch(tangents, here, 0).xyz, normal.w);
    vec3 light = texelFetch(lights, here, 0).xyz, E = vec3(2.0, 1.0, 0.5);
    vec2 uv = texelFetch(uvs, here, 0).xy;
    vec3 L = radtex_incidence(light, normal.xyz, tangent.xyz, tangent.w);
    vec3 I = radtex_incidence(texelFetch(viewers, here, 0).xyz, normal.xyz, tangent.xyz, tangent.w);
    result = vec4(1.0);
    if (mode == 0) result = radtex_transfer(RADTEX_PASSED, texels, n, uv, L);
    if (mode == 1) result.rgb = radtex_sun(RADTEX_PASSED, texels, n, uv, normal.xyz, tangent, light, E);
    if (mode == 2)
        result.rgb = radtex_point_light(RADTEX_PASSED, texels, n, uv, normal.xyz, tangent, light, E);
    if (mode == 3) result = radtex_transfer_around(RADTEX_PASSED, texels, views, n, uv, I, L);
}
"""


def run_transfer(context: moderngl.Context, head: str, question: Question, paged: bool = False) -> Floats:
    """The shader's answers, (K, 4) float32."""
    source = "".join((SHADERS / name).read_text("utf-8") for name in ("radtex.glsl", "radtex_transfer.glsl"))
    program = compiled(context, head, (PAGED if paged else "") + source + TRANSFER)
    program["texels"], program["n"], program["mode"] = (
        (LAYOUT.width, LAYOUT.height),
        LAYOUT.bucket,
        question.way,
    )
    program["views"] = question.views
    lookups = question.lookups
    inputs = {
        "uvs": lookups.uv,
        "normals": np.concatenate([lookups.normal, lookups.sign[:, None]], axis=1),
        "tangents": lookups.tangent,
        "viewers": lookups.viewer,
        "lights": question.light,
    }
    fields = {name: values.reshape(SIDE, SIDE, -1).astype(np.float32) for name, values in inputs.items()}
    levels = [question.atlas]
    if paged:
        stored = with_views(LAYOUT, question.views)
        pages = fitting_pages(stored, 60, 1)
        program["pages"] = astuple(pages)
        levels = page_chain(question.atlas, stored, pages, 1)
    return drawn(context, program, {"atlas": mipmapped(context, levels, moderngl.NEAREST), **fields}, SIDE)


@pytest.mark.parametrize("paged", [False, True])
@pytest.mark.parametrize("version", VERSIONS)
def test_transfer_agrees_with_the_reference(context: moderngl.Context, version: str, paged: bool) -> None:
    for question in questions():
        result = run_transfer(context, VERSIONS[version], question, paged)
        worst = float(relative_error(result, question.answers).max())
        print(f"{version}, {question.way.name}: worst error of {COUNT} lookups {worst:.1e}")
        assert worst <= transfer_lookups.WORST


def test_cells_do_not_bleed_into_other_texels(context: moderngl.Context) -> None:
    """Texels that are constants stay so at their middles, from every direction."""
    random, lookups = np.random.default_rng(4), random_lookups()
    value = random.random((LAYOUT.height, LAYOUT.width, 4)).astype(np.float16).astype(float)
    atlas = np.kron(value.transpose(2, 0, 1), np.ones((LAYOUT.bucket, LAYOUT.bucket))).transpose(1, 2, 0)
    i, j = random.integers(LAYOUT.width, size=COUNT), random.integers(LAYOUT.height, size=COUNT)
    lookups.uv[:] = np.stack([(i + 0.5) / LAYOUT.width, (j + 0.5) / LAYOUT.height], axis=1)
    asked = Question(Way.LOOKUP, atlas.astype(np.float16), lookups, random_lights())
    result = run_transfer(context, VERSIONS["GLSL 330"], asked)
    np.testing.assert_allclose(result, value[j, i], atol=1e-5)
    alike = LAYOUT.to_buckets(asked.atlas.astype(float)).repeat(VIEWS, axis=0).repeat(VIEWS, axis=1)
    atlas = with_views(LAYOUT, VIEWS).from_buckets(alike).astype(np.float16)
    result = run_transfer(context, VERSIONS["GLSL 330"], replace(asked, way=Way.AROUND, atlas=atlas))
    np.testing.assert_allclose(result, value[j, i], atol=1e-5)
