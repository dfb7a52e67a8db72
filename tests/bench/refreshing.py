# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Could a layered bake be refreshed? What it would save and cost: `python -m tests.bench.refreshing`.

    python -m tests.bench.refreshing --scenes floor,wall,head --texels 64

Each scene is baked by the defaults, something in it is moved or recoloured, and it is baked again. The first
table has the seconds of processors of the second bake, by part. The second has decibels, three views path
traced after the change: of the bake before the change, of the whole bake after it, and of mixtures, which
have the light of the first bake in most texels and that of the second in those that count as changed. These
are found as `--refresh` of buckets finds them, by a quarter of the paths of light and the light that the
first bake shows along them; or they are the tenth, or three tenths, of which the two bakes show most
different light, which no refresh could know. Pictures of the surroundings are new, or, in the
last row, kept.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from math import isqrt, pi
from pathlib import Path
from time import process_time
from typing import Any, cast
from unittest import mock

import bpy
import numpy as np

from radtex_addon.bake.changes import changed_texels
from radtex_addon.bake.light_samples import LightSamples, straight_through
from radtex_addon.bake.plan import CapturePlan
from radtex_addon.bake.progress import Progress, Stage, StageParts, finished, relayed
from radtex_addon.core.arrays import Bools, Floats
from radtex_addon.core.blas import one_blas_thread
from radtex_addon.core.fragments import Fragments
from radtex_addon.formats.sidecar_file import opened
from radtex_addon.forms.layered import bake as layered
from radtex_addon.forms.layered.files.layered_files import read_layered, write_layered
from radtex_addon.forms.layered.fit.fitting import fit_layered
from radtex_addon.forms.layered.fit.known import Known
from radtex_addon.forms.layered.lookup.atlas import LayeredAtlas, sample_layered
from radtex_addon.forms.layered.samples import LayeredSamples
from radtex_addon.job import bake_steps
from radtex_addon.prepare.unwrapping import unwrap_options
from radtex_addon.report.finished_bake import read_bake
from radtex_addon.report.gbuffer import BakedSurface
from radtex_addon.report.judging import judge, mean_psnr
from radtex_addon.report.mesh import find_mesh
from radtex_addon.report.views import TracedView, make_views, reference_of
from radtex_addon.scene.demo import build_demo_scene
from radtex_addon.scene.objects import find_object
from radtex_addon.scene.scratch import scratch_scene
from radtex_addon.scene.units import metres_per_unit
from radtex_addon.settings.spec import BakeSpec, Layout
from tests.blender import stage

from .fidelity.choice import names_of

VIEWS, PIXELS, SAMPLES = 3, 192, 64  # of the path-traced pictures
LIGHT = ("light", "more light")  # parts of a capture whose time is the unchanged texels' …
LOCAL = (
    "maps",
    *LIGHT,
    "own",
    "misled",
    str(Stage.FIT),
)  # … and all that could be, if all of it were written anew
SHARE = 0.1  # of the texels that changed, of which the times tell
_COARSE = 2  # samples along a side of a probe's cell
_ROWS = 256  # texels that are looked up at once
_SEEDS = (0, 7, 3)  # of the bake before the change, of the same again, and of the one after it
context: Any = bpy.context  # to the stubs, every pointer may be None


@dataclass(frozen=True)
class Scene:
    """A scene, the object in it that is baked, and what is changed."""

    build: Callable[[], object]
    subject: str
    change: Callable[[], None]


def floor() -> None:
    """A large floor under a lamp; a post and a crate stand on it."""
    _start()
    stage.world((0.2, 0.3, 0.4))
    _add("plane", "Floor", (0.6, 0.5, 0.4), 0.5, size=6)
    bpy.ops.object.light_add(type="AREA", location=(2, 0, 3))
    context.object.data.size, context.object.data.energy = 1, 150
    _add("cylinder", "Post", (0.8, 0.2, 0.1), 0.4, radius=0.2, depth=0.8, location=(-1.8, -1.8, 0.41))
    _add("cube", "Crate", (0.2, 0.5, 0.2), 0.6, size=0.7, location=(1.5, 1.5, 0.36))


