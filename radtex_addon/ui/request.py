# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake request made from the settings: validated, and independent of Blender's properties."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

import bpy

from ..bake.frames import of_frames, parse_frames
from ..bake.spec import BakeSpec
from ..core.errors import InputError
from ..scene.lights.lamps import each_light
from ..scene.scratch import find_view_layer
from ..textures.spec import Target
from .preferences import preferred
from .surfaces import bakes_of, may_lack_parts, shared_name
from .values import open_layout_of, spec_of, values_of, values_with

if TYPE_CHECKING:
    from ..job import Choice, OpenLayout
    from ..job.preflight import Preflight
    from ..job.variants import Bake

__all__ = ["BakeRequest", "has_folder", "output_folder", "spec_of", "values_of", "values_with"]

_HOPELESS = 1 << 30  # number of errors to report if nothing can be baked


@dataclass(frozen=True)
class BakeRequest:
    """A bake as the user requested it: specification, output and variants.

    `shared` is the name of the atlas that all objects share; None if each has its own. If `open_layout` is
    not None, `spec` has layout buckets until the layout is chosen for each object.
    """

    spec: BakeSpec
    folder: Path
    preview: bool
    overwrite: bool
    resume: bool
    targets: tuple[Target, ...]
    shared: str | None = None
    frames: tuple[int, ...] = ()
    each_lamp: bool = False
    open_layout: OpenLayout | None = None

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> BakeRequest:
        """The request for `values` (by setting name). Raises InputError for invalid settings."""
        spec = spec_of(values)
        targets = tuple(target for target in Target if target.value in values["export_targets"])
        if targets and not values["preview"]:
            raise InputError("an export is made from the preview: switch Preview on, or the export off")
        return cls(
            spec=spec,
            folder=output_folder(values["directory"], preferred().output),
            preview=values["preview"],
            overwrite=values["overwrite"],
            resume=values["resume"],
            targets=targets,
            shared=shared_name(values, spec),
            frames=parse_frames(values["frames"]) if values["variants"] == "frames" else (),
            each_lamp=values["variants"] == "lamps",
            open_layout=open_layout_of(values),
        )

    def preflight(self, scene: bpy.types.Scene, names: Iterable[str], patience: float) -> Preflight:
        """Errors and warnings known before baking these objects; stops looking after `patience` seconds."""
        from ..job.output_collisions import check_files_apart
        from ..job.preflight import Preflight, run_preflight

        errors: dict[str, None] = {}
        warnings: dict[str, None] = {}
        since = monotonic()
        try:
            bakes = self.bakes(scene, tuple(names), guess=True)
            check_files_apart(bakes, self.folder, self.preview)
        except InputError as error:
            return Preflight((str(error),))
        for spec, group in groupby(bakes, key=itemgetter(1)):
            found = run_preflight(
                scene,
                (name for name, _ in group),
                spec,
                self.folder,
                preview=self.preview,
                overwrite=self.overwrite,
                resume=self.resume,
                targets=self.targets,
                patience=patience,
            )
            errors |= dict.fromkeys(found.errors)
            warnings |= dict.fromkeys(found.warnings)
            if monotonic() - since > patience:
                break
        return Preflight(tuple(errors), tuple(warnings))

    def bakes(
        self, scene: bpy.types.Scene, names: Sequence[str], *, guess: bool = False
    ) -> tuple[tuple[str, BakeSpec], ...]:
        """Atlas name and specification of each bake of these objects; raises as `choices` does."""
        return tuple((name, choice.spec) for name, choice in self.choices(scene, names, guess=guess))

    def choices(
        self, scene: bpy.types.Scene, names: Sequence[str], *, guess: bool = False
    ) -> tuple[tuple[str, Choice], ...]:
        """Atlas name and `Choice` of each bake, from `surfaces.bakes_of` and `job.choose_layout`.

        When resuming several objects, variants or parts: only the unfinished ones. Raises InputError if all
        are finished, unless a `guess` may have missed parts; if lamps cannot be baked one by one, or there
        are none.
        """
        chosen = self._chosen(scene, names, guess)
        wanted = self._left(scene, names, tuple(chosen), guess) if self._goes_on(scene, names) else chosen
        return tuple((bake[0], chosen[bake]) for bake in wanted)

    def _chosen(self, scene: bpy.types.Scene, names: Sequence[str], guess: bool) -> dict[Bake, Choice]:
        """The layout choice of every variant and part, finished or not."""
        from ..job import choose_layouts

        asked = self._asked(scene, names, guess)
        return choose_layouts(
            scene, asked, self.open_layout, self.folder, resume=self.resume, overwrite=self.overwrite
        )

    def _left(
        self, scene: bpy.types.Scene, names: Sequence[str], asked: tuple[Bake, ...], guess: bool
    ) -> tuple[Bake, ...]:
        """The unfinished bakes among `asked`; raises as `choices` does."""
        from ..job.variants import left_to_do

        unsure = guess and may_lack_parts(scene, names, self.spec)
        try:
            found = left_to_do(asked, self.folder, self.preview, self.targets)
        except InputError:
            if not unsure:
                raise
            found = ()
        if asked and not found and not unsure:
            what = "objects" if len(names) > 1 else "variants"
            raise InputError(f"all {what} are finished: leave --resume out, and bake anew (--overwrite)")
        return found

    def left_out(self, scene: bpy.types.Scene, names: Sequence[str]) -> str:
        """A remark on the bakes that resuming skips; empty if none. Raises InputError as `bakes`."""
        from ..job.variants import passed_over

        if not (self._goes_on(scene, names) and (self.spec.accumulate or self.spec.refresh)):
            return ""  # decided without evaluating objects to find their parts
        asked = tuple(self._chosen(scene, names, guess=False))
        return passed_over(asked, self._left(scene, names, asked, guess=False))

    def layouts_told(self, scene: bpy.types.Scene, names: Sequence[str]) -> tuple[str, ...]:
        """A line for each object for which automatic chose layout buckets, and why. Raises InputError."""
        choices = self.choices(scene, names, guess=True)
        return tuple(dict.fromkeys(choice.told(name) for name, choice in choices if choice.reason))

    def _goes_on(self, scene: bpy.types.Scene, names: Sequence[str]) -> bool:
        """Whether this resumes several objects, variants or parts: then only unfinished ones are baked."""
        split = self.spec.split is not None and self.spec.part is None
        several = len(self.specs(scene)) > 1 or split or (len(names) > 1 and self.shared is None)
        return self.resume and not self.overwrite and several

    def _asked(
        self, scene: bpy.types.Scene, names: Sequence[str], guess: bool
    ) -> tuple[tuple[str, BakeSpec], ...]:
        """Atlas name and specification of every variant and part, finished or not."""
        specs = self.specs(scene)
        return tuple(bake for spec in specs for bake in bakes_of(scene, names, spec, self.shared, guess))

    def specs(self, scene: bpy.types.Scene) -> tuple[BakeSpec, ...]:
        """The specification of each variant (frame or lamp). Raises InputError as `bakes` does."""
        if self.each_lamp:
            lights = each_light(find_view_layer(scene, None))
            return tuple(replace(self.spec, lights=one) for one in lights)
        return of_frames(self.spec, self.frames) or (self.spec,)

    def remedies(self, scene: bpy.types.Scene, names: Sequence[str], patience: float) -> dict[str, int]:
        """Settings that would reduce the number of errors if toggled, with the number of errors left."""
        present = self._errors_with((), scene, names, patience)
        for ways in ((("overwrite",), ("resume",)), (("overwrite", "resume"),)):
            left = {way: self._errors_with(way, scene, names, patience) for way in ways}
            found = {name: count for way, count in left.items() for name in way if count < present}
            if not self._goes_on_with_some(scene, names):  # no unfinished bake to resume
                found.pop("resume", None)
            if found:
                return found
        return {}

    def forgets(self, scene: bpy.types.Scene, names: Sequence[str], patience: float) -> bool:
        """Whether this would discard an unfinished bake that could be resumed."""
        if self.resume or not self.overwrite or not self._unfinished(scene, names):
            return False
        return self._errors_with(("resume",), scene, names, patience) == 0

    def _unfinished(self, scene: bpy.types.Scene, names: Sequence[str]) -> int:
        """How many of the requested bakes were started and not finished."""
        from ..bake.key import is_unfinished
        from ..job.files import OutputFiles

        try:
            bakes = self.bakes(scene, names, guess=True)
        except InputError:
            return 0
        files = [OutputFiles.of(name, spec, self.folder, self.preview) for name, spec in bakes]
        return sum(is_unfinished(one.unfinished) for one in files)

    def _goes_on_with_some(self, scene: bpy.types.Scene, names: Sequence[str]) -> bool:
        """Whether resuming would continue an unfinished bake, or bake the missing ones of several."""
        anew = replace(self, resume=True, overwrite=False)
        try:
            return anew._goes_on(scene, names) or self._unfinished(scene, names) > 0  # noqa: SLF001
        except InputError:  # nothing can be baked
            return False

    def _errors_with(
        self, switched: Sequence[str], scene: bpy.types.Scene, names: Sequence[str], patience: float
    ) -> int:
        values: dict[str, Any] = {name: not getattr(self, name) for name in switched}
        request = replace(self, **values)
        try:
            request.bakes(scene, names, guess=True)
        except InputError:  # nothing to bake: never a remedy
            return _HOPELESS if switched else 1
        return len(request.preflight(scene, names, patience).errors)


def output_folder(directory: str, instead: Path | None) -> Path:
    """The absolute path of `directory`; `instead` if that is empty, or relative to an unsaved file.

    Raises InputError if neither can be used.
    """
    if directory.strip() and (bpy.data.filepath or not directory.startswith("//")):
        return Path(bpy.path.abspath(directory))
    if instead is not None:
        return instead
    if not directory.strip():
        raise InputError("no output folder is chosen: choose one")
    raise InputError("this file was never saved: save it, or choose a folder for its bakes")


def has_folder(values: Mapping[str, Any]) -> bool:
    """Whether `values` or the preferences name a usable output folder."""
    try:
        output_folder(values["directory"], preferred().output)
    except InputError:
        return False
    return True
