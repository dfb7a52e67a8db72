# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Estimated and true times of bakes by the panel's workers: `python -m tests.bench.estimates`.

Each scene is estimated without history, measured by **Estimate Time**, baked, and then baked with more
texels, which is estimated from the first bake alone. True times are from the button to the last job's end. An
estimate and its bake follow one another at once, as other work on the machine slows both; the load says how
much. With `--cpu`, probes and bakes run in this process, and all times are CPU seconds of all cores, in which
other work matters less: that tells how well a probe stands for its bake.
"""

from __future__ import annotations

import argparse
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import monotonic, sleep

if __name__ == "__main__":  # before Blender starts: no user's history
    _HOME = tempfile.TemporaryDirectory(prefix="radtex-estimates-")
    os.environ["BLENDER_USER_RESOURCES"] = _HOME.name

import bpy

from radtex_addon.bake import progress
from radtex_addon.core.sampler import Filter
from radtex_addon.job import bake_object
from radtex_addon.job.bake_plan import plan_bakes
from radtex_addon.job.probes import probe_object
from radtex_addon.scene.demo import OBJECT, build_demo_scene
from radtex_addon.settings.estimate import START, estimate
from radtex_addon.ui.jobs import bake_times, estimates, jobs
from radtex_addon.ui.panel.layouts import chosen_layouts
from radtex_addon.ui.settings.request import request_of, spec_of, values_of
from tests.blender import stage
from tests.blender.ui_stage import context, preferences, registered, settings

_LARGER = 1.4  # times as many texels along a side for the second bake


def head() -> tuple[str, ...]:
    """The demo's gold head on its floor, in the layered layout."""
    build_demo_scene()
    settings().texels, settings().samples, settings().atlas_layout = 96, 8, "layered"
    return (OBJECT,)


def glass() -> tuple[str, ...]:
    """A thick glass torus over the demo's floor."""
    build_demo_scene()
    bpy.data.objects[OBJECT].hide_render = True
    bpy.ops.mesh.primitive_torus_add(major_segments=64, minor_segments=32)
    context.object.name = "Torus"
    made = stage.material("Glass", "ShaderNodeBsdfGlass", Roughness=0.05)
    context.object.data.materials.append(made)
    settings().texels, settings().samples, settings().atlas_layout = 64, 8, "layered"
    return ("Torus",)


def five() -> tuple[str, ...]:
    """Five objects of different materials with modifiers, in layout buckets."""
    build_demo_scene()
    adds = (
        bpy.ops.mesh.primitive_cube_add,
        bpy.ops.mesh.primitive_ico_sphere_add,
        bpy.ops.mesh.primitive_uv_sphere_add,
        bpy.ops.mesh.primitive_monkey_add,
        bpy.ops.mesh.primitive_torus_add,
    )
    modifiers = ("BEVEL", "SUBSURF", "CAST", "SUBSURF", "SOLIDIFY")
    shaders = ("Diffuse", "Glossy", "Glossy", "Glass", "Diffuse")
    names = []
    for number, (add, modifier, shader) in enumerate(zip(adds, modifiers, shaders, strict=True)):
        add(location=(number * 2.5 - 5, 4, 0.5))
        context.object.name = f"Thing {number}"
        context.object.modifiers.new("Modifier", modifier)
        context.object.data.materials.append(stage.material(f"Thing {number}", f"ShaderNodeBsdf{shader}"))
        names.append(context.object.name)
    settings().texels, settings().samples, settings().atlas_layout = 48, 8, "buckets"
    return tuple(names)


SCENES: dict[str, Callable[[], tuple[str, ...]]] = {"head": head, "glass": glass, "five": five}


def expected(names: tuple[str, ...]) -> tuple[float, str]:
    """The panel's figure for the current settings, and what it rests on."""
    values = values_of(settings())
    chosen = chosen_layouts(context.scene, names, values, spec_of(values))
    known = estimates.seconds_known(context.scene, [(name, choice.spec) for name, choice in chosen])
    assert known is not None
    return known.seconds, str(known.basis)


