# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A farm's folder of either sort, of tasks or frames: which bakes it makes, and what these replace."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from ..core.errors import FormatError, InputError
from ..job.variants import Bake
from ..store.bake_folder import BakeFolder, FolderState
from ..store.ownership import Overwrite
from .farm_files import SUFFIX, FarmFiles, is_farm, tasks_file
from .farm_manifest import read_manifest
from .tasks import read_tasks


@dataclass(frozen=True)
class FarmFolder:
    """The `bakes` of the farm in `folder`, with previews or without, of the file `blend`.

    Of its `tasks` so many are `done`; a farm of frames has none.
    """

    folder: Path
    bakes: tuple[Bake, ...]
    preview: bool
    blend: Path
    tasks: int = 0
    done: int = 0

    def replaced(self, out: Path) -> Iterator[str]:
        """What its bakes would replace in the folder `out`, a sentence for each that is there.

        What none of them may replace is left out: assembling refuses that.
        """
        for bake in self.bakes:
            place = BakeFolder(*bake, out, self.preview)
            try:
                place.check_may_write(Overwrite(False, False, self.blend))
            except InputError:
                with suppress(InputError):
                    place.check_may_write(Overwrite(True, True, self.blend))
                    yield from place.reasons_to_ask(Overwrite(True, False, self.blend)) or (_there(place),)


def read_farm_folder(folder: Path) -> FarmFolder:
    """The farm in a folder. Raises InputError if there is none, FormatError for one that cannot be read."""
    if tasks_file(folder).is_file():
        farm = read_tasks(folder)
        bakes = tuple((bake.name, bake.spec) for bake in farm.bakes)
        tasks = len(farm.tasks)
        done = tasks - len(farm.left())
        return FarmFolder(folder, bakes, farm.preview is not None, Path(farm.blend), tasks, done)
    files = FarmFiles(folder)
    if not files.manifest.is_file():
        raise InputError(f"{folder} holds no farm: choose a folder whose name ends in {SUFFIX}")
    made = read_manifest(files)
    return FarmFolder(folder, ((made.name, made.spec),), made.copies is not None, Path(made.facts.blend))


def check_no_farm(folder: Path) -> None:
    """Raises InputError where a farm's folder would go, and something else is there."""
    if folder.exists() and not is_farm(folder):
        raise InputError(
            f"{folder} is already there, and is no farm: move it, or choose another folder for the bakes"
        )


def told_earlier(folder: Path) -> str:
    """A sentence on the farm in `folder`, which would be replaced; "" if there is none."""
    if not is_farm(folder):
        return ""
    try:
        farm = read_farm_folder(folder)
    except (InputError, FormatError):
        return f"{folder.name} is there, of another version: it will be replaced"
    made = f"{farm.done} of {farm.tasks} tasks done" if farm.tasks else "the frames that were rendered"
    return f"{folder.name} is there, with {made}: it will be replaced"


def _there(place: BakeFolder) -> str:
    if place.state is FolderState.UNFINISHED:
        return f"{place.files.unfinished} holds an unfinished bake: it will be given up"
    return f"{place.files.sidecar} is already there: it will be replaced"
