# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake would replace: whether it is an earlier bake of the same thing, and no better one.

A bake of another object, part, frame or lamps is never replaced, though its file has the same name. One that
is better, or of another .blend, is replaced only if that is asked for.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from ..bake.bake_title import bake_title, variant_title
from ..bake.key import known_key
from ..bake.quality import Quality
from ..bake.spec import BakeSpec, Split
from ..core.errors import FormatError, InputError
from ..core.messages import Remedy, Setting, do
from ..formats.json_reader import Facts
from ..formats.sidecar import blend_in, part_in, preview_path
from ..formats.sidecar_file import read_facts
from .bake_folders import open_blend, own_folder
from .output_files import OutputFiles

_ELSEWHERE = do("choose another folder", Setting.OUT)
_RENAME = do("rename one of them")
_ALL_THE_SAME = do("replace it all the same", Setting.OVERWRITE_ANY)


@dataclass(frozen=True)
class Overwrite:
    """Whether a bake may replace files; true if it may replace an earlier bake of the same thing.

    With `any`, too, it may replace a better one, and one of another .blend. `blend` is the path of the file
    that the scene is of, `bake_folders.UNSAVED` for none. `passes` of as many samples are made in all.
    """

    earlier: bool = False
    any: bool = False
    blend: Path = field(default_factory=open_blend)
    passes: int = 1

    def __bool__(self) -> bool:
        return self.earlier

    @classmethod
    def of(cls, overwrite: bool | Overwrite) -> Overwrite:
        """The same; what is only true or false is of the open file, and true lets any bake be replaced."""
        return overwrite if isinstance(overwrite, Overwrite) else cls(overwrite, any=overwrite)


@dataclass(frozen=True)
class _Subject:
    """What a bake is of. If several objects share its atlas, these are `shared`."""

    name: str
    shared: frozenset[str]
    part: tuple[str, str] | None
    frame: int | None
    lights: tuple[str, ...]

    @classmethod
    def of_spec(cls, name: str, spec: BakeSpec) -> _Subject:
        part = None if spec.split is None or spec.part is None else (str(spec.split), spec.part)
        return cls(name, frozenset(spec.objects), part, spec.frame, spec.lights)

    @classmethod
    def in_facts(cls, facts: Facts) -> _Subject:
        """Raises FormatError."""
        part = part_in(facts)
        return cls(
            name=facts.text("object"),
            shared=frozenset(facts.texts("objects") if "objects" in facts.values else ()),
            part=None if part is None else (part.by, part.name),
            frame=facts.whole_number("frame", 0) if "frame" in facts.values else None,
            lights=facts.texts("lights") if "lights" in facts.values else (),
        )

    def is_of_same(self, other: _Subject) -> bool:
        """Whether both are bakes of the same thing: an atlas may have got or lost some of its objects."""
        same_objects = bool(self.shared & other.shared) if self.shared and other.shared else True
        shares = bool(self.shared) == bool(other.shared)
        rest = (self.name, self.part, self.frame, self.lights)
        return shares and same_objects and rest == (other.name, other.part, other.frame, other.lights)

    def is_of_same_object(self, other: _Subject) -> bool:
        """As `is_of_same`, whatever the parts, frames and lamps."""
        return (self.name, bool(self.shared)) == (other.name, bool(other.shared))

    def __str__(self) -> str:
        """In words, such as "object 'Ball', material Gold, frame 1"."""
        part = "" if self.part is None else " ".join(self.part)
        what = "the atlas" if self.shared else "object"
        shown = bake_title(f"{what} '{self.name}'", part=part, variant=variant_title(self.frame, self.lights))
        return f"{shown} of {', '.join(sorted(self.shared))}" if self.shared else shown


def check_same_subject(name: str, spec: BakeSpec, files: OutputFiles) -> None:
    """Make sure that no bake of anything else lies where this bake's files go, finished or not.

    Files that cannot be read count as none. Raises InputError.
    """
    wanted = _Subject.of_spec(name, spec)
    there = _subject_at(files.sidecar)
    if there is not None and not there.is_of_same(wanted):
        raise _of_another(files.sidecar, there, wanted)
    _check_unfinished(files.unfinished, wanted, spec)
    if files.preview is None or not files.preview.exists():
        return
    for sidecar, other in _others_with_preview(files):
        if not other.is_of_same_object(wanted):
            raise InputError(
                f"{files.preview} is the preview of {other} ({sidecar.name}), not of {wanted}",
                _RENAME,
                _ELSEWHERE,
            )


