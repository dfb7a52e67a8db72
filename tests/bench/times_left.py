# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How true the time left is while the panel's workers bake: `python -m tests.bench.times_left`.

Twelve objects of five kinds are baked one after another, first as idle as the machine is, and then beside a
loop that keeps a core busy. RadTex begins without earlier bakes, and learns from each. `--record FILE` keeps
what the workers reported and when, `--replay FILE` tells the times of such a recording anew, in seconds.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from statistics import median
from time import monotonic, sleep
from typing import Any

if __name__ == "__main__":  # before Blender starts: no user's history
    _HOME = tempfile.TemporaryDirectory(prefix="radtex-times-")
    os.environ["BLENDER_USER_RESOURCES"] = _HOME.name

import bpy

from radtex_addon.job.bake_plan import plan_bakes
from radtex_addon.scene.demo import build_demo_scene
from radtex_addon.settings.estimate import START, BakeWork, Measurement, estimate
from radtex_addon.settings.time_left import Course, Left, time_left, told_range
from radtex_addon.ui.jobs import estimates, jobs
from radtex_addon.ui.panel.layouts import chosen_layouts
from radtex_addon.ui.settings.request import request_of, spec_of, values_of
from radtex_addon.worker.process import Worker
from tests.blender import stage
from tests.blender.ui_stage import context, preferences, registered, settings

SHARES = (0.1, 0.25, 0.5, 0.75)  # of the true time
_ADD: dict[str, Callable[..., object]] = {
    "cube": bpy.ops.mesh.primitive_cube_add,
    "ball": bpy.ops.mesh.primitive_uv_sphere_add,
    "monkey": bpy.ops.mesh.primitive_monkey_add,
    "torus": bpy.ops.mesh.primitive_torus_add,
}
_SETTINGS: dict[str, dict[str, Any]] = {
    "matt": {"kind": "radiance", "atlas_layout": "layered", "texels": 48, "samples": 8},
    "metal": {"kind": "radiance", "atlas_layout": "layered", "texels": 64, "samples": 8},
    "glass": {"kind": "radiance", "atlas_layout": "layered", "texels": 40, "samples": 8},
    "buckets": {"kind": "radiance", "atlas_layout": "buckets", "texels": 56, "samples": 32, "bucket": 8},
    "occlusion": {"kind": "ao", "texels": 128, "samples": 64},
}
_SHADERS = {
    "matt": "Diffuse",
    "metal": "Glossy",
    "glass": "Glass",
    "buckets": "Glossy",
    "occlusion": "Diffuse",
}
OBJECTS = (  # a kind and a shape
    ("matt", "monkey"), ("metal", "ball"), ("buckets", "cube"), ("glass", "torus"), ("occlusion", "monkey"),
    ("matt", "cube"), ("metal", "torus"), ("buckets", "monkey"), ("glass", "cube"), ("occlusion", "torus"),
    ("matt", "ball"), ("metal", "monkey"),
)  # fmt: skip


