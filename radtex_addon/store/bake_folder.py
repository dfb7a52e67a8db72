# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One bake in an output folder: what is there of it, whether it may be written, and what is to be said.

The files tell the state. Key, pieces and lock are in the folder `<name>.<kind>.radtex-unfinished`:

    nothing  -- open -->                       unfinished -+
    finished -- open, accumulate, refresh -->  adding     -+-- publish -->  written -- remove -->  finished
    finished -- open, overwrite -->            replaced   -+
    finished -- delete_bake -->                nothing

    nothing     no sidecar and no key
    unfinished  a key, with pieces beside it; with no facts in it, the bake is only announced
    adding      unfinished, beside a finished bake that it adds to
    replaced    unfinished, beside a finished bake of which nothing stays
    written     unfinished, with the result in the key: files get their final names, then preview and exports
    finished    a sidecar and no key
    damaged     a key that cannot be read: only overwriting goes on. A sidecar that cannot be read is no bake

A process that is killed leaves the state that it was in, and `open` with `resume` goes on from there. What a
killed `remove` leaves is no bake, and `clear_left` deletes it. Until `publish` the files of a finished bake
stay as they are. One process at a time holds the lock; others are refused.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass
from enum import Enum
from functools import cached_property
from pathlib import Path

import bpy

from ..core.errors import FormatError, InputError
from ..core.messages import Setting, do, leave_out
from ..core.near_digest import DIGEST
from ..export.exporting import check_writer
from ..export.folder import check_out, is_whole
from ..formats.disk.atomic import check_absent
from ..formats.disk.regular import digest
from ..formats.sidecar import part_in
from ..formats.sidecar_file import read_facts
from ..forms import form_for, form_in
from ..settings.forms import FormTraits
from ..settings.kinds import Layout
from ..settings.kinds import form_in as form_of_layout
from ..settings.spec import BakeSpec, key_facts
from ..settings.targets import check_target
from ..textures.export_spec import Target
from ..version import VERSION
from . import checkpoint as checkpoints
from .checkpoint import Checkpoint
from .checkpoint_files import is_unfinished, read_key
from .output_files import BakeOutput, OutputFiles, earlier_images, images_of
from .ownership import ELSEWHERE, Overwrite, check_same_subject, is_of_spec, reasons_to_ask


class FolderState(Enum):
    """What there is by a bake's name; UNFINISHED also beside a finished bake, as the picture above has it."""

    NOTHING = "nothing"
    UNFINISHED = "unfinished"
    FINISHED = "finished"


