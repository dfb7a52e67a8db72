# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Several bakes of one run, such as of an object's frames, lights or parts: names, and what is left to do."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TypeAlias

from ..bake.announce import announce
from ..bake.checkpoint import remove_left
from ..bake.key import is_unfinished
from ..bake.spec import BakeSpec
from ..core.errors import FormatError, InputError
from ..formats.sidecar import file_name, part_in, read_facts
from ..textures.spec import Target
from .files import OutputFiles
from .finished import is_finished, misses_preview, missing_exports

Bake: TypeAlias = tuple[str, BakeSpec]  # of an object, or an atlas, by name

_KEYS = ("frame", "lights")  # of a sidecar that is a variant's


def variant_of(spec: BakeSpec) -> str:
    """The frame and the lamps that tell a bake from others of the same surface and kind, in words."""
    words = [] if spec.frame is None else [f"frame {spec.frame}"]
    if spec.lights:
        words.append(f"light of {', '.join(spec.lights)}")
    return ", ".join(words)


def left_to_do(
    bakes: Sequence[Bake], out: Path, preview: bool = False, exports: Collection[Target] = ()
) -> tuple[Bake, ...]:
    """Those of several bakes into the folder `out` that going on makes: all that are not finished.

    Nor is one whose `preview` or `exports` are wanted and not there. Of atlases that get more samples, or are
    refreshed, nothing tells which were already: the unfinished ones alone. Raises InputError where none of
    these is unfinished.
    """
    again = [spec for _, spec in bakes if spec.accumulate or spec.refresh]
    if not again:
        return _not_whole(bakes, out, preview, exports)
    found = tuple(
        (name, spec)
        for name, spec in bakes
        if is_unfinished(OutputFiles.of(name, spec, out, preview=False).unfinished)
    )
    if not found:
        names = ", ".join(f"'{name}'" for name in dict.fromkeys(name for name, _ in bakes))
        raise InputError(
            f"no bake of {names} is unfinished, and nothing tells which of them were {_done(again[0])} "
            f"already: leave --resume out, and name those that lack (--object, --part, --frames, --lights)"
        )
    return found


def _not_whole(
    bakes: Sequence[Bake], out: Path, preview: bool, exports: Collection[Target]
) -> tuple[Bake, ...]:
    """Those that lack something. A preview that parts have in common is one bake's to make."""
    files = {bake: OutputFiles.of(*bake, out, preview) for bake in bakes}
    lacking = {bake for bake in bakes if not is_finished(*bake, out)}
    made = {files[bake].preview for bake in lacking}
    for bake, there in files.items():
        is_alone = misses_preview(there) and there.preview not in made
        if is_alone or missing_exports(there, exports):
            lacking.add(bake)
            made.add(there.preview)
    return tuple(bake for bake in bakes if bake in lacking)


def announce_all(
    bakes: Sequence[Bake], out: Path, preview: bool, exports: Collection[Target], overwrite: bool
) -> None:
    """Let those of several bakes that replace what is there be known to be unfinished before they start.

    Going on with a run that was killed between two of them would else take the next one's old files for what
    it makes. Raises InputError where a process works on one of them, BakeError where the system refuses.
    """
    if len(bakes) < 2:
        return
    for name, spec in bakes:
        files = OutputFiles.of(name, spec, out, preview)
        again = spec.accumulate or spec.refresh
        if files.sidecar.exists() and (overwrite or again) and not is_unfinished(files.unfinished):
            announce(files.unfinished, [*files.own, *(files.export(target) for target in exports)])


def tidy(bakes: Sequence[Bake], out: Path) -> None:
    """Remove what processes that were killed at the very end of these bakes left. Raises BakeError."""
    for bake in bakes:
        remove_left(OutputFiles.of(*bake, out, preview=False).unfinished)


def passed_over(bakes: Sequence[Bake], left: Sequence[Bake]) -> str:
    """What to know where going on leaves out some that may lack samples, or light; empty if none."""
    again = [spec for _, spec in bakes if spec.accumulate or spec.refresh]
    if not again or len(left) == len(bakes):
        return ""
    return (
        f"{len(left)} of {len(bakes)} bakes go on, those that are unfinished; whether the others were "
        f"{_done(again[0])} nothing tells: they stay as they are"
    )


def _done(spec: BakeSpec) -> str:
    return "accumulated" if spec.accumulate else "refreshed"


def variants_in(folder: Path, name: str, kind: str) -> tuple[Path, ...]:
    """The sidecars of all variants of a bake, or of its parts, where no plain one is beside them."""
    found = {path: plain for path in sorted(folder.glob(f"*.{kind}.json")) if (plain := _plain(path, name))}
    if any(path.name == file_name(name, kind, "json", part=part) for path, (part, _) in found.items()):
        return ()
    return tuple(path for path, (_, is_variant) in found.items() if is_variant)


def _plain(sidecar: Path, name: str) -> tuple[str | None, bool] | None:
    """Which part a bake called `name` is of, and whether it is a variant; None for another's sidecar."""
    try:
        facts = read_facts(sidecar)
        part = part_in(facts)
    except FormatError:
        return None
    if facts.values.get("object") != name:
        return None
    return None if part is None else part.name, any(key in facts.values for key in _KEYS)