def check_replaces_no_better(spec: BakeSpec, files: OutputFiles, overwrite: Overwrite) -> None:
    """Make sure that what is replaced is no better bake, and none of another .blend.

    Raises InputError, which says how to do it nevertheless.
    """
    if overwrite.any:
        return
    if reasons := reasons_to_ask(spec, files, overwrite):
        raise InputError("; and ".join(reasons), _ALL_THE_SAME, _ELSEWHERE)


def reasons_to_ask(spec: BakeSpec, files: OutputFiles, overwrite: Overwrite) -> tuple[str, ...]:
    """Why somebody may want to keep the bake that is there, in sentences that name both; empty if nothing.

    A bake that adds samples, or changes some texels, makes none worse.
    """
    found = []
    blend = _blend_at(files)
    if blend and _is_of_another(blend, overwrite.blend, files.sidecar.parent):
        own = overwrite.blend.name or "a file that was never saved"
        found.append(f"{files.sidecar} is a bake of {blend}, not of {own}")
    if not (spec.accumulate or spec.refresh):
        with suppress(FormatError):
            there, new = Quality.in_facts(read_facts(files.sidecar)), Quality.of_spec(spec, overwrite.passes)
            if new.is_worse_than(there):
                found.append(f"{files.sidecar} is a better bake ({there}) than the new one would be ({new})")
    return tuple(found)


def _is_of_another(recorded: str, blend: Path, folder: Path) -> bool:
    """Whether a bake in `folder` whose sidecar names the file `recorded` belongs to another than `blend`.

    In the file's own folder it does only if the other still lies beside it: else the file was renamed.
    """
    if recorded == blend.name:
        return False
    if not blend.name:
        return True
    own = folder.absolute() == own_folder(blend.absolute())
    return not own or blend.with_name(recorded).exists()


def is_of_blend(sidecar: Path, blend: Path) -> bool:
    """Whether a finished bake may belong to a .blend: its sidecar names that, or none."""
    try:
        recorded = blend_in(read_facts(sidecar))
    except FormatError:
        return False
    return not recorded or not _is_of_another(recorded, blend, sidecar.parent)


def _blend_at(files: OutputFiles) -> str:
    """The name of the .blend whose bake is there, finished or not; empty if that is not known."""
    with suppress(FormatError):
        if found := blend_in(read_facts(files.sidecar)):
            return found
    key = known_key(files.unfinished)
    return "" if key is None else key.blend


def _subject_at(sidecar: Path) -> _Subject | None:
    try:
        return _Subject.in_facts(read_facts(sidecar))
    except FormatError:
        return None


def _check_unfinished(folder: Path, wanted: _Subject, spec: BakeSpec) -> None:
    """Raise InputError if the folder holds pieces of a bake of another object, part or lamps."""
    key = known_key(folder)
    if key is None:
        return
    facts = key.facts
    asked = {
        "object": wanted.name,
        "split": str(spec.split),
        "part": str(spec.part),
        "lamps that are lit": str(spec.lights),
    }
    if differing := [key for key, value in asked.items() if facts.get(key, value) != value]:
        other = ", ".join(f"{key} {facts[key]}" for key in dict.fromkeys(("object", *differing)))
        raise InputError(f"{folder} is of another bake ({other}), not of {wanted}", _RENAME, _ELSEWHERE)


def _others_with_preview(files: OutputFiles) -> list[tuple[Path, _Subject]]:
    """Other bakes in the folder whose preview is the same file, and what they are of."""
    found = []
    assert files.preview is not None  # only called with one
    stem = files.preview.name.removesuffix(".preview.blend")
    for split in Split:
        stem = stem.removesuffix(f".{split}")
    for path in sorted(files.sidecar.parent.glob("*.json")):
        if path == files.sidecar or not path.name.startswith(f"{stem}."):
            continue
        with suppress(FormatError):
            facts = read_facts(path)
            if preview_path(path, facts.text("kind"), part_in(facts)) == files.preview:
                found.append((path, _Subject.in_facts(facts)))
    return found


def _of_another(path: Path, there: _Subject, wanted: _Subject) -> InputError:
    remedies: tuple[Remedy, ...] = (_RENAME, _ELSEWHERE)
    return InputError(f"{path} is a bake of {there}, not of {wanted}", *remedies)
