# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings made into what the library takes: checked, and no longer Blender's."""

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
from ..export.spec import Target
from ..scene.lamps import each_light
from ..scene.scratch import find_view_layer
from .preferences import preferred
from .surfaces import bakes_of, may_lack_parts, shared_name
from .values import open_layout_of, spec_of, values_of, values_with

if TYPE_CHECKING:
    from ..job import Choice, OpenLayout
    from ..job.preflight import Foresight
    from ..job.variants import Bake

__all__ = ["BakeRequest", "has_folder", "output_folder", "spec_of", "values_of", "values_with"]

_HOPELESS = 1 << 30  # errors, where nothing can be baked


@dataclass(frozen=True)
class BakeRequest:
    """A bake as it was asked for: what, how, and where to. Objects may have a `shared` atlas of that name.

    With an `open_layout` the specification has layout buckets until the layout is settled for each object.
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
        """What `values`, by the names of the settings, ask for. Raises InputError for what cannot be."""
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

    def foreseen(self, scene: bpy.types.Scene, names: Iterable[str], patience: float) -> Foresight:
        """What can be said of baking these objects beforehand; `patience` is in seconds."""
        from ..job.output_collisions import check_files_apart
        from ..job.preflight import Foresight, foresee

        errors: dict[str, None] = {}
        warnings: dict[str, None] = {}
        since = monotonic()
        try:
            bakes = self.bakes(scene, tuple(names), guess=True)
            check_files_apart(bakes, self.folder, self.preview)
        except InputError as error:
            return Foresight((str(error),))
        for spec, group in groupby(bakes, key=itemgetter(1)):
            found = foresee(
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
        return Foresight(tuple(errors), tuple(warnings))

    def bakes(
        self, scene: bpy.types.Scene, names: Sequence[str], *, guess: bool = False
    ) -> tuple[tuple[str, BakeSpec], ...]:
        """What is baked of these objects, by the names of the atlases; errors as in `choices`."""
        return tuple((name, choice.spec) for name, choice in self.choices(scene, names, guess=guess))

    def choices(
        self, scene: bpy.types.Scene, names: Sequence[str], *, guess: bool = False
    ) -> tuple[tuple[str, Choice], ...]:
        """What is baked, each with its layout; `surfaces.bakes_of` says how, `job.choose_layout` in which.

        Where it goes on with several objects, variants or parts, those that are not finished. Raises
        InputError where all are, unless parts are a `guess` that may lack some; where lamps have no atlases
        of their own, and where there are none.
        """
        chosen = self._chosen(scene, names, guess)
        wanted = self._left(scene, names, tuple(chosen), guess) if self._goes_on(scene, names) else chosen
        return tuple((bake[0], chosen[bake]) for bake in wanted)

    def _chosen(self, scene: bpy.types.Scene, names: Sequence[str], guess: bool) -> dict[Bake, Choice]:
        """All variants and parts, finished or not, each with its layout."""
        from ..job import choose_layouts

        asked = self._asked(scene, names, guess)
        return choose_layouts(
            scene, asked, self.open_layout, self.folder, resume=self.resume, overwrite=self.overwrite
        )

    def _left(
        self, scene: bpy.types.Scene, names: Sequence[str], asked: tuple[Bake, ...], guess: bool
    ) -> tuple[Bake, ...]:
        """Those of several objects, variants or parts that are not finished; errors as in `choices`."""
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
        """What to know of bakes that going on leaves out; empty if nothing. Raises InputError as `bakes`."""
        from ..job.variants import passed_over

        if not (self._goes_on(scene, names) and (self.spec.accumulate or self.spec.refresh)):
            return ""  # without looking for parts
        asked = tuple(self._chosen(scene, names, guess=False))
        return passed_over(asked, self._left(scene, names, asked, guess=False))

    def layouts_told(self, scene: bpy.types.Scene, names: Sequence[str]) -> tuple[str, ...]:
        """A line for each object that gets layout buckets though it was not chosen. Raises InputError."""
        choices = self.choices(scene, names, guess=True)
        return tuple(dict.fromkeys(choice.told(name) for name, choice in choices if choice.reason))

    def _goes_on(self, scene: bpy.types.Scene, names: Sequence[str]) -> bool:
        """Whether it goes on with those of several objects, variants or parts that are left to do."""
        split = self.spec.split is not None and self.spec.part is None
        several = len(self.specs(scene)) > 1 or split or (len(names) > 1 and self.shared is None)
        return self.resume and not self.overwrite and several

    def _asked(
        self, scene: bpy.types.Scene, names: Sequence[str], guess: bool
    ) -> tuple[tuple[str, BakeSpec], ...]:
        """All variants and parts, finished or not."""
        specs = self.specs(scene)
        return tuple(bake for spec in specs for bake in bakes_of(scene, names, spec, self.shared, guess))

    def specs(self, scene: bpy.types.Scene) -> tuple[BakeSpec, ...]:
        """The bake in all its variants. Raises InputError as `bakes` does."""
        if self.each_lamp:
            lights = each_light(find_view_layer(scene, None))
            return tuple(replace(self.spec, lights=one) for one in lights)
        return of_frames(self.spec, self.frames) or (self.spec,)

    def remedies(self, scene: bpy.types.Scene, names: Sequence[str], patience: float) -> dict[str, int]:
        """Settings that, switched, would leave fewer errors than are foreseen now, and how many."""
        present = self._errors_with((), scene, names, patience)
        for ways in ((("overwrite",), ("resume",)), (("overwrite", "resume"),)):
            left = {way: self._errors_with(way, scene, names, patience) for way in ways}
            found = {name: count for way, count in left.items() for name in way if count < present}
            if not self._goes_on_with_some(scene, names):  # but with a finished one, for what it lacks
                found.pop("resume", None)
            if found:
                return found
        return {}

    def forgets(self, scene: bpy.types.Scene, names: Sequence[str], patience: float) -> bool:
        """Whether it would throw away an unfinished bake that one could go on with."""
        if self.resume or not self.overwrite or not self._unfinished(scene, names):
            return False
        return self._errors_with(("resume",), scene, names, patience) == 0

    def _unfinished(self, scene: bpy.types.Scene, names: Sequence[str]) -> int:
        """How many of its bakes were begun and not finished."""
        from ..bake.key import is_unfinished
        from ..job.files import OutputFiles

        try:
            bakes = self.bakes(scene, names, guess=True)
        except InputError:
            return 0
        files = [OutputFiles.of(name, spec, self.folder, self.preview) for name, spec in bakes]
        return sum(is_unfinished(one.unfinished) for one in files)

    def _goes_on_with_some(self, scene: bpy.types.Scene, names: Sequence[str]) -> bool:
        """Whether resuming goes on with an unfinished bake, or with those of several that are not there."""
        anew = replace(self, resume=True, overwrite=False)
        try:
            return anew._goes_on(scene, names) or self._unfinished(scene, names) > 0  # noqa: SLF001
        except InputError:  # there is nothing to bake
            return False

    def _errors_with(
        self, switched: Sequence[str], scene: bpy.types.Scene, names: Sequence[str], patience: float
    ) -> int:
        values: dict[str, Any] = {name: not getattr(self, name) for name in switched}
        request = replace(self, **values)
        try:
            request.bakes(scene, names, guess=True)
        except InputError:  # one error, but of all: to go on where all is finished is no remedy
            return _HOPELESS if switched else 1
        return len(request.foreseen(scene, names, patience).errors)


def output_folder(directory: str, instead: Path | None) -> Path:
    """The folder that `directory` names; `instead` is for files that were never saved.

    Raises InputError where there is none.
    """
    if directory.strip() and (bpy.data.filepath or not directory.startswith("//")):
        return Path(bpy.path.abspath(directory))
    if instead is not None:
        return instead
    if not directory.strip():
        raise InputError("no output folder is chosen: choose one")
    raise InputError("this file was never saved: save it, or choose a folder for its bakes")


def has_folder(values: Mapping[str, Any]) -> bool:
    """Whether bakes asked for by `values` have a place to go to."""
    try:
        output_folder(values["directory"], preferred().output)
    except InputError:
        return False
    return True
