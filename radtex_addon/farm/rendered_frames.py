# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Check and read the frames that a farm has rendered; unusable ones are reported with the reason."""

from __future__ import annotations

import logging
import re
from collections.abc import Generator, Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np

from ..bake.layers import captured
from ..bake.plan import CapturePlan, Tile
from ..core.arrays import Floats
from ..core.errors import BakeError, FormatError
from ..cycles.building_blocks import read_layers
from ..cycles.passes import light_of
from ..formats.containers.exr import read_stamps
from .farm_files import FarmFiles
from .farm_manifest import FarmManifest
from .farm_progress import FarmStep, FarmTask
from .frame_list import commands, frame_list

log = logging.getLogger(__name__)

_DIGITS = 9  # of a frame's number at most; Python refuses to read thousands


class Fault(StrEnum):
    """What can be wrong with a frame."""

    MISSING = "missing"
    FOREIGN = "of another job"
    SWAPPED = "another frame's picture"
    DAMAGED = "damaged"
    VERSION = "of another version of Blender"
    NOT_NUMBERS = "not numbers (look for a material that divides by 0)"


def check_frames(files: FarmFiles, manifest: FarmManifest) -> Generator[FarmStep, None, None]:
    """Read and check every frame.

    Infinite light is clamped to the file's largest value, as in a bake on one machine, with a warning. Raises
    BakeError with the names of all unusable frames, and the commands that render them again.
    """
    bad: dict[int, BadFrame] = {}
    versions: set[str] = set()
    endless: list[int] = []
    for number in range(1, manifest.sheets + 1):
        yield FarmStep(FarmTask.CHECK, number - 1, manifest.sheets)
        try:
            checked = _check(files, manifest, number)
            versions.add(checked.version)
            if checked.endless:
                endless.append(number)
        except BadFrame as error:
            bad[number] = error
    yield FarmStep(FarmTask.CHECK, manifest.sheets, manifest.sheets)
    strays = list(_strays(files, manifest))
    if bad or strays:
        raise BakeError(_complaint(files, manifest, bad, strays))
    _warn_of_versions(versions, manifest)
    if endless:
        log.warning(
            "frames %s show infinite light: the greatest value that the file holds stands for it, as in a "
            "bake on one machine",
            frame_list(endless),
        )


def read_frame(path: Path, manifest: FarmManifest) -> Floats:
    """A frame's picture (H, W, C), row 0 at the bottom: RGBA, then each layer's three channels.

    Raises FormatError for a file that is damaged, of another size, or lacks a layer.
    """
    try:
        with np.errstate(all="ignore"):  # infinite light times nothing: found as no number
            passes = read_layers(path)
            lights = [light_of(passes, layer) for layer in captured(manifest.spec.layers)]
            pixels = np.concatenate([passes.whole, *lights], axis=-1)
    except (StopIteration, LookupError, ValueError):
        raise FormatError(f"{path} lacks a layer, or has one of another size") from None
    expected = (*manifest.pixels, manifest.spec.channels)
    if pixels.shape != expected:
        raise FormatError(f"{path} has {pixels.shape} pixels, expected {expected}")
    return pixels


class FarmCapture:
    """A capture that reads its tiles from the frames of a farm."""

    def __init__(self, files: FarmFiles, manifest: FarmManifest, plan: CapturePlan) -> None:
        self._files, self._manifest, self._plan = files, manifest, plan
        self._sheet, self._pixels = -1, np.zeros((0, 0, 0), dtype=np.float32)

    def render(self, tile: Tile) -> Floats:
        """The cells of the tile's texels: see `Capture.render`."""
        plan, n = self._plan, self._plan.layout.bucket
        parts = []
        for sheet, part in plan.in_sheets(tile):
            rows = self._picture(sheet)[part.first_row * n : part.end * n]
            cells = rows.reshape(part.rows, n, plan.columns, n, -1).transpose(0, 2, 1, 3, 4)
            parts.append(cells.reshape(-1, n, n, rows.shape[2]))
        return np.concatenate(parts)[: len(plan.texels_of(tile))]

    def _picture(self, sheet: int) -> Floats:
        if sheet != self._sheet:
            self._pixels = read_frame(self._files.frame(sheet + 1), self._manifest)
            self._sheet = sheet
        return self._pixels


