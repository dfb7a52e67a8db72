# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames for machines without RadTex: the sheets of the light, and of the paths' ends, of a layered bake."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..bake.plan import CapturePlan
from ..core.errors import BakeError, FormatError, InputError
from ..core.quoting import quoted
from ..cycles.building_blocks import read_layers
from ..cycles.passes import Passes, finite_light, raw_light_of
from ..cycles.sampling import EMITTED, rows_of_tiles
from ..formats.json_reader import Facts
from ..forms.layered.capture.parts import Part
from ..settings.spec import BakeSpec
from ..store.shared_pieces import appears
from .farm_files import RUNNER
from .farm_manifest import MOST_FRAMES
from .frame_list import frame_list
from .rendered_frames import BadFrame, Fault, faults_told, stamps_of

FRAMES = "frames"  # the folder of the .blends and their pictures, in the farm's
PARTS = (Part.LIGHT, Part.ENDS)  # of layered bakes, that are frames
_LOBES = {Part.LIGHT: ("diffuse", "transmission"), Part.ENDS: ("glossy", "transmission")}
_FIRST_NAMED = 5  # the first Blender whose pictures name its version
_MOST_SIDE = 1 << 16  # of a picture in Blender, in pixels


def has_frames(spec: BakeSpec) -> bool:
    """Whether a bake has PARTS that can be frames: whether it is in the layered layout."""
    return spec.form.by_paths