def build() -> list[tuple[str, str]]:
    """Place the objects in the demo's scene; returns the kind and the name of each."""
    build_demo_scene()
    made = []
    for number, (kind, shape) in enumerate(OBJECTS):
        _ADD[shape](location=(number % 4 * 2.5 - 4, 3 + number // 4 * 2.5, 0.6))
        context.object.name = name = f"{kind} {shape}".capitalize()
        context.object.modifiers.new("Modifier", "BEVEL" if shape == "cube" else "SUBSURF")
        material = stage.material(name, f"ShaderNodeBsdf{_SHADERS[kind]}")
        context.object.data.materials.append(material)
        made.append((kind, name))
    return made


@dataclass(frozen=True)
class Told:
    """What was told when a `share` of a bake's time had gone by, and the seconds that were still needed."""

    mode: str
    name: str
    share: float
    needed: float
    left: Left

    @property
    def ratio(self) -> float:
        """The told time over the needed one, or the other way round: at least 1."""
        return max(self.left.seconds / self.needed, self.needed / max(self.left.seconds, 0.1))


def replayed(recording: Sequence[Mapping[str, Any]], shares: Sequence[float] = SHARES) -> list[Told]:
    """What RadTex tells, at `shares` of each recorded bake's time, where it learns from the bakes before."""
    history: list[Measurement] = []
    found = []
    for one in recording:
        expected = estimate(BakeWork(**one["work"]), "here", one["name"], history)
        took, facts = one["took"], one["facts"]
        for share in shares:
            now = share * took
            course = course_until(Course(expected), one["events"], now)
            found.append(Told(one["mode"], one["name"], share, took - now, time_left(course, now)))
        work = replace(
            BakeWork(**one["work"]),
            covered=facts["covered_texels"],
            triangles=facts["triangles"],
            texels=max(facts["texels"]),
        )
        seconds = {START: max(0.0, took - sum(facts["seconds"].values()))} | facts["seconds"]
        history.append(Measurement("here", one["name"], work, seconds))
    return found


def course_until(course: Course, events: Sequence[Sequence[Any]], now: float) -> Course:
    """The course of a bake after those events that came until `now`."""
    for when, stage_, done, total in events:
        if when <= now:
            course = course.at(stage_, done / total if total else 1.0, when)
    return course


def table(found: Sequence[Told]) -> str:
    """The median and the worst ratio for each share, and how often what was needed was within the range."""
    lines = [
        "| machine | gone by | median | worst | within 1.5 | within the range | not told |",
        "|---|---|---|---|---|---|---|",
    ]
    for mode in dict.fromkeys(one.mode for one in found):
        for share in dict.fromkeys(one.share for one in found):
            some = [one for one in found if (one.mode, one.share) == (mode, share)]
            ratios = [one.ratio for one in some]
            near = sum(ratio <= 1.5 for ratio in ratios)
            within = sum(one.left.least <= one.needed <= one.left.most for one in some)
            vague = sum(not one.left.is_known for one in some)
            lines.append(
                f"| {mode} | {share:.0%} | {median(ratios):.2f} | {max(ratios):.2f} "
                f"| {near} of {len(some)} | {within} of {len(some)} | {vague} |"
            )
    return "\n".join(lines)


def bake(kind: str, name: str, out: Path) -> dict[str, Any]:
    """Bake an object by a worker; returns what it reported, when, and what was told meanwhile."""
    for key, value in _SETTINGS[kind].items():
        setattr(settings(), key, value)
    settings().directory, settings().preview = str(out), True
    values = values_of(settings())
    ((_, choice),) = chosen_layouts(context.scene, (name,), values, spec_of(values))
    work = asdict(estimates._work_of(context.scene, name, choice.spec))
    known = estimates.seconds_known(context.scene, [(name, choice.spec)])
    assert known is not None
    events: list[list[Any]] = []
    told: list[list[float]] = []
    since = monotonic()
    with heard(lambda event: events.append([round(monotonic() - since, 2), *event])):
        jobs.submit(context.scene, [plan_bakes(context.scene, request_of(values, (name,)))])
        while jobs.advance():
            (job,) = jobs.snapshot()
            if job.left is not None:
                ends = (job.left.least, job.left.seconds, job.left.most)
                told.append([round(monotonic() - since, 2), *(round(end, 2) for end in ends)])
            sleep(0.25)
    took = monotonic() - since
    (job,) = jobs.snapshot()
    assert job.state == "done", job.message
    facts = {key: job.facts[key] for key in ("covered_texels", "triangles", "texels", "seconds", "device")}
    jobs.forget_ended()
    return {
        "kind": kind,
        "name": name,
        "took": round(took, 2),
        "before": [round(known.seconds, 1), str(known.basis)],
        "work": work,
        "facts": facts,
        "events": events,
        "told": told,
    }


@contextmanager
def heard(hears: Callable[[tuple[str, float, float]], None]) -> Iterator[None]:
    """Let `hears` hear the progress that workers report: the stage, and how much of how much is done."""
    original = Worker.events

    def events(self: Worker) -> Any:
        found = original(self)
        for event in found:
            if event.get("event") == "progress":
                hears((event["stage"], event["done"], event["total"]))
        return found

    Worker.events = events  # type: ignore[method-assign]
    try:
        yield
    finally:
        Worker.events = original  # type: ignore[method-assign]


@contextmanager
def busy_core(wanted: bool) -> Iterator[None]:
    """Keep a core busy by a loop, if that is wanted."""
    loop = subprocess.Popen([sys.executable, "-c", "while True: pass"]) if wanted else None
    try:
        yield
    finally:
        if loop is not None:
            loop.kill()
            loop.wait()


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--record", type=Path)
    parser.add_argument("--replay", type=Path)
    parser.add_argument("--first", type=int, default=len(OBJECTS))
    options = parser.parse_args()
    if options.replay is not None:
        show([json.loads(line) for line in options.replay.read_text().splitlines()])
        return
    recording = []
    with tempfile.TemporaryDirectory() as temporary:
        bpy.ops.wm.read_factory_settings(use_empty=True)
        with registered():
            preferences().cache_folder = str(Path(temporary) / "cache")
            things = build()[: options.first]
            for mode in ("idle", "busy"):
                with busy_core(mode == "busy"):
                    for kind, name in things:
                        found = {"mode": mode} | bake(kind, name, Path(temporary) / mode)
                        recording.append(found)
                        print(mode, name, found["took"], found["before"], os.getloadavg()[0], flush=True)
                        if options.record:
                            with options.record.open("a") as file:
                                file.write(json.dumps(found) + "\n")
    show(recording)


def show(recording: Sequence[Mapping[str, Any]]) -> None:
    """Print what was told of each bake, and the table."""
    found = replayed(recording)
    for number, one in enumerate(recording):
        some = found[number * len(SHARES) : (number + 1) * len(SHARES)]
        told = ", ".join(f"{told_range(each.left)} for {each.needed:.0f} s" for each in some)
        print(f"{one['mode']}, {one['name']}: {told}")
    print(table(found))


if __name__ == "__main__":
    main()
