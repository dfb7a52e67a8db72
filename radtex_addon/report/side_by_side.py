# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compare objects with their bakes from one view: a path-traced picture, one with the bakes, the difference.

Cycles renders both in scratch scenes; afterwards the user's scene is as it was.

The files are half-float EXRs of light, and the difference as a PNG.
"""

from __future__ import annotations

import json
from collections.abc import Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

import bpy
import numpy as np

from ..core.errors import InputError
from ..cycles.building_blocks import render_layers
from ..cycles.capture_settings import apply_capture_settings, denoise, keep_passes
from ..cycles.device import use_device
from ..formats.containers.exr import Compression, read_render, stored_rows, write_rows
from ..formats.containers.png import encode_png
from ..formats.disk.atomic import replacing_together
from ..formats.disk.path_checks import render_path
from ..formats.disk.temporary import temporary_folder
from ..formats.sidecar import safe_name
from ..formats.sidecar_file import AnySidecar, SidecarFile, opened
from ..preview.hidden_objects import check_hideable
from ..preview.swap import copy_of, is_on, originals_rendered, switch_all_on, switch_off
from ..scene.scratch import at_frame, scene_copied, scratch_scene
from ..version import VERSION
from .gbuffer import eroded
from .metrics import Figures, Mask, Picture, compare, display
from .report_progress import ReportStep, ReportTask
from .shown import frame_of
from .sizes import check_shown
from .viewpoint import Viewpoint

GAIN = 4  # the factor of the difference
_NUMBER = 32767  # the pass index that previews have while they are rendered
_SEED = 1101
_LIMITS = {"pixels": (16, 8192), "samples": (1, 2**24)}


@dataclass(frozen=True)
class ComparisonSpec:
    """Settings of the pictures: `pixels` along the longer side, `samples` per pixel, denoised.

    Bakes that take more than `memory_mb` to show are refused. Raises InputError for numbers out of range.
    """

    pixels: int = 512
    samples: int = 64
    device: str = "auto"
    memory_mb: int | None = None

    def __post_init__(self) -> None:
        for name, (least, most) in _LIMITS.items():
            value = getattr(self, name)
            if not least <= value <= most:
                raise InputError(f"{name} {value}: give a whole number from {least} to {most}")


@dataclass(frozen=True, eq=False)
class Comparison:
    """Both pictures (H, W, 3), linear, row 0 at the bottom; `inside` (H, W) is where previews are visible.

    `figures` are measured inside.
    """

    traced: Picture
    baked: Picture
    inside: Mask
    figures: Figures

    @property
    def difference(self) -> Picture:
        """See `difference`."""
        return difference(self.traced, self.baked)


def difference(traced: Picture, baked: Picture) -> Picture:
    """The absolute difference of two pictures' display values, times GAIN, clipped to 0..1."""
    gap: Picture = np.clip(GAIN * np.abs(display(traced) - display(baked)), 0, 1)
    return gap


def compare_steps(
    scene: bpy.types.Scene,
    bakes: Mapping[bpy.types.Object, AnySidecar | None],
    eye: Viewpoint,
    spec: ComparisonSpec,
) -> Generator[ReportStep, None, Comparison]:
    """Render objects of `scene` and their bakes from the view `eye`, and compare the pictures.

    `bakes` has each object's sidecar, None if its preview is on. Bakes of a frame are rendered at that frame.
    Yields progress. Raises InputError if no object is visible or a preview cannot be shown, and as `frame_of`
    does; FormatError for files that cannot be read, BakeError if Cycles fails.
    """
    if not bakes:
        raise InputError("no object to compare: name one that was baked")
    files = {item: None if sidecar is None else opened(sidecar) for item, sidecar in bakes.items()}
    frame = frame_of(scene, files)
    for sidecar in filter(None, files.values()):
        check_hideable(sidecar, scene)
    check_shown(filter(None, files.values()), spec.memory_mb)
    with (
        temporary_folder() as folder,
        at_frame(scene, frame),
        _shown(files),
        _numbered(files),
        scratch_scene(scene) as scratch,
        use_device(scratch, spec.device),
    ):
        file = folder / "view.exr"
        yield ReportStep(ReportTask.REFERENCE, 0, 2)
        with originals_rendered(tuple(bakes)):
            traced, _ = _rendered(scratch, eye, spec, file)
        yield ReportStep(ReportTask.REFERENCE, 1, 2)
        baked, index = _rendered(scratch, eye, spec, file)
    yield ReportStep(ReportTask.COMPARE, 0, 1)
    inside: Mask = np.abs(index - _NUMBER) < 0.5
    if not eroded(inside).any():
        names = ", ".join(f"'{item.name}'" for item in bakes)
        raise InputError(f"{names}: not seen from here, or too small: turn the view towards it")
    return Comparison(traced, baked, inside, compare(baked, traced, inside, eroded(inside)))


