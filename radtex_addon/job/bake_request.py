# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A request for one or more bakes, from the command line or the panel."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import bpy

from ..core.errors import InputError
from ..core.sampler import Filter
from ..scene.lights.lamps import ALL, EACH, each_light
from ..scene.scratch import find_view_layer
from ..settings.bake_names import OBJECT, fill
from ..settings.frame_numbers import of_frames
from ..settings.presets import quality_of
from ..settings.spec import BakeSpec
from ..store.bake_folder import BakeFolder, FolderState
from ..store.ownership import Overwrite, open_blend
from ..textures.export_spec import Target
from .about_texels import with_about_texels, with_texels_of_several
from .layout_choice import OpenLayout
from .split_parts import guessed_parts, part_specs
from .variants import Bake, named_in


def with_quality(spec: BakeSpec, wish: OpenLayout | None) -> BakeSpec:
    """The specification with its name's `{quality}`: the preset that the settings are, before any is adapted.

    `wish`: as `open_layout` of a `BakeRequest`.
    """
    if spec.bake_name == OBJECT:
        return spec
    cells = None if wish is None else wish.cells
    quality = quality_of(spec, automatic=wish is not None, cells=cells)
    return replace(spec, bake_name=fill(spec.bake_name, {"quality": quality}))


@dataclass(frozen=True)
class BakeRequest:
    """Bakes of `objects`, by name, into `folder`: each for every frame and every entry of `lights`.

    If `shared` is not None the objects share one atlas of that name; with `open_texels`, which nobody named,
    it has about as many texels as they would have had. With `assets`, objects that touch are to be baked into
    one atlas (`asset_requests`), with `as_scene` all of them into a few (`requests_of`). An entry of
    `lights` names lamps, or is (EACH,) for every lamp alone, or (ALL,) for all light together. If
    `open_layout` is not None, `spec` has layout buckets until a layout is chosen for each object. `preview`
    is the filter of the previews to save, `exports` are made of every bake. `overwrite` and `resume` are as
    in `bake_steps`. With `only_changed`, bakes that are not there, unfinished or changed (`changes`) are
    made, and replace what is there; `surroundings` says whether neighbours and lamps count as changes.
    `overwrite_any` also replaces better bakes and those of other files. `blend` is the file that the scene is
    of, None for the open one. `passes` are made in all, each with as many samples. `former` are folders where
    earlier versions may have left an unfinished bake: resuming goes on there.
    """

    objects: tuple[str, ...]
    spec: BakeSpec
    folder: Path
    shared: str | None = None
    preview: Filter | None = None
    overwrite: bool = False
    resume: bool = False
    exports: tuple[Target, ...] = ()
    frames: tuple[int, ...] = ()
    lights: tuple[tuple[str, ...], ...] = ()
    open_layout: OpenLayout | None = None
    only_changed: bool = False
    surroundings: bool = True
    overwrite_any: bool = False
    blend: Path | None = None
    passes: int = 1
    former: tuple[Path, ...] = ()
    open_texels: bool = False
    assets: bool = False
    as_scene: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "spec", with_quality(self.spec, self.open_layout))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the atlases: one for each object, or one that all share."""
        return self.objects if self.shared is None else (self.shared,)

    def may_replace(self, earlier: bool) -> Overwrite:
        """Whether a bake may replace an `earlier` one of the same thing, and what else the request allows."""
        blend = open_blend() if self.blend is None else self.blend
        return Overwrite(earlier, earlier and self.overwrite_any, blend, self.passes)

    def place(self, bake: Bake) -> BakeFolder:
        """Where one of the bakes goes, and what is there of it."""
        return BakeFolder(*bake, self.folder, self.saves_preview)

    @property
    def saves_preview(self) -> bool:
        return self.preview is not None

    def specs(self, scene: bpy.types.Scene) -> tuple[BakeSpec, ...]:
        """A specification for each frame and each entry of `lights`, without duplicates.

        Raises InputError if EACH finds no lamp.
        """
        spec = self.spec
        if self.shared is not None:
            spec = replace(spec, objects=self.objects)
            spec = with_texels_of_several(scene, spec) if self.open_texels else spec
        framed = of_frames(spec, self.frames) or (spec,)
        lit: dict[tuple[str, ...], None] = {}
        for names in self.lights:
            found = each_light(find_view_layer(scene, None)) if names == (EACH,) else (names,)
            lit |= dict.fromkeys(() if one == (ALL,) else one for one in found)
        return tuple(replace(each, lights=one) for each in framed for one in lit) if lit else framed

    def asked(self, scene: bpy.types.Scene, *, guess: bool = False) -> tuple[Bake, ...]:
        """Atlas name and specification of every frame, light and part, finished or not.

        With a texel density, the specifications have an estimate of the texels.

        Parts are found by evaluating the objects; with `guess` they are taken from the material slots, which
        is quick. Raises InputError for a shared atlas without a name, and for objects that cannot be split.
        """
        if self.shared is not None and not self.shared.strip():
            raise InputError("the atlas that objects share has no name: give it one")
        split = guessed_parts if guess else part_specs
        return tuple(
            (name, named_in(scene, with_about_texels(scene, name, part), self.blend))
            for spec in self.specs(scene)
            for name in self.names
            for part in split(scene, name, spec)
        )

    def where_begun(self, scene: bpy.types.Scene, *, guess: bool = False) -> BakeRequest:
        """The same, into the `former` folder that has an unfinished bake of it, if resuming needs that.

        The request's own folder goes first, if it has any of the bakes.
        """
        if not (self.resume and self.former):
            return self
        bakes = self.asked(scene, guess=guess)
        if any(BakeFolder(*bake, self.folder).state is not FolderState.NOTHING for bake in bakes):
            return self
        for place in self.former:
            if any(BakeFolder(*bake, place).state is FolderState.UNFINISHED for bake in bakes):
                return replace(self, folder=place)
        return self

    def is_of_several(self, scene: bpy.types.Scene) -> bool:
        """Whether these are, or may be, several atlases: resuming then bakes those that are not finished."""
        return self.spec.split is not None or max(len(self.names), len(self.specs(scene))) > 1