def wall() -> None:
    """A polished wall behind a box and a ball, under a sky."""
    _start()
    stage.hdri(stage.world())
    _add("plane", "Wall", (0.7, 0.7, 0.68), 0.25, size=4, rotation=(pi / 2, 0, 0), location=(0, 0, 2))
    _add("plane", "Ground", (0.4, 0.4, 0.4), 0.7, size=8)
    _add("cube", "Box", (0.8, 0.1, 0.1), 0.5, size=0.7, location=(-1.4, -0.6, 0.36))
    _add("uv_sphere", "Ball", (0.1, 0.3, 0.8), 0.2, radius=0.35, location=(1.3, -0.7, 0.36))


def _start() -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    context.scene.render.engine = "CYCLES"


def _add(
    shape: str, name: str, colour: tuple[float, float, float], roughness: float, **options: object
) -> None:
    getattr(bpy.ops.mesh, f"primitive_{shape}_add")(**options)
    context.object.name = name
    inputs = {"Base_Color": (*colour, 1), "Roughness": roughness}
    context.object.data.materials.append(stage.material(name, "ShaderNodeBsdfPrincipled", **inputs))


def _moved(name: str, along: float) -> Callable[[], None]:
    def move() -> None:
        bpy.data.objects[name].location.x += along

    return move


def _green_box() -> None:
    tree = cast(Any, bpy.data.materials["Box"].node_tree)
    tree.nodes[0].inputs["Base Color"].default_value = (0.1, 0.7, 0.2, 1)


SCENES = {
    "floor": Scene(floor, "Floor", _moved("Post", 0.45)),
    "wall": Scene(wall, "Wall", _green_box),
    "head": Scene(build_demo_scene, "Suzanne", _moved("Sphere", 0.5)),
}


@dataclass(frozen=True, eq=False)
class Baked:
    """A bake: what was captured, its atlas and sidecar, and seconds of processors by part."""

    capture: LayeredSamples
    atlas: LayeredAtlas
    sidecar: Path
    seconds: Mapping[str, float]


def bake(name: str, spec: BakeSpec, folder: Path) -> Baked:
    """Bake an object of the open file."""
    captures: list[LayeredSamples] = []
    spent: dict[str, float] = {}
    part, since = "prepare", process_time()

    def enter(following: str) -> None:
        nonlocal part, since
        now = process_time()
        spent[part] = spent.get(part, 0.0) + now - since
        part, since = following, now

    def fit(capture: LayeredSamples, **options: Any) -> Generator[Progress, None, LayeredAtlas]:
        captures.append(capture)
        return fit_layered(capture, **options)

    def told(step: Any) -> None:
        if step.stage not in (Stage.CAPTURE, Stage.SURROUNDINGS):  # whose parts tell more
            enter(str(step.stage))

    at = StageParts.at

    def named(parts: StageParts, following: str, share: float = 0.0) -> Progress:
        enter(following)
        return at(parts, following, share)

    with mock.patch.object(StageParts, "at", named), mock.patch.object(layered, "fit_layered", fit):
        made = finished(relayed(bake_steps(context.scene, name, spec, folder), told))
    enter("end")
    sidecar = made.files.sidecar
    return Baked(captures[0], read_layered(sidecar)[0], sidecar, spent)


def shown_by(atlas: LayeredAtlas, capture: LayeredSamples) -> Floats:
    """The light of an atlas at a capture's texels, along its paths of light: (K, S, 3)."""
    light, plan = capture.light, capture.light.plan
    count, paths = light.seen.shape
    j, i = np.divmod(plan.texel, plan.layout.width)
    uv = np.stack([(i + 0.5) / plan.layout.width, (j + 0.5) / plan.layout.height], axis=1)
    axes = [axis.reshape(-1, 3)[:count] for axis in (plan.normals, plan.points, plan.tangent, plan.bitangent)]
    found = np.zeros((count, paths, 3), dtype=np.float32)
    for first in range(0, count, _ROWS):
        some = slice(first, min(first + _ROWS, count))
        viewer = -straight_through(plan, light.square[some], some)
        normal, place, tangent, bitangent = (np.repeat(axis[some], paths, axis=0) for axis in axes)
        at = Fragments(
            np.repeat(uv[some], paths, axis=0), normal, viewer.reshape(-1, 3), place,
            np.repeat(capture.material[some], paths), tangent, bitangent,
        )  # fmt: skip
        found[some] = sample_layered(atlas, at.single()).reshape(viewer.shape)
    return found