@contextmanager
def _shown(bakes: Mapping[bpy.types.Object, SidecarFile | None]) -> Iterator[None]:
    """Within the context, switch on the previews that are off."""
    off: dict[Path, tuple[SidecarFile, list[bpy.types.Object]]] = {}
    for original, sidecar in bakes.items():
        if is_on(original):
            continue
        if sidecar is None:
            raise InputError(f"object '{original.name}' has no preview: bake it first")
        off.setdefault(sidecar.path, (sidecar, []))[1].append(original)
    ours: list[bpy.types.Object] = []
    try:
        for sidecar, sharing in off.values():
            switch_all_on(sharing, sidecar)
            ours += sharing
        yield
    finally:
        for original in ours:
            switch_off(original)


@contextmanager
def _numbered(bakes: Iterable[bpy.types.Object]) -> Iterator[None]:
    """Within the context, give the previews the pass index that marks their pixels."""
    copies = [copy for copy in map(copy_of, bakes) if copy is not None]
    before = [copy.pass_index for copy in copies]
    try:
        for copy in copies:
            copy.pass_index = _NUMBER
        yield
    finally:
        for copy, number in zip(copies, before, strict=True):
            copy.pass_index = number


def _rendered(
    scratch: bpy.types.Scene, eye: Viewpoint, spec: ComparisonSpec, file: Path
) -> tuple[Picture, Picture]:
    """Render a picture, and the pass index of the object in each pixel."""
    with scene_copied(scratch) as scene:
        apply_capture_settings(scene, spec.samples, _SEED)
        keep_passes(scene, ("use_pass_object_index",))
        denoise(scene)
        scene.camera = eye.camera()
        scene.collection.objects.link(scene.camera)
        scene.render.resolution_x, scene.render.resolution_y = eye.size(spec.pixels)
        scene.render.filepath = render_path(file)
        passes = render_layers(scene, file)
    index = next(found for name, found in passes.raw.items() if name.endswith(("IndexOB", "Object Index")))
    return passes.whole[..., :3].astype(np.float64), index[..., 0].astype(np.float64)


@dataclass(frozen=True)
class ComparisonFiles:
    """The pictures' paths: `traced` and `baked` are linear EXRs, `difference` is a PNG."""

    traced: Path
    baked: Path
    difference: Path

    @classmethod
    def of(cls, folder: Path, names: Sequence[str]) -> ComparisonFiles:
        """The files for the objects `names` in a folder: `<names>.traced.exr` and so on."""
        name = safe_name("+".join(names))
        return cls(
            folder / f"{name}.traced.exr", folder / f"{name}.baked.exr", folder / f"{name}.difference.png"
        )

    @property
    def all(self) -> tuple[Path, ...]:
        return self.traced, self.baked, self.difference


def write_comparison(found: Comparison, files: ComparisonFiles) -> None:
    """Write the pictures; an earlier comparison's are replaced, all or none. Raises BakeError."""
    with replacing_together(files.difference) as difference:
        for path, picture in ((files.traced, found.traced), (files.baked, found.baked)):
            rows, _ = stored_rows(path, picture, half=True)
            facts = {"tool": f"RadTex {VERSION}", "picture": path.suffixes[-2][1:], **asdict(found.figures)}
            write_rows(difference.with_name(path.name), rows, json.dumps(facts), Compression.ZIP)
        difference.write_bytes(encode_png(found.difference[::-1]))


def read_picture(path: Path) -> Picture:
    """A picture (H, W, 3) of light, row 0 at the bottom. Raises FormatError."""
    return read_render(path)[""].astype(np.float64)
