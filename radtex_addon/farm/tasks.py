# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A farm whose machines have RadTex: its tasks, what each needs, and the files in its folder."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field, replace
from functools import cached_property
from heapq import heapify, heappop, heappush
from pathlib import Path
from typing import Any

from ..core.errors import FormatError, InputError, RadTexError
from ..core.quoting import quoted
from ..core.sampler import Filter
from ..formats.disk.regular import digest
from ..formats.fingerprint import KEY, Fingerprint, fingerprint_in
from ..formats.json_reader import Facts, json_text
from ..formats.sidecar_file import read_text
from ..forms.layered.capture.parts import Part
from ..settings.spec import BakeSpec, facts_of, spec_in
from ..store import checkpoint_files
from ..store.shared_pieces import appearing, appears
from ..version import VERSION
from .farm_files import tasks_file
from .part_frames import PartFrames
from .self_contained import Carried

_VERSION = 1
_WHAT = "farm's list of tasks"
_ID = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,150}")
_LISTED = 20  # most tasks that are named in a message
WHOLE = "bake"  # what a task makes that does a whole bake, or what is left of one: its files


@dataclass(frozen=True)
class Task:
    """A task by its `name`: of the bake `bake` it makes the `part`, or the `share` of it.

    It can begin when all that it `needs` is done, and takes about so many `seconds` of a processor core and
    bytes of `memory`.
    """

    name: str
    bake: str
    part: str
    needs: tuple[str, ...]
    seconds: float
    memory: int
    share: tuple[int, int] = (0, 1)

    @property
    def is_last(self) -> bool:
        """Whether it makes the bake's files."""
        return self.part == WHOLE

    @property
    def is_frame(self) -> bool:
        """Whether it is none of a farm's own tasks, but a frame, called like its picture."""
        return "/" in self.name


@dataclass(frozen=True)
class FarmBake:
    """One of the bakes: the atlas `name` by `spec`. The `key` names its files in the farm's folder.

    The `fingerprint` is of the scene that was prepared: of its copy, which packs images, it would be another.
    """

    key: str
    name: str
    spec: BakeSpec
    fingerprint: Fingerprint | None = None

    @property
    def last(self) -> str:
        """The name of the task that makes its files."""
        return f"{self.key}.{WHOLE}"