def changed(before: Baked, after: LayeredSamples) -> Bools:
    """Which texels of a capture show other light than the bake before, (K,), by a quarter of its paths."""
    light = after.light
    known = np.isin(light.plan.texel, before.capture.light.plan.texel)
    drawn = np.random.default_rng(5).integers(_COARSE**2, size=_cells(light.diffuse).shape[:2])
    sides = [_drawn(_seen(light, values), drawn) for values in (_all(light), shown_by(before.atlas, after))]
    cells = isqrt(drawn.shape[1])
    plan = replace(light.plan, layout=replace(light.plan.layout, bucket=cells))
    probe, shown = (side.reshape(len(side), cells, cells, 3) for side in sides)
    return cast(Bools, changed_texels(plan, probe, shown) | ~known)


def _all(light: LightSamples) -> Floats:
    return np.sum([light.diffuse, light.mirrored, light.through], axis=0, dtype=np.float32)


def _seen(light: LightSamples, values: Floats) -> Floats:
    return cast(Floats, np.where(light.seen[..., None], values, 0))


def _cells(values: Floats) -> Floats:
    """Samples (K, S, 3) of a square of directions, by the cells of a coarser one: (K, S / 4, 4, 3)."""
    side = isqrt(values.shape[1]) // _COARSE
    tiles = values.reshape(-1, side, _COARSE, side, _COARSE, 3).swapaxes(2, 3)
    return tiles.reshape(len(values), side * side, _COARSE**2, 3)


def _drawn(values: Floats, drawn: Any) -> Floats:
    return cast(Floats, np.take_along_axis(_cells(values), drawn[..., None, None], axis=2)[:, :, 0])


def most_different(one: Floats, other: Floats, share: float) -> Bools:
    """The `share` of the texels (K,) of which two lights (K, S, 3) are most different as displayed."""
    shown = [np.clip(light, 0, 1) ** (1 / 2.2) for light in (one, other)]
    different = ((shown[0] - shown[1]) ** 2).mean(axis=(1, 2))
    found: Bools = np.zeros(len(different), dtype=bool)
    found[np.argsort(-different)[: round(share * len(different))]] = True
    return found