@dataclass(frozen=True)
class PartFrames:
    """All frames of the `part` of the bake `bake`, of about so many `seconds` each.

    The part's plan has `columns` x `rows` buckets of `cells` x `cells` pixels, in sheets of `sheet_rows`.
    Each sheet is a frame, and of ENDS a frame in each of the EMITTED lights.
    """

    bake: str
    part: Part
    columns: int
    rows: int
    sheet_rows: int
    cells: int
    seconds: float

    @classmethod
    def of(cls, bake: str, part: Part, plan: CapturePlan, seconds: float, begin: float) -> PartFrames:
        """The frames of a plan, whose renders take so many `seconds` in all, and `begin` to start each."""
        made = cls(bake, part, plan.columns, plan.rows, plan.sheet_rows, plan.layout.bucket, 0.0)
        return cls(**vars(made) | {"seconds": round(begin + seconds / made.count, 1)})

    @property
    def name(self) -> str:
        """The name of the .blend, without its suffix, and of its pictures' folder."""
        return f"{self.bake}.{self.part}"

    @property
    def lights(self) -> int:
        """How many frames there are of each sheet."""
        return len(EMITTED) if self.part is Part.ENDS else 1

    @property
    def sheets(self) -> int:
        return -(-self.rows // self.sheet_rows)

    @property
    def count(self) -> int:
        """The number of the last frame; the first is 1."""
        return self.sheets * self.lights

    @property
    def pixels(self) -> tuple[int, int]:
        """A frame's height and width."""
        return self.sheet_rows * self.cells, self.columns * self.cells

    def blend(self, farm: Path) -> Path:
        """The .blend that renders them, in a farm's folder."""
        return farm / FRAMES / f"{self.name}.blend"

    def path(self, frame: int) -> str:
        """Where Blender writes a frame, in the farm's folder."""
        return f"{FRAMES}/{self.name}/{frame:04d}.exr"

    def picture(self, farm: Path, frame: int) -> Path:
        """The same as a path."""
        return farm / self.path(frame)

    @property
    def output(self) -> str:
        """The same for all frames, as the .blend has it."""
        return f"//{self.name}/####"

    def note(self, job: str) -> str:
        """The text in the header of each."""
        return f"RadTex job {job} {self.name}"

    def number(self, light: int, sheet: int) -> int:
        """The frame of a sheet in the light with that number among those EMITTED."""
        return sheet * self.lights + light + 1

    def of_share(self, share: tuple[int, int]) -> list[int]:
        """The frames that the task needs that makes such a `share` of the part: see `SharedPieces`."""
        number, count = share
        height = rows_of_tiles(self.columns, self.cells)
        tiles = -(-self.rows // height)
        first, end = (each * tiles // count * height for each in (number, number + 1))
        if end <= first:
            return []
        sheets = range(first // self.sheet_rows, (min(end, self.rows) - 1) // self.sheet_rows + 1)
        return [self.number(light, sheet) for sheet in sheets for light in range(self.lights)]

    def commands(self, farm: Path, frames: Sequence[int]) -> tuple[str, str]:
        """The commands that render the frames: with Blender, and with the bpy module."""
        blend, listed = str(self.blend(farm.absolute())), frame_list(frames)
        runner = str(farm.absolute() / FRAMES / RUNNER)
        return quoted(["blender", "-b", blend, "-f", listed]), quoted(
            ["python", runner, "-b", blend, "-f", listed]
        )

    def to_facts(self) -> dict[str, Any]:
        """What the list of tasks says of them."""
        height, width = self.pixels
        return {
            "bake": self.bake,
            "part": str(self.part),
            "blend": f"{FRAMES}/{self.name}.blend",
            "pictures": f"{FRAMES}/{self.name}/####.exr",
            "frames": [1, self.count],
            "size": [width, height],
            "seconds": self.seconds,
            "plan": [self.columns, self.rows, self.sheet_rows, self.cells],
        }

    @classmethod
    def from_facts(cls, facts: Facts, bakes: Sequence[str]) -> PartFrames:
        """Read what `to_facts` says. Raises FormatError."""
        columns, rows, sheet_rows, cells = (round(number) for number in facts.numbers("plan", 4))
        part = Part(facts.choice("part", PARTS))
        bake, seconds = facts.choice("bake", tuple(bakes)), facts.number("seconds")
        if min(columns, rows, sheet_rows, cells) < 1 or max(columns, sheet_rows) * cells > _MOST_SIDE:
            raise FormatError(f"{facts.source} tells of frames that no bake has: prepare it anew")
        made = cls(bake, part, columns, rows, sheet_rows, cells, seconds)
        if made.count > MOST_FRAMES:
            raise FormatError(f"{facts.source} tells of frames that no bake has: prepare it anew")
        return made


class RenderedPart:
    """The rendered frames that a task needs, in the folder `farm` of the `job`, prepared in `blender`."""

    def __init__(
        self, farm: Path, job: str, blender: str, frames: PartFrames, share: tuple[int, int]
    ) -> None:
        self._farm, self._job, self._blender, self._frames = farm, job, blender, frames
        self._needed = frames.of_share(share)
        self._last: dict[int, tuple[int, Passes]] = {}  # of each light the sheet that was read last

    def check(self) -> None:
        """Raises InputError if frames are not there, or are not those, with what renders just these.

        Reads their headers alone, unless there are such: then it names those that are damaged, too.
        """
        missing = [one for one in self._needed if not self._frames.picture(self._farm, one).is_file()]
        if missing:
            appears(self._frames.picture(self._farm, missing[0]))
        if self._bad(self._check_header):
            self._refuse(self._bad(self._read))

    def sheet(self, light: int, sheet: int) -> Passes:
        """A sheet's passes, as of `Sheets`. Raises InputError as `check` for a file that is damaged, too."""
        if light not in self._last or self._last[light][0] != sheet:
            self._last.pop(light, None)
            try:
                read = self._read(self._frames.number(light, sheet))
            except BadFrame:
                self._refuse(self._bad(self._read))
                read = self._read(self._frames.number(light, sheet))  # another machine has rendered it now
            self._last[light] = sheet, read
        return self._last[light][1]

    def _bad(self, check: Callable[[int], object]) -> dict[int, BadFrame]:
        found = {}
        for number in self._needed:
            try:
                check(number)
            except BadFrame as error:
                found[number] = error
        return found

    def _refuse(self, bad: dict[int, BadFrame]) -> None:
        if not bad:
            return
        frames = self._frames
        blender, python = frames.commands(self._farm, list(bad))
        raise InputError(
            f"{len(bad)} of {len(self._needed)} frames of {frames.blend(self._farm)} cannot be used: "
            f"{faults_told(bad)}; render just those: {blender}   or, with the bpy module: {python}   "
            "or remove that .blend: then this machine renders all of them itself"
        )

    def _check_header(self, number: int) -> None:
        path = self._frames.picture(self._farm, number)
        software = stamps_of(path, self._frames.note(self._job), number).get("Software", "")
        if not _is_of(software, self._blender):
            raise BadFrame(Fault.VERSION, software)

    def _read(self, number: int) -> Passes:
        """Read and check a frame. Raises BadFrame."""
        self._check_header(number)
        path, frames = self._frames.picture(self._farm, number), self._frames
        try:
            with np.errstate(all="ignore"):  # infinite light times nothing: `finite_light` tells
                passes = read_layers(path)
                for lobe in _LOBES[frames.part]:
                    raw_light_of(passes, lobe)
        except (FormatError, StopIteration, LookupError, ValueError) as error:
            raise BadFrame(Fault.DAMAGED) from error
        if any(pixels.shape[:2] != frames.pixels for pixels in passes.raw.values()):
            raise BadFrame(Fault.DAMAGED)
        sheet = (number - 1) // frames.lights
        try:
            finite_light(passes.raw_whole[: (frames.rows - sheet * frames.sheet_rows) * frames.cells])
        except BakeError as error:
            raise BadFrame(Fault.NOT_NUMBERS) from error
        return passes


def _is_of(software: str, blender: str) -> bool:
    """Whether a picture with that stamp can be of a version of Blender; 4.5's pictures do not name theirs."""
    own = re.match(r"\d+\.\d+\.\d+", blender)
    if own is None or (not software and int(own[0].split(".")[0]) < _FIRST_NAMED):
        return True
    return own[0] in software