@dataclass(frozen=True)
class Done:
    """What a task came to: the `pieces` that it made, and if it is a bake's last the digests of its `files`.

    It took so many `seconds`, and `memory` bytes at most, on the machine `host`. `result` is as of
    `BakeOutput.told`.
    """

    pieces: tuple[str, ...]
    files: Mapping[str, str]
    seconds: float
    memory: int
    host: str
    result: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class TaskFarm:
    """The farm in `folder`: its `bakes` and their `tasks`, each behind those that it needs.

    `scene` is the name of the scene in its .blend, a copy of the file `blend`; `preview` is the filter of the
    previews that are wanted. It was prepared by the RadTex `radtex` in Blender `blender`. `carried` lists the
    files of the preparing machine in the folder. `frames` are those that machines without RadTex render.
    """

    folder: Path
    job: str
    scene: str
    blend: str
    radtex: str
    blender: str
    preview: Filter | None
    bakes: tuple[FarmBake, ...]
    tasks: tuple[Task, ...]
    carried: tuple[Carried, ...] = ()
    frames: tuple[PartFrames, ...] = ()

    @property
    def scene_file(self) -> Path:
        return self.folder / "scene.blend"

    def pieces(self, bake: str) -> Path:
        """The folder of a bake's pieces."""
        return self.folder / "pieces" / bake

    @property
    def views(self) -> Path:
        """The folder of pictures of rooms, which bakes share."""
        return self.folder / "pieces" / "_shared"

    def results(self, bake: str) -> Path:
        """The folder of a bake's files."""
        return self.folder / "baked" / bake

    def mark(self, task: str) -> Path:
        """The file that says that a task is done."""
        return self.folder / "done" / f"{task}.json"

    @cached_property
    def by_name(self) -> dict[str, Task]:
        return {task.name: task for task in self.tasks}

    def check_same(self) -> None:
        """Raises InputError if the folder holds another farm by now, or none."""
        path = tasks_file(self.folder)
        if not path.is_file() or Facts.parse(read_text(path), str(path), _WHAT).text("job") != self.job:
            raise InputError(f"{self.folder} was prepared anew meanwhile: start this again")

    def task(self, name: str) -> Task:
        """The task of that name. Raises InputError."""
        if name not in self.by_name:
            some = ", ".join(list(self.by_name)[:_LISTED])
            raise InputError(f"{self.folder} has no task '{name}': {tasks_file(self.folder)} has {some} …")
        return self.by_name[name]

    def bake_of(self, task: Task) -> FarmBake:
        return next(bake for bake in self.bakes if bake.key == task.bake)

    def frames_of(self, task: Task) -> PartFrames | None:
        """The frames of a task's part; None if it is rendered where the task is done.

        That is so, too, where somebody has removed the .blend of the frames.
        """
        found = (one for one in self.frames if (one.bake, one.part) == (task.bake, task.part))
        return next((one for one in found if one.blend(self.folder).is_file()), None)

    def with_frames(self) -> tuple[Task, ...]:
        """The tasks, and before them one for each frame, called like its picture, which some tasks need."""
        rendered = []
        for frames in self.frames:
            own = [task for task in self.tasks if (task.bake, task.part) == (frames.bake, frames.part)]
            memory = max((task.memory for task in own), default=0)
            rendered += [
                Task(frames.path(one), frames.bake, f"{frames.part}-frames", (), frames.seconds, memory)
                for one in range(1, frames.count + 1)
            ]
        return (
            *rendered,
            *(replace(task, needs=(*task.needs, *self._pictures(task))) for task in self.tasks),
        )

    def lacks_pictures(self, task: Task) -> bool:
        """Whether frames that a task needs are not rendered yet."""
        wanted = self._pictures(task) if self.frames_of(task) else ()
        return any(not (self.folder / picture).is_file() for picture in wanted)

    def _pictures(self, task: Task) -> list[str]:
        """The pictures of frames that a task needs."""
        found = (one for one in self.frames if (one.bake, one.part) == (task.bake, task.part))
        return [frames.path(one) for frames in found for one in frames.of_share(task.share)]

    def is_done(self, task: str) -> bool:
        """Whether a task is marked as done."""
        return self.mark(task).is_file()

    def undone(self, tasks: Sequence[str]) -> list[str]:
        """Those of some tasks that are not marked as done, also after a while: disks may show marks late."""
        return [name for name in tasks if not appears(self.mark(name))]

    def left(self) -> list[Task]:
        """The tasks that are not marked as done, in an order in which they can be done."""
        done = {path.stem for path in self.mark("x").parent.glob("*.json")}
        return [task for task in self.tasks if task.name not in done]

    def done(self, task: str) -> Done:
        """What a task came to. Raises FormatError, which says to do it again, if that cannot be read."""
        path = self.mark(task)
        try:
            facts = Facts.parse(read_text(path), str(path), "mark of a farm's task")
            files = facts.inner("files")
            if any(Path(name).name != name for name in files.values):
                raise FormatError(f"{path} names files that are elsewhere")
            result = facts.values.get("result")
            return Done(
                pieces=facts.texts("pieces"),
                files={name: files.text(name) for name in files.values},
                seconds=facts.number("seconds"),
                memory=facts.whole_number("memory", 0),
                host=facts.text("host"),
                result=result if isinstance(result, dict) else {},
            )
        except RadTexError as error:
            raise FormatError(f"{error}: do it again: {self.command([task])}") from error

    def set_done(self, task: str, done: Done) -> None:
        """Mark a task as done. Raises BakeError where the system refuses."""
        with appearing(self.mark(task)) as beside:
            beside.write_text(json_text(asdict(done)), encoding="utf-8", newline="\n")

    def set_undone(self, task: str) -> None:
        """Take a task's mark away, if it has one."""
        with suppress(OSError):
            self.mark(task).unlink()

    def command(self, tasks: Collection[str] = ()) -> str:
        """What to type to do some tasks, or all that are left."""
        return quoted(["python", "bake.py", "work", str(self.folder), *tasks])

    def command_for(self, tasks: list[str]) -> str:
        """The same, short however many tasks there are."""
        return self.command(tasks if len(tasks) <= _LISTED else ())

    def result_faults(self, task: str) -> str:
        """What is wrong with the files of a task that is marked as done, "" if nothing."""
        place = self.results(self.by_name[task].bake)
        done = self.done(task)
        for name, known in done.files.items():
            path = place / name
            if not path.is_file():
                return f"{path} is not there"
            if digest(path) != known:
                return f"{path} is damaged"
        return ""

    def seconds_for(self, machines: int) -> float:
        """About how long so many machines need, one task at a time each: those that begin a long chain first.

        As if each machine did as much in a second as a processor core of the preparing one.
        """
        chain, waiting = self.chains(), {task.name: len(set(task.needs)) for task in self.tasks}
        behind: dict[str, list[Task]] = {}
        for task in self.tasks:
            for need in set(task.needs):
                behind.setdefault(need, []).append(task)
        ready = [(-chain[task.name], task.name) for task in self.tasks if not task.needs]
        heapify(ready)
        running: list[tuple[float, str]] = []
        now = 0.0
        while ready or running:
            while ready and len(running) < machines:
                _, name = heappop(ready)
                heappush(running, (now + self.by_name[name].seconds, name))
            now, ended = heappop(running)
            for task in behind.get(ended, ()):
                waiting[task.name] -= 1
                if not waiting[task.name]:
                    heappush(ready, (-chain[task.name], task.name))
        return now

    def chains(self) -> dict[str, float]:
        """Seconds from each task's beginning to the end of the longest chain of tasks that begins with it."""
        found: dict[str, float] = {}
        behind: dict[str, float] = {}
        for task in reversed(self.tasks):
            found[task.name] = task.seconds + behind.get(task.name, 0.0)
            for need in task.needs:
                behind[need] = max(behind.get(need, 0.0), found[task.name])
        return found

    def to_json(self) -> str:
        """The text of the file that lists the tasks."""
        return json_text(
            {
                "version": _VERSION,
                "pieces": checkpoint_files.PIECE_FORMAT,
                "radtex": self.radtex,
                "blender": self.blender,
                "job": self.job,
                "scene": self.scene,
                "blend": self.blend,
                "preview": None if self.preview is None else str(self.preview),
                "bakes": [
                    {
                        "key": bake.key,
                        "name": bake.name,
                        "spec": facts_of(bake.spec),
                        KEY: None if bake.fingerprint is None else bake.fingerprint.to_facts(),
                    }
                    for bake in self.bakes
                ],
                "tasks": [
                    {
                        "id": task.name,
                        "bake": task.bake,
                        "part": task.part,
                        "share": list(task.share),
                        "needs": list(task.needs),
                        "pictures": self._pictures(task),
                        "command": ["python", "bake.py", "work", ".", task.name],
                        "seconds": task.seconds,
                        "memory": task.memory,
                    }
                    for task in self.tasks
                ],
                "frames": [each.to_facts() for each in self.frames],
                "carried": [asdict(each) for each in self.carried],
            }
        )