def mixed(
    base: LayeredAtlas, kept: LayeredAtlas, new: LayeredAtlas, plan: CapturePlan, some: Bools
) -> LayeredAtlas:
    """The `base` with the light that is `kept`, and with the `new` light in `some` of the texels (K,)."""
    texels = plan.placed(some, gutter=True)
    buckets = kept.own.shape[:2]
    fine = [whole // part for whole, part in zip(texels.shape, buckets, strict=True)]
    inside = texels[: buckets[0] * fine[0], : buckets[1] * fine[1]]
    coarse = inside.reshape(buckets[0], fine[0], buckets[1], fine[1]).any(axis=(1, 3))
    return replace(
        base,
        irradiance=np.where(texels[..., None], new.irradiance, kept.irradiance),
        own=np.where(coarse[..., None, None, None], new.own, kept.own),
        rest=np.where(coarse[..., None, None, None], new.rest, kept.rest),
    )


def atlases(before: Baked, after: Baked) -> dict[str, tuple[LayeredAtlas, float | None]]:
    """The atlases to judge, by their titles, with the share of their texels that has new light."""
    capture = replace(after.capture, alone=None)  # materials stay: their lobes are known
    known, plan = Known(before.atlas, 1.0), capture.light.plan
    with one_blas_thread():
        new = finished(fit_layered(capture, known=known))
        old_pictures = finished(fit_layered(replace(capture, around=before.atlas.around), known=known))
    new = replace(new, looks=before.atlas.looks)
    lights = shown_by(before.atlas, capture), shown_by(new, capture)
    some = {
        "those that a probe finds": changed(before, after.capture),
        "the tenth that differs most": most_different(*lights, 0.1),
        "the three tenths that differ most": most_different(*lights, 0.3),
    }
    found: dict[str, tuple[LayeredAtlas, float | None]] = {
        "the bake before": (before.atlas, 0.0),
        "the whole bake": (after.atlas, 1.0),
    }
    for title, which in some.items():
        found[title] = mixed(new, before.atlas, new, plan, which), float(which.mean())
    kept = mixed(before.atlas, before.atlas, old_pictures, plan, which)
    found[f"{title}, pictures kept"] = kept, float(which.mean())
    return found


@contextmanager
def _views(after: Baked) -> Generator[tuple[BakedSurface, list[TracedView]], None, None]:
    """The surface of a bake, and path-traced views of it in the open file."""
    finished_bake = read_bake(opened(after.sidecar))
    facts = finished_bake.sidecar
    with tempfile.TemporaryDirectory() as folder, scratch_scene(context.scene) as scratch:
        original = find_object(scratch, facts.surfaces[0])
        options = unwrap_options(finished_bake.spec("cpu"), metres_per_unit(scratch))
        surface = finished(find_mesh(scratch, original, finished_bake, options)).surface
        with reference_of(scratch, original, facts) as shown:
            yield surface, finished(make_views(shown, surface, VIEWS, PIXELS, SAMPLES, Path(folder)))


def decibels(after: Baked, found: Mapping[str, tuple[LayeredAtlas, float | None]]) -> dict[str, list[float]]:
    """The mean PSNR of each atlas, and that of each view."""
    facts = replace(read_layered(after.sidecar)[1].bake, layers=())
    judged = {}
    with _views(after) as (surface, views), tempfile.TemporaryDirectory() as folder:
        for number, (title, (atlas, _)) in enumerate(found.items()):
            sidecar = Path(folder, str(number), after.sidecar.name)
            sidecar.parent.mkdir()
            write_layered(sidecar, atlas, facts)
            each = judge(read_bake(opened(sidecar)), surface, views)
            judged[title] = [mean_psnr(each), *(one.figures.psnr for one in each)]
    return judged


def main() -> None:
    """Bake, change, bake again, print."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.refreshing",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--scenes", type=names_of(list(SCENES)), default=list(SCENES))
    parser.add_argument("--texels", type=int, default=64)
    parser.add_argument("--times", action="store_true", help="the first table alone")
    options = parser.parse_args()
    spec = BakeSpec(layout=Layout.LAYERED, texels=options.texels, device="cpu")
    for name in options.scenes:
        _measure(name, SCENES[name], spec, options.times)


def _measure(name: str, scene: Scene, spec: BakeSpec, times: bool) -> None:
    scene.build()
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        before, same = (
            bake(scene.subject, replace(spec, seed=seed), folder / str(seed)) for seed in _SEEDS[:2]
        )
        if times:
            _print_times(name, spec, same)
            return
        unchanged = changed(before, same.capture).mean()
        scene.change()
        context.view_layer.update()
        after = bake(scene.subject, replace(spec, seed=_SEEDS[2]), folder / str(_SEEDS[2]))
        _print_times(name, spec, after)
        found = atlases(before, after)
        print(f"\n{name}: where nothing has changed, a probe finds {unchanged:.1%} of the texels changed\n")
        print(f"| {name}, {spec.texels} texels: new light in | texels | mean, dB | less | views, dB |")
        print("|---|---|---|---|---|")
        judged = decibels(after, found)
        whole = judged["the whole bake"][0]
        for title, values in judged.items():
            views = " ".join(f"{value:.1f}" for value in values[1:])
            print(
                f"| {title} | {found[title][1]:.1%} | {values[0]:.2f} | {whole - values[0]:.2f} | {views} |"
            )
        print(flush=True)


def _print_times(name: str, spec: BakeSpec, of: Baked) -> None:
    """Print what parts of a bake took, and what a refresh could save with a tenth of the texels changed."""
    total = sum(of.seconds.values())

    def saved(parts: tuple[str, ...]) -> float:
        return (of.seconds["ends"] + (1 - SHARE) * sum(of.seconds[part] for part in parts)) / total

    print(f"\n{name}, {spec.texels} texels: {total:.1f} s of processors", flush=True)
    print(
        ", ".join(
            f"{part} {spent / total:.0%}" for part, spent in of.seconds.items() if spent > 0.005 * total
        )
    )
    print(
        f"new light for a tenth of the texels saves {saved(LIGHT):.0%}, "
        f"if all that could be is theirs alone {saved(LOCAL):.0%}"
    )


if __name__ == "__main__":
    main()
