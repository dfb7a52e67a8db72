# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Several bakes of one run, such as of an object's frames, lights or parts: names, and which to make.

No two of them may have files of the same name, so that one would replace the other's.
"""

from __future__ import annotations

import tempfile
from collections.abc import Collection, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TypeAlias

from ..bake.bake_title import bake_title, variant_title
from ..core.errors import FormatError, InputError
from ..core.messages import Setting, do
from ..formats.disk.path_checks import nearest_folder
from ..formats.sidecar import file_name, part_in
from ..formats.sidecar_file import read_facts
from ..settings.spec import BakeSpec
from ..store.bake_folder import BakeFolder, FolderState
from ..textures.export_spec import Target

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
    again = [spec for _, spec in bakes if spec.incremental]
    if not again:
        return not_whole(bakes, out, preview, exports)
    found = tuple(bake for bake in bakes if BakeFolder(*bake, out).state is FolderState.UNFINISHED)
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
    lacking = [bake for bake in bakes if not BakeFolder(*bake, out).is_finished()]
    return with_incomplete(bakes, lacking, out, preview, exports)


def with_incomplete(
    bakes: Sequence[Bake], lacking: Collection[Bake], out: Path, preview: bool, exports: Collection[Target]
) -> tuple[Bake, ...]:
    """Those of the `bakes` that are `lacking`, or lack their preview or exports.

    A missing preview that parts share is made by only one of them.
    """
    folders = {bake: BakeFolder(*bake, out, preview) for bake in bakes}
    lacking = set(lacking)
    made = {folders[bake].files.preview for bake in lacking}
    for bake, there in folders.items():
        is_alone = there.misses_preview() and there.files.preview not in made
        if is_alone or there.missing_exports(exports):
            lacking.add(bake)
            made.add(there.files.preview)
    return tuple(bake for bake in bakes if bake in lacking)


def check_output_collisions(bakes: Sequence[Bake], out: Path, preview: bool) -> None:
    """Make sure that no two bakes write the same file in the folder `out`.

    Names may be the same although their Unicode forms differ (é), or their case if the filesystem ignores
    it. Raises InputError for the first two that share a file.
    """
    if len(bakes) < 2:
        return
    joins_case: bool | None = None
    owners: dict[str, tuple[str, Bake]] = {}
    for bake in bakes:
        for path in BakeFolder(*bake, out, preview).files.own:
            known, owner = owners.setdefault(path.name.casefold(), (path.name, bake))
            if owner is bake:
                continue
            if known != path.name and joins_case is None:
                joins_case = _joins_case(out)
            if known == path.name or joins_case:
                raise InputError(
                    f"{_told(*owner)} and {_told(*bake)} would both become {out / path.name}: "
                    "rename one of them, or bake them into folders of their own"
                )


def _told(name: str, spec: BakeSpec) -> str:
    words = [f"'{name}'", *([f"its {spec.split} '{spec.part}'"] if spec.part is not None else [])]
    return ", ".join([*words, *([variant_of(spec)] if variant_of(spec) else [])])


def _joins_case(folder: Path) -> bool:
    """Whether the folder's filesystem ignores the case of names."""
    with (
        suppress(OSError),
        tempfile.NamedTemporaryFile(dir=nearest_folder(folder), prefix=".radtex-", suffix="-a") as file,
    ):
        return Path(f"{file.name[:-1]}A").exists()
    return False


def skipped_warning(bakes: Sequence[Bake], left: Sequence[Bake]) -> str:
    """A warning if resuming leaves out bakes that may lack samples, or may not be refreshed; else empty."""
    again = [spec for _, spec in bakes if spec.incremental]
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
