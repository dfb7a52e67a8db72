# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whose a bake is, and what may replace it: the .blend that it is of, its object, and how good it is.

Each .blend has a folder for its bakes. A bake of another object, part, frame or lamps is never replaced,
though its file has the same name. One that is better, or of another .blend, is replaced only if that is asked
for.
"""

from __future__ import annotations

import math
import re
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import bpy

from ..bake.bake_title import bake_title, variant_title
from ..core.errors import FormatError, InputError
from ..core.messages import Remedy, Setting, do
from ..formats.json_reader import Facts
from ..formats.sidecar import blend_in, density_in, part_in, safe_name
from ..formats.sidecar_file import read_facts
from ..settings.bake_names import OBJECT
from ..settings.options import MARKED
from ..settings.quality import Quality
from ..settings.spec import BakeSpec
from .checkpoint_files import known_key
from .output_files import OutputFiles, others_with_preview

FOLDER = "radtex"  # beside the .blend; also where bakes of a scene that is in no file go
UNSAVED = Path()  # the path of a .blend that was never saved
ELSEWHERE = do("choose another folder", Setting.OUT)
_RENAME = do("rename one of them")


def open_blend() -> Path:
    """The path of the open .blend; `UNSAVED` if it was never saved."""
    return Path(bpy.data.filepath) if bpy.data.filepath else UNSAVED


def blend_folder_name(blend: Path) -> str:
    """The name of a .blend's own folder of bakes: its own name, without .blend."""
    return safe_name(re.sub(r"\.blend$", "", blend.name, flags=re.IGNORECASE))


def own_folder(blend: Path) -> Path:
    """Where the bakes of a .blend go unless another folder is chosen: `radtex/NAME` beside it."""
    if not blend.name:
        return Path(FOLDER)
    return blend.parent / FOLDER / blend_folder_name(blend)


def former_folder(blend: Path) -> Path:
    """Where the bakes of all files of the folder lay in versions before each had its own."""
    return blend.parent / FOLDER


@dataclass(frozen=True)
class Overwrite:
    """Whether a bake may replace files; true if it may replace an earlier bake of the same thing.

    With `any`, too, it may replace a better one, and one of another .blend. `blend` is the path of the file
    that the scene is of, `UNSAVED` for none. `passes` of as many samples are made in all.
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
        rest = (self.name, self.part, self.frame, self.lights)
        others = (other.name, other.part, other.frame, other.lights)
        return bool(self.shared) == bool(other.shared) and same_objects and rest == others

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
    with suppress(FormatError):
        there = _Subject.in_facts(read_facts(files.sidecar))
        if not there.is_of_same(wanted):
            said = f"{files.sidecar} is a bake of {there}, not of {wanted}"
            raise InputError(said, *_renames(spec), ELSEWHERE)
    _check_unfinished(files.unfinished, wanted, spec)
    if files.preview is None or not files.preview.exists():
        return
    for sidecar, facts in others_with_preview(files.sidecar, files.preview).items():
        with suppress(FormatError):
            other = wanted if facts is None else _Subject.in_facts(facts)
            if not other.is_of_same_object(wanted):
                said = f"{files.preview} is the preview of {other} ({sidecar.name}), not of {wanted}"
                raise InputError(said, *_renames(spec), ELSEWHERE)


def _renames(spec: BakeSpec) -> tuple[Remedy, ...]:
    """How to keep the bakes of two things apart in one folder."""
    if spec.bake_name == OBJECT:
        return (_RENAME,)
    return _RENAME, do("call this one otherwise", Setting.BAKE_NAME)


def reasons_to_ask(spec: BakeSpec, files: OutputFiles, overwrite: Overwrite) -> tuple[str, ...]:
    """Why somebody may want to keep the bake that is there, in sentences that name both; empty if nothing.

    A bake that adds samples, or changes some texels, makes none worse.
    """
    found = []
    blend = _blend_at(files)
    if blend and _is_of_another(blend, overwrite.blend, files.sidecar.parent):
        own = overwrite.blend.name or "a file that was never saved"
        found.append(f"{files.sidecar} is a bake of {blend}, not of {own}")
    if not spec.incremental:
        with suppress(FormatError):
            there, new = Quality.in_facts(read_facts(files.sidecar)), Quality.of_spec(spec, overwrite.passes)
            if new.is_worse_than(there):
                found.append(f"{files.sidecar} is a better bake ({there}) than the new one would be ({new})")
    return tuple(found)


def is_of_blend(sidecar: Path, blend: Path) -> bool:
    """Whether a finished bake may belong to a .blend: its sidecar names that, or none."""
    try:
        recorded = blend_in(read_facts(sidecar))
    except FormatError:
        return False
    return not recorded or not _is_of_another(recorded, blend, sidecar.parent)


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


def _blend_at(files: OutputFiles) -> str:
    """The name of the .blend whose bake is there, finished or not; empty if that is not known."""
    with suppress(FormatError):
        if found := blend_in(read_facts(files.sidecar)):
            return found
    key = known_key(files.unfinished)
    return "" if key is None else key.blend


def _check_unfinished(folder: Path, wanted: _Subject, spec: BakeSpec) -> None:
    """Raise InputError if the folder holds pieces of a bake of another object, part or lamps."""
    key = known_key(folder)
    if key is None:
        return
    asked = {
        "object": wanted.name,
        "split": str(spec.split),
        "part": str(spec.part),
        "lamps that are lit": str(spec.lights),
    }
    if differing := [name for name, value in asked.items() if key.facts.get(name, value) != value]:
        other = ", ".join(f"{name} {key.facts[name]}" for name in dict.fromkeys(("object", *differing)))
        said = f"{folder} is of another bake ({other}), not of {wanted}"
        raise InputError(said, *_renames(spec), ELSEWHERE)


def is_of_spec(facts: Facts, name: str, spec: BakeSpec) -> bool:
    """Whether a sidecar's facts are of the bake called `name`; `Form.is_of` compares the other facts."""
    part, source = (facts.inner(key).values if key in facts.values else {} for key in ("part", "source"))
    asked: dict[str, Any] = {
        "object": name,
        "frame": spec.frame,
        "lights": list(spec.lights) or None,
        "seed": spec.seed,
        "objects": list(spec.objects) or None,
        "ao_distance": spec.ao_distance,
        **{name: name in spec.marks or None for name in MARKED},
    }
    if spec.uv_layer is not None:
        asked["uv_map"] = spec.uv_layer
    same = all(facts.values.get(key) == value for key, value in asked.items())
    same = same and (part.get("by"), part.get("name")) == (spec.split, spec.part)
    return same and source.get("object") == spec.source and _has_size(facts, spec)


def _has_size(facts: Facts, spec: BakeSpec) -> bool:
    """Whether the atlas has the density that is asked for, or was baked without one and has the texels."""
    density = density_in(facts)
    if density is not None or spec.density is not None:
        if density is None or spec.density is None:
            return False
        return math.isclose(density.asked, spec.density, rel_tol=1e-6)  # the panel's is a float32
    return max(facts.size("texels")) == spec.texels
