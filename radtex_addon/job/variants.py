# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Several bakes of one run, such as of an object's frames, lights or parts: names, and which to make."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TypeAlias

from ..bake.announce import announce
from ..bake.bake_title import bake_title, variant_title
from ..bake.checkpoint import remove_left
from ..bake.key import is_unfinished
from ..bake.spec import BakeSpec
from ..core.errors import FormatError, InputError
from ..core.messages import Setting, do
from ..formats.sidecar import file_name, part_in
from ..formats.sidecar_file import read_facts
from ..textures.export_spec import Target
from .existing_bakes import is_finished, misses_preview, missing_exports
from .output_files import OutputFiles

Bake: TypeAlias = tuple[str, BakeSpec]  # the name of an object or a shared atlas, and the specification

_KEYS = ("frame", "lights")  # keys that only sidecars of variants have


def title_of(name: str, spec: BakeSpec) -> str:
    """The title of a bake that is to be made: its name, its part and its variant."""
    part = "" if spec.part is None else f"{spec.split} {spec.part}"
    return bake_title(name, part=part, variant=variant_of(spec))


def variant_of(spec: BakeSpec) -> str:
    """The frame and the lamps of a bake in words; empty if it is no variant."""
    return variant_title(spec.frame, spec.lights)


def bakes_to_resume(
    bakes: Sequence[Bake], out: Path, preview: bool = False, exports: Collection[Target] = ()
) -> tuple[Bake, ...]:
    """Those of several bakes into the folder `out` that resuming makes: all that are not finished.

    A bake also counts as not finished if its wanted `preview` or `exports` are missing. When accumulating or
    refreshing, nothing shows which bakes were already done: only those with a checkpoint are resumed. Raises
    InputError if there is none.
    """
    again = [spec for _, spec in bakes if spec.accumulate or spec.refresh]
    if not again:
        return not_whole(bakes, out, preview, exports)
    found = tuple(
        (name, spec)
        for name, spec in bakes
        if is_unfinished(OutputFiles.of(name, spec, out, preview=False).unfinished)
    )
    if not found:
        names = ", ".join(f"'{name}'" for name in dict.fromkeys(name for name, _ in bakes))
        raise InputError(
            f"no bake of {names} is unfinished, and nothing tells which of them were {_done(again[0])} "
            f"already",
            do(
                "name those that lack",
                Setting.OBJECT,
                Setting.PART,
                Setting.FRAMES,
                Setting.LIGHTS,
                without=(Setting.RESUME,),
            ),
        )
    return found


def not_whole(
    bakes: Sequence[Bake], out: Path, preview: bool, exports: Collection[Target]
) -> tuple[Bake, ...]:
    """The bakes that lack files."""
    lacking = [bake for bake in bakes if not is_finished(*bake, out)]
    return with_incomplete(bakes, lacking, out, preview, exports)


def with_incomplete(
    bakes: Sequence[Bake], lacking: Collection[Bake], out: Path, preview: bool, exports: Collection[Target]
) -> tuple[Bake, ...]:
    """Those of the `bakes` that are `lacking`, or lack their preview or exports.

    A missing preview that parts share is made by only one of them.
    """
    files = {bake: OutputFiles.of(*bake, out, preview) for bake in bakes}
    lacking = set(lacking)
    made = {files[bake].preview for bake in lacking}
    for bake, there in files.items():
        is_alone = misses_preview(there) and there.preview not in made
        if is_alone or missing_exports(there, exports):
            lacking.add(bake)
            made.add(there.preview)
    return tuple(bake for bake in bakes if bake in lacking)


def announce_all(
    bakes: Sequence[Bake],
    out: Path,
    preview: bool,
    exports: Collection[Target],
    overwrite: bool,
    blend: str = "",
) -> None:
    """Mark those of several bakes that replace existing files as unfinished, before the first one starts.

    Otherwise, if the run is killed between two bakes, resuming it would take the old files of the next one
    for finished. `blend` is the name of the .blend that is baked. Raises InputError if a process works on one
    of them, BakeError where the system refuses.
    """
    if len(bakes) < 2:
        return
    for name, spec in bakes:
        files = OutputFiles.of(name, spec, out, preview)
        again = spec.accumulate or spec.refresh
        if files.sidecar.exists() and (overwrite or again) and not is_unfinished(files.unfinished):
            replaces = [*files.own, *(files.export(target) for target in exports)]
            announce(files.unfinished, replaces, blend)


def tidy(bakes: Sequence[Bake], out: Path) -> None:
    """Remove what was left if a process was killed while it cleaned up after a bake. Raises BakeError."""
    for bake in bakes:
        remove_left(OutputFiles.of(*bake, out, preview=False).unfinished)


def skipped_warning(bakes: Sequence[Bake], left: Sequence[Bake]) -> str:
    """A warning if resuming leaves out bakes that may lack samples, or may not be refreshed; else empty."""
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
    """The sidecars of all variants of a bake, or of its parts; none if there is also a plain one."""
    found = {path: plain for path in sorted(folder.glob(f"*.{kind}.json")) if (plain := _plain(path, name))}
    if any(path.name == file_name(name, kind, "json", part=part) for path, (part, _) in found.items()):
        return ()
    return tuple(path for path, (_, is_variant) in found.items() if is_variant)


def _plain(sidecar: Path, name: str) -> tuple[str | None, bool] | None:
    """The part of a bake called `name`, and whether it is a variant; None for a sidecar of another."""
    try:
        facts = read_facts(sidecar)
        part = part_in(facts)
    except FormatError:
        return None
    if facts.values.get("object") != name:
        return None
    return None if part is None else part.name, any(key in facts.values for key in _KEYS)