class BadFrame(Exception):
    """A frame that cannot be used."""

    def __init__(self, fault: Fault, detail: str = "") -> None:
        super().__init__(fault)
        self.fault, self.detail = fault, detail


@dataclass(frozen=True)
class _Checked:
    """A usable frame: its Blender's `version` ("" if unknown), and whether light in it is infinite."""

    version: str
    endless: bool


def _check(files: FarmFiles, manifest: FarmManifest, number: int) -> _Checked:
    """Check one frame. Raises BadFrame."""
    path = files.frame(number)
    stamps = stamps_of(path, manifest.note, number)
    try:
        pixels = read_frame(path, manifest)
    except FormatError as error:
        raise BadFrame(Fault.DAMAGED) from error
    if np.isnan(pixels).any():
        raise BadFrame(Fault.NOT_NUMBERS)
    return _Checked(stamps.get("Software", ""), bool(np.isinf(pixels).any()))


def stamps_of(path: Path, note: str, number: int) -> dict[str, str]:
    """The stamps of a picture, which say that it is the frame of that number of the job with that note.

    Raises BadFrame.
    """
    if not path.is_file():
        raise BadFrame(Fault.MISSING)
    try:
        stamps = read_stamps(path)
    except FormatError as error:
        raise BadFrame(Fault.DAMAGED) from error
    if stamps.get("Note") != note:
        raise BadFrame(Fault.FOREIGN)
    if (frame := _number(stamps)) != number:
        raise BadFrame(Fault.SWAPPED, f"{number} is {frame}")
    return stamps


def _number(stamps: dict[str, str]) -> int:
    word = stamps.get("Frame", "")
    return int(word) if word.isdecimal() and len(word) <= _DIGITS else 0


def _strays(files: FarmFiles, manifest: FarmManifest) -> Iterable[str]:
    """Other files in the folder that look like frames: copies under another name, or foreign pictures."""
    known = {files.frame(number).name for number in range(1, manifest.sheets + 1)}
    for path in sorted(files.frames.glob("*.exr")):
        if path.name in known:
            continue
        try:
            stamps = read_stamps(path)
        except FormatError:
            stamps = {}
        ours = stamps.get("Note") == manifest.note
        yield f"{path.name} ({f'a duplicate of {_number(stamps)}' if ours else Fault.FOREIGN})"


def faults_told(bad: Mapping[int, BadFrame]) -> str:
    """What is wrong with frames, by their numbers, in a few words."""
    said = []
    for fault in Fault:
        frames = [number for number, found in bad.items() if found.fault is fault]
        details = dict.fromkeys(found.detail for found in bad.values() if found.fault is fault)
        told = ", ".join(filter(None, details))
        if frames:
            said.append(f"{frame_list(frames)} {fault}{f' ({told})' if told else ''}")
    return "; ".join(said)


def _complaint(
    files: FarmFiles, manifest: FarmManifest, bad: Mapping[int, BadFrame], strays: list[str]
) -> str:
    parts = []
    if bad:
        blender, python = commands(files, bad)
        parts.append(
            f"{len(bad)} of {manifest.sheets} frames cannot be used: {faults_told(bad)}; "
            f"render just those: {blender}   or, with the bpy module: {python}"
        )
    if strays:
        parts.append(f"remove from {files.frames} what is no frame of this job: {', '.join(strays)}")
    return "; ".join(parts)


def _warn_of_versions(versions: set[str], manifest: FarmManifest) -> None:
    """Warn of frames by another version of Blender, whose noise differs; 4.5's frames do not name theirs."""
    own = re.match(r"\d+\.\d+\.\d+", manifest.facts.blender)
    for version in sorted(versions):
        if own is not None and version and own[0] not in version:
            log.warning(
                "frames were rendered by %s, and prepared by Blender %s: the atlas is not bit by bit what "
                "one machine would bake",
                version,
                manifest.facts.blender,
            )