def measure(names: tuple[str, ...]) -> float:
    """Press Estimate Time; returns how long it takes."""
    values, since = values_of(settings()), monotonic()
    chosen = chosen_layouts(context.scene, names, values, spec_of(values))
    estimates.ask(context.scene, [(name, choice.spec) for name, choice in chosen])
    while estimates.advance():
        sleep(0.1)
    assert estimates.message() is None, estimates.message()
    return monotonic() - since


def bake(names: tuple[str, ...]) -> float:
    """Press Bake, and wait for the end of all jobs; returns how long it takes."""
    since = monotonic()
    jobs.submit(context.scene, [plan_bakes(context.scene, request_of(values_of(settings()), names))])
    while jobs.advance():
        sleep(0.1)
    seconds = monotonic() - since
    for job in jobs.snapshot():
        assert job.state == "done", job.message
        print(f"  {job.object}: {job.facts['seconds']}", flush=True)
    jobs.forget_ended()
    return seconds


def cpu_seconds() -> float:
    """CPU seconds of this process and its ended children, of all cores."""
    return sum(os.times()[:4])


def cpu_rows(scene: str, folder: Path) -> list[str]:
    """Probe and bake each object of a scene in this process; returns the lines of the table."""
    found = []
    names = SCENES[scene]()
    for name in names:
        spec = spec_of(values_of(settings()))
        since = cpu_seconds()
        probe = probe_object(context.scene, name, spec)
        took = cpu_seconds() - since
        expected = estimate(
            probe.work(spec, preview=True), "", name, probe.measurements("", name, spec)
        ).seconds
        true = bake_object(context.scene, name, spec, folder, preview=Filter.QUADRILINEAR).seconds
        print(f"  {name}: expected { {stage: round(value, 2) for stage, value in expected.items()} }")
        print(
            f"  {name}: true { {str(stage): round(value, 2) for stage, value in true.items()} }", flush=True
        )
        total = sum(value for stage, value in expected.items() if stage != START)
        whole = sum(true.values())
        found.append(
            f"| {scene}, {name} | a probe | {took:.0f} | {total:.0f} | {whole:.0f} | {total / whole:.2f} | |"
        )
    print("\n".join(found), flush=True)
    return found


def rows(scene: str, folder: Path) -> list[str]:
    """Estimate and bake a scene twice; returns the lines of the table."""
    bake_times.history_file().unlink(missing_ok=True)
    names = SCENES[scene]()
    settings().directory, settings().preview = str(folder / scene), True
    before, _ = expected(names)
    took = measure(names)
    measured, basis = expected(names)
    load, true = os.getloadavg()[0], bake(names)
    told = f"{load:.1f} to {os.getloadavg()[0]:.1f}"
    found = [f"| {scene} | nothing | 0 | {before:.0f} | {true:.0f} | {before / true:.2f} | {told} |"]
    ratio = measured / true
    found.append(f"| {scene} | {basis} | {took:.0f} | {measured:.0f} | {true:.0f} | {ratio:.2f} | {told} |")
    settings().texels = round(_LARGER * settings().texels)
    settings().overwrite = True
    estimates.unregister()  # forgets the probe: the first bake alone must do
    after, basis = expected(names)
    load, true = os.getloadavg()[0], bake(names)
    told = f"{load:.1f} to {os.getloadavg()[0]:.1f}"
    found.append(
        f"| {scene}, larger | {basis} | 0 | {after:.0f} | {true:.0f} | {after / true:.2f} | {told} |"
    )
    print("\n".join(found), flush=True)
    return found


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scene", choices=SCENES, action="append")
    parser.add_argument("--cpu", action="store_true")
    options = parser.parse_args()
    if options.cpu:
        progress.perf_counter = cpu_seconds  # type: ignore[attr-defined]
    with tempfile.TemporaryDirectory() as temporary:
        found = []
        for scene in options.scene or SCENES:
            bpy.ops.wm.read_factory_settings(use_empty=True)
            with registered():
                preferences().cache_folder = str(Path(temporary) / "cache")
                found += (cpu_rows if options.cpu else rows)(scene, Path(temporary))
    print("\n| scene | rests on | took, s | estimated, s | true, s | estimated / true | load |")
    print("|---|---|---|---|---|---|---|")
    print("\n".join(found))


if __name__ == "__main__":
    main()