@dataclass(frozen=True)
class BakeFolder:
    """The bake called `name`, of `spec`, in the output folder `out`, with a `preview` or without."""

    name: str
    spec: BakeSpec
    out: Path
    preview: bool = False

    @cached_property
    def files(self) -> OutputFiles:
        """The names of its files."""
        return OutputFiles.of(self.name, self.spec, self.out, self.preview)

    # What is there?

    @property
    def state(self) -> FolderState:
        if is_unfinished(self.files.unfinished):
            return FolderState.UNFINISHED
        return FolderState.FINISHED if self.files.sidecar.is_file() else FolderState.NOTHING

    def is_finished(self) -> bool:
        """Whether a finished bake of this specification is there; False if its sidecar cannot be read."""
        if self.state is not FolderState.FINISHED:
            return False
        try:
            facts = read_facts(self.files.sidecar)
            form = form_in(facts)
            is_of_form = form is form_for(self.spec)
            return is_of_form and is_of_spec(facts, self.name, self.spec) and form.is_of(facts, self.spec)
        except FormatError:
            return False

    def only_completes(self, overwrite: bool, resume: bool) -> bool:
        """Whether resuming finds a finished bake, so that only a missing preview or exports are made."""
        return resume and not overwrite and self.state is FolderState.FINISHED

    def misses_preview(self) -> bool:
        """Whether a preview is wanted but missing."""
        return self.files.preview is not None and not self.files.preview.is_file()

    def missing_exports(self, exports: Collection[Target]) -> tuple[Target, ...]:
        """Those of the `exports` whose folder is missing or incomplete."""
        return tuple(target for target in exports if not is_whole(self.files.export(target)))

    def begun_facts(self) -> Mapping[str, str]:
        """What an unfinished bake was said to be of. Raises InputError for a key that cannot be read."""
        return read_key(self.files.unfinished).facts

    def stored_as(self) -> tuple[FormTraits, int] | None:
        """The form of the bake that is there, and the cells along a bucket's side; None if not known.

        Raises InputError for the key of an unfinished bake that cannot be read.
        """
        if self.state is FolderState.UNFINISHED:
            begun = self.begun_facts()
            try:
                return form_of_layout(Layout(begun["layout"])), int(begun["bucket"])
            except (KeyError, ValueError):
                return None
        try:
            facts = read_facts(self.files.sidecar)
            form, bucket = form_in(facts).traits, facts.values.get("bucket")
        except FormatError:
            return None
        return (form, bucket) if isinstance(bucket, int) else None

    # May I write here? What must I say?

    def check_may_write(
        self, overwrite: Overwrite, resume: bool = False, exports: Collection[Target] = ()
    ) -> None:
        """Make sure, before a bake, that it and its `exports` replace nothing that they may not.

        Raises InputError, which says what to do; also if the bake to `resume` differs, or is finished with
        its preview and its exports.
        """
        files = self.files
        if files.unfinished.is_symlink() or (files.unfinished.exists() and not files.unfinished.is_dir()):
            raise InputError(  # pieces would be written and deleted behind it
                f"{files.unfinished} is a file, or a link, where a folder must go: move it, or choose "
                "another folder"
            )
        check_same_subject(self.name, self.spec, files)
        self.check_exports(exports, bool(overwrite), resume)  # before errors that overwriting solves
        if self._adds and not files.sidecar.exists():
            done = "accumulate onto" if self.spec.accumulate else "refresh"
            raise InputError(f"{files.sidecar} is not there to {done}: bake it first, without that")
        if self.state is FolderState.UNFINISHED:
            self._check_unfinished(overwrite, resume)
            return
        if resume:
            self.clear_left()  # of a bake that was killed while it cleaned up
        if resume and not overwrite and files.sidecar.exists():
            lacks = self.misses_preview() or self.missing_exports(exports)
            if lacks and not self._adds and self.is_finished():
                return
            raise self._nothing_unfinished()
        self._check_replaced(overwrite, self._adds)

    def check_exports(self, exports: Collection[Target], overwrite: bool, resume: bool) -> None:
        """Check before a bake what would make its exports fail after it.

        Raises InputError for a target that does not support the bake's kind or that this installation cannot
        write, and for a folder that would be lost unless the bake to `resume` may have written it.
        """
        may = checkpoints.replaced_by(self.files.unfinished) if resume else frozenset()
        was_finished = self.only_completes(overwrite, resume)
        for target in exports:
            place = self.files.export(target)
            check_target("the bake", self.spec.kind, target)
            if was_finished and is_whole(place):
                continue  # it is not exported again
            check_writer(target)
            check_out(place, place.parent, overwrite or was_finished or place.name in may)

    def reasons_to_ask(self, overwrite: Overwrite) -> tuple[str, ...]:
        """Why somebody may want to keep the bake that is there, in sentences; empty if nothing."""
        return reasons_to_ask(self.spec, self.files, overwrite)

    # Write

    def open(
        self, overwrite: Overwrite, resume: bool = False, exports: Collection[Target] = ()
    ) -> Checkpoint:
        """Open the checkpoint of the bake; it lasts until the `exports` are made, too.

        Without `resume`, an unfinished bake whose files are all written is published first: no half of it is
        added to or replaced. At its first piece the checkpoint checks again that it replaces no files that it
        may not. Raises InputError if the bake to `resume` differs, and as `announce`.
        """
        files, spec = self.files, self.spec
        if not resume:
            checkpoints.publish_earlier(files.unfinished)
        goes_on = resume and (is_unfinished(files.unfinished) or files.sidecar.exists())
        earlier: str | None = None

        def check() -> None:
            if not goes_on:
                self._check_meanwhile(overwrite, earlier)

        replaces = self._replaces(exports)
        checkpoint = Checkpoint(files.unfinished, resume, replaces, check, overwrite.blend.name)
        versions = {"RadTex's version": VERSION, "Blender's version": bpy.app.version_string}
        checkpoint.set_facts({"object": self.name, **versions, **key_facts(spec)})
        # Once all files are written, the atlas may be replaced already.
        if self._adds and checkpoint.made is None and files.atlas.is_file():
            earlier = digest(files.atlas)
            checkpoint.set_facts({"the atlas that is there": DIGEST + earlier})
        return checkpoint

    def publish(self, checkpoint: Checkpoint, made: BakeOutput) -> None:
        """Move all files to their final names, and delete images of an earlier bake that this one lacks.

        These are images that this layout may have, and the earlier bake's, which may be in another layout.
        """
        self._publish(checkpoint, made, images_of(self.files.sidecar))

    def publish_again(self, checkpoint: Checkpoint, was_finished: bool) -> BakeOutput | None:
        """Publish a bake whose files were all written before, and return its result; else None."""
        told = BakeOutput.known(self.files).told() if was_finished else checkpoint.made
        if told is None:
            return None
        made = BakeOutput.of(told, self.files)
        self._publish(checkpoint, made, earlier_images(told, self.files))
        return made

    def announce(self, exports: Collection[Target], blend: str) -> None:
        """Mark the bake as unfinished before it starts, so that resuming a killed run of several includes it.

        `blend` is the name of the .blend that is baked. Raises InputError where a process works on it,
        BakeError where the system refuses.
        """
        checkpoints.announce(self.files.unfinished, self._replaces(exports), blend)

    def clear_left(self) -> None:
        """Remove what was left if a process was killed while it cleaned up after a bake. Raises BakeError."""
        checkpoints.remove_left(self.files.unfinished)

    @property
    def _adds(self) -> bool:
        return self.spec.incremental

    def _replaces(self, exports: Collection[Target]) -> list[Path]:
        return [*self.files.own, *(self.files.export(target) for target in exports)]

    def _publish(self, checkpoint: Checkpoint, made: BakeOutput, earlier: Collection[Path]) -> None:
        checkpoint.publish(made.told(earlier))
        for path in {*self.files.images, *earlier} - set(made.files.images):
            path.unlink(missing_ok=True)

    def _check_unfinished(self, overwrite: Overwrite, resume: bool) -> None:
        """As `check_may_write`, where there is an unfinished bake."""
        files = self.files
        checkpoints.check_free(files.unfinished)
        if not resume and not overwrite and not checkpoints.is_announced(files.unfinished):
            raise self._unfinished()
        if resume:
            self.open(overwrite, resume)  # raises if it differs
        else:
            self._check_replaced(overwrite, self._adds)
        may = checkpoints.replaced_by(files.unfinished) if resume else frozenset()
        check_absent([path for path in files.own if path.name not in may], bool(overwrite) or self._adds)
        check_absent([path for path in files.own if path.name in may], overwrite=True)

    def _check_meanwhile(self, overwrite: Overwrite, earlier: str | None) -> None:
        """Check again, now with the lock held, as other processes may have written files since.

        `earlier` is the digest that the atlas to accumulate onto or to refresh had. Raises InputError.
        """
        announced = checkpoints.is_announced(self.files.unfinished)
        if self.state is FolderState.UNFINISHED and not (overwrite or announced):
            raise self._unfinished()
        if earlier is not None and digest(self.files.atlas) != earlier:
            raise InputError(f"{self.files.atlas} has changed since this bake began: start it again")
        check_same_subject(self.name, self.spec, self.files)
        self._check_replaced(overwrite, earlier is not None)

    def _check_replaced(self, overwrite: Overwrite, adds: bool) -> None:
        """Make sure that a bake that does not go on with another replaces nothing that it may not.

        If parts share the preview, an existing one must be of this object's parts. Raises InputError.
        """
        check_absent(self.files.own, bool(overwrite) or adds)
        if not overwrite.any and (reasons := self.reasons_to_ask(overwrite)):
            all_the_same = do("replace it all the same", Setting.OVERWRITE_ANY)
            raise InputError("; and ".join(reasons), all_the_same, ELSEWHERE)
        shown = self.files.preview
        if shown is None or self.files.preview_is_own or overwrite or not shown.exists():
            return
        if not any(self._is_sibling(path) for path in shown.parent.glob(f"*.{self.spec.kind}.json")):
            raise InputError(
                f"{shown} is already there, and shows no {self.spec.kind} of '{self.name}'",
                do("overwrite it", Setting.OVERWRITE),
                ELSEWHERE,
            )

    def _is_sibling(self, sidecar: Path) -> bool:
        """Whether the sidecar is of a part that shares its preview with this bake."""
        try:
            facts = read_facts(sidecar)
            part = part_in(facts)
        except FormatError:
            return False
        found = (facts.values.get("object"), facts.values.get("frame"), facts.values.get("lights", []))
        asked = (self.name, self.spec.frame, list(self.spec.lights))
        return part is not None and part.by == self.spec.split and found == asked

    def _unfinished(self) -> InputError:
        return InputError(
            f"{self.files.unfinished} holds an unfinished bake",
            do("go on with it", Setting.RESUME),
            do("begin anew", Setting.OVERWRITE),
        )

    def _nothing_unfinished(self) -> InputError:
        sidecar = self.files.sidecar
        found = f"{sidecar} is already there, and nothing of object '{self.name}' is unfinished"
        if self.spec.refresh:
            return InputError(found, leave_out(Setting.RESUME, to="to refresh it"))
        if self.spec.accumulate:
            with suppress(FormatError):
                samples = read_facts(sidecar).whole_number("samples", 1)
                more = leave_out(Setting.RESUME, to="for more")
                return InputError(f"{found}; it has {samples} samples a cell", more)
        return InputError(found, do("bake it anew", Setting.OVERWRITE))