def read_tasks(folder: Path) -> TaskFarm:
    """Read the farm in a folder.

    Raises InputError if there is none, FormatError for a file that is no list of tasks, or of another RadTex.
    """
    path = tasks_file(folder)
    if not path.is_file():
        raise InputError(f"{folder} holds no tasks: name the folder that bake.py prepare wrote")
    facts = Facts.parse(read_text(path), str(path), _WHAT)
    found = (facts.whole_number("version", 1), facts.whole_number("pieces", 1), facts.text("radtex"))
    own = (_VERSION, checkpoint_files.PIECE_FORMAT, VERSION)
    if found != own:
        said, here = (
            f"{radtex} (formats {version} and {pieces})" for version, pieces, radtex in (found, own)
        )
        raise FormatError(
            f"{path} was prepared by RadTex {said}, and this is {here}: "
            "use the one that prepared it, or prepare it anew"
        )
    bakes = tuple(_bakes(facts))
    tasks = tuple(_tasks(facts, {bake.key for bake in bakes}))
    preview = facts.values.get("preview")
    return TaskFarm(
        folder=folder,
        job=facts.text("job"),
        scene=facts.text("scene"),
        blend=facts.text("blend"),
        radtex=VERSION,
        blender=facts.text("blender"),
        preview=None if preview is None else Filter(facts.choice("preview", tuple(Filter))),
        bakes=bakes,
        tasks=tasks,
        frames=tuple(_frames(facts, [bake.key for bake in bakes])),
    )


def _bakes(facts: Facts) -> Iterator[FarmBake]:
    for one in _rows(facts, "bakes"):
        known = None if one.values.get(KEY) is None else fingerprint_in(one)
        yield FarmBake(_checked(one, "key"), one.text("name"), spec_in(one.inner("spec")), known)


def _tasks(facts: Facts, bakes: Collection[str]) -> Iterator[Task]:
    known: set[str] = set()
    for one in _rows(facts, "tasks"):
        first, count = (round(number) for number in one.numbers("share", 2))
        task = Task(
            name=_checked(one, "id"),
            bake=one.choice("bake", tuple(bakes)),
            part=one.choice("part", (*Part, WHOLE)),
            needs=one.texts("needs"),
            seconds=one.number("seconds"),
            memory=one.whole_number("memory", 0),
            share=(first, count),
        )
        if task.name in known or not known.issuperset(task.needs) or not 0 <= first < count:
            raise FormatError(f"{facts.source} lists a task '{task.name}' that cannot be: prepare it anew")
        known.add(task.name)
        yield task


def _frames(facts: Facts, bakes: Sequence[str]) -> Iterator[PartFrames]:
    for one in _rows(facts, "frames") if "frames" in facts.values else ():  # farms had none once
        yield PartFrames.from_facts(one, bakes)


def _rows(facts: Facts, key: str) -> Iterator[Facts]:
    rows = facts.values.get(key)
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise FormatError(f'{facts.source} has no list of "{key}": prepare it anew')
    for row in rows:
        yield Facts(row, facts.source)


def _checked(facts: Facts, key: str) -> str:
    """A name that is no path and needs no quotes. Raises FormatError."""
    name = facts.text(key)
    if not _ID.fullmatch(name):
        raise FormatError(f"{facts.source} has a {key} that is no name: {json.dumps(name)}; prepare it anew")
    return name


def publish_results(made: Path, place: Path) -> None:
    """Give a folder of finished files its name, unless there is one of the same files already.

    Raises OSError.
    """
    if not place.is_dir():
        with suppress(OSError):  # another machine may be quicker
            made.rename(place)
            return
    if _digests(made) == _digests(place):
        shutil.rmtree(made, ignore_errors=True)
        return
    old = place.with_name(f"{made.name}-old")
    place.rename(old)
    made.rename(place)
    shutil.rmtree(old, ignore_errors=True)


def _digests(folder: Path) -> dict[str, str]:
    return {path.name: digest(path) for path in folder.iterdir()}
