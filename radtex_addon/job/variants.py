# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Several bakes of one run, such as of an object's frames, lights or parts: names, and which to make.

No two of them may have files of the same name, so that one would replace the other's.
"""

from __future__ import annotations

import tempfile
from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

import bpy

from ..bake.bake_title import bake_title, variant_title
from ..core.errors import FormatError, InputError
from ..core.messages import Setting, do
from ..formats.disk.path_checks import nearest_folder
from ..formats.sidecar import called_in, file_name, part_in
from ..formats.sidecar_file import read_facts
from ..settings.bake_names import OBJECT, as_part, fill, filled, tokens_of
from ..settings.presets import quality_of
from ..settings.spec import BakeSpec
from ..store.bake_folder import BakeFolder, FolderState
from ..store.ownership import blend_folder_name, open_blend
from ..textures.export_spec import Target

Bake: TypeAlias = tuple[str, BakeSpec]  # the name of an object or a shared atlas, and the specification

_KEYS = ("frame", "lights")  # keys that only sidecars of variants have


def title_of(name: str, spec: BakeSpec) -> str:
    """The title of a bake that is to be made: what it is called, its part and its variant."""
    part = "" if spec.part is None else f"{spec.split} {spec.part}"
    return bake_title(filled(spec.bake_name, name), part=part, variant=variant_of(spec))


def named_in(scene: bpy.types.Scene, spec: BakeSpec, blend: Path | None = None) -> BakeSpec:
    """The specification with all tokens of its name filled in but `{object}`.

    The `{file}` is `blend`, None for the open one. Raises InputError for a name that files cannot have.
    """
    if spec.bake_name == OBJECT:
        return spec
    file = open_blend() if blend is None else blend
    values = {
        "scene": as_part(scene.name),
        "file": as_part(blend_folder_name(file)) if file.name else "untitled",
        "quality": quality_of(spec, automatic=False),  # else a request has filled it in
    }
    return replace(spec, bake_name=fill(spec.bake_name, values | tokens_of(spec)))


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
                raise _collision(owner, bake, out / path.name)


def _collision(one: Bake, other: Bake, path: Path) -> InputError:
    both = f"{_told(*one)} and {_told(*other)} would both become {path}"
    if one[1].bake_name == other[1].bake_name == OBJECT:
        return InputError(f"{both}: rename one of them, or bake them into folders of their own")
    patterns = " and ".join(dict.fromkeys(f'"{each[1].bake_name}"' for each in (one, other)))
    return InputError(
        f"{both}, by the name {patterns}",
        do(f"put what tells them apart into it, such as {OBJECT}", Setting.BAKE_NAME),
        do("bake them into folders of their own", Setting.OUT),
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


def variants_in(folder: Path, name: str, kind: str, called: str = "") -> tuple[Path, ...]:
    """The sidecars of all variants of a bake, or of its parts; none if there is also a plain one.

    `called` is what the bake's files are called, if not as the object `name`.
    """
    paths = sorted(folder.glob(f"*.{kind}.json"))
    found = {path: plain for path in paths if (plain := _plain(path, name, called))}
    stem = called or name
    if any(path.name == file_name(stem, kind, "json", part=part) for path, (part, _) in found.items()):
        return ()
    return tuple(path for path, (_, is_variant) in found.items() if is_variant)


def _plain(sidecar: Path, name: str, called: str) -> tuple[str | None, bool] | None:
    """The part of a bake of `name`, and whether it is a variant; None for a sidecar of another."""
    try:
        facts = read_facts(sidecar)
        part, own = part_in(facts), called_in(facts)
    except FormatError:
        return None
    if facts.values.get("object") != name or own != ("" if called == name else called):
        return None
    return None if part is None else part.name, any(key in facts.values for key in _KEYS)
