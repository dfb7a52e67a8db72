# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished bake in its folder: found by its sidecar, read back, looked up by the reference samplers."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..core.arrays import Floats
from ..core.errors import FormatError, InputError
from ..core.gutter import covered_in_coarser, gutter_agreement
from ..core.messages import Setting, do, leave_out
from ..core.surface import SurfaceMesh
from ..core.texel_map import covered_texels
from ..formats.sidecar import Sidecar, called_in, file_name, part_in, preview_path
from ..formats.sidecar_file import AnySidecar, SidecarFile, opened, read_facts
from ..forms import Form, form_in
from ..forms.form import Alpha, Lookup
from ..scene.mesh.copy import UV_LAYER
from ..settings.choices import Backs, parse_backs, parse_capture, parse_kind, parse_layout
from ..settings.kinds import DEFAULT_KIND, Kind, is_default_kind
from ..settings.options import MARKED
from ..settings.quality import Quality
from ..settings.rays import step_to
from ..settings.spec import BakeSpec, Compression
from .gbuffer import Array, GBuffer

_PER_LOOKUP = 1 << 18  # fragments that are looked up at once


@dataclass(frozen=True, eq=False)
class Finished:
    """A bake that was read: the sidecar's `file`, its images, and the light in them.

    `radiance` gives the light (N, 3), linear, along a G-buffer's N rays, zero where they miss. `texels`
    (H, W, K) are the stored values of each texel: light, or those of the form's `own_texels`; of buckets
    (H, W, G, K), some of their cells.
    `compression` is None for a method that RadTex does not write. `loss` is the greatest
    relative difference of two `texels` that were equal before lossy compression. `alpha` gives how much of
    what is behind is hidden (N,) at texture coordinates (N, 2), None where all of it is.
    """

    file: SidecarFile
    form: Form
    sidecar: Sidecar
    images: tuple[Path, ...]
    radiance: Callable[[GBuffer], Array]
    texels: Floats
    compression: Compression | None
    loss: float = 0.0
    alpha: Alpha | None = None

    @property
    def name(self) -> str:
        """The sidecar's file name."""
        return self.file.path.name

    @property
    def preview(self) -> Path:
        """The preview's path, if one was saved."""
        return preview_path(self.file.path, self.sidecar.kind, self.sidecar.part)

    @property
    def unwrapped(self) -> bool:
        """Whether the bake made its UV layer itself, judging by the layer's name."""
        return self.sidecar.uv_map == UV_LAYER

    @property
    def backs(self) -> Backs:
        """Which backs could get texels; all where the bake does not say."""
        return parse_backs(self.sidecar.backs) if self.sidecar.backs else Backs.ALL

    def agreement(self, surface: SurfaceMesh) -> float:
        """How well a surface's UV layer agrees with the gutter of the bake, 0 to 1: `gutter_agreement`."""
        covered = covered_texels(surface, self.sidecar.width, self.sidecar.height)
        covered = covered_in_coarser(
            covered, self.texels.shape[:2], step_to(self.texels.shape, covered.shape)
        )
        return gutter_agreement(covered, self.texels, self.loss)

    def spec(self, device: str) -> BakeSpec:
        """The specification that repeats the bake, as far as its files record it."""
        bake, source = self.sidecar, self.sidecar.source
        marked: dict[str, Any] = {name: True for name in MARKED if name in bake.marks}
        return BakeSpec(
            kind=parse_kind(bake.kind),
            layout=parse_layout(self.form.traits.layout),
            texels=max(bake.width, bake.height),
            density=None if bake.texel_density is None else bake.texel_density.asked,
            bucket=bake.bucket,
            samples=bake.samples,
            seed=bake.seed,
            capture=parse_capture(bake.capture),
            uv_layer=None if self.unwrapped else bake.uv_map,
            texel_weights=bake.texel_weights or None,
            backs=self.backs,
            compression=self.compression or Compression.ZIP,
            device=device,
            source=None if source is None else source.object_name,
            extrusion=None if source is None or source.cage is not None else source.extrusion,
            cage=None if source is None else source.cage,
            frame=bake.frame,
            lights=bake.lights,
            denoise=bake.denoised,
            **marked,
        )


def find_bake(
    place: Path,
    object_name: str | None,
    purpose: str = "judged",
    kinds: Collection[str] = (DEFAULT_KIND,),
    or_called: bool = False,
) -> SidecarFile:
    """The sidecar of a bake of one of the `kinds`: `place` itself, or the one in the folder `place`.

    If there are several, `object_name` selects one, and a bake of radiance is preferred. `or_called` is as of
    `find_bakes`. Errors use `purpose` as in "can be judged". Raises InputError if there is no bake, or more
    than one; FormatError for a file that is no sidecar.
    """
    found = find_bakes(place, object_name, purpose, kinds, or_called=or_called)
    if len(found) > 1:
        names = ", ".join(file.path.name for file in found)
        raise InputError(f"{place} holds {names}: name one of these files instead of the folder")
    return found[0]


def find_bakes(
    place: Path,
    object_name: str | None,
    purpose: str,
    kinds: Collection[str] = (DEFAULT_KIND,),
    called: str = "",
    or_called: bool = False,
) -> list[SidecarFile]:
    """Like `find_bake`, but if an object is split, the sidecars of all its parts that exist.

    `called`: in a folder, only the bakes whose files are called so. `or_called`: where there is no bake of an
    object of that name, `object_name` may be what a bake is called.
    """
    if not _is_folder(place):
        file = SidecarFile.read(place)
        files = {file.path: (file, _identity(file))}
    else:
        files = _bakes_in(place)
    if or_called and all(identity.name != object_name for _, identity in files.values()):
        named = {path: each for path, each in files.items() if each[1].called == object_name}
        files, object_name = (named, None) if named else (files, object_name)
    if called:
        files = {path: each for path, each in files.items() if each[1].called == called} or files
    if place in files:
        _check(place, files[place][1], object_name, purpose, kinds)
        return [files[place][0]]
    return _chosen(place, files, object_name, purpose, kinds)


class NamedBake(NamedTuple):
    """All that there is of an `object`, or a shared atlas, by one name: frames, lamps, parts and kinds.

    Its files are `called` so; `time` is when the latest of them was written, in nanoseconds; `quality` is
    that of this one in words.
    """

    object: str
    called: str
    sidecars: tuple[Path, ...]
    time: int
    quality: str


def named_bakes(folder: Path, name: str) -> tuple[NamedBake, ...]:
    """The bakes of the object or shared atlas `name` in a folder, by what they are called, the newest first.

    Those of shared atlases that it is in only where it has none of its own. Quick for what has not changed
    since it was read.
    """
    found: list[tuple[Path, int, _Identity, str]] = []
    try:
        paths = _json_files(folder)
    except InputError:
        return ()
    for path in paths:
        with suppress(OSError):  # it is gone meanwhile
            told = path.stat()
            known = _known(path, told.st_mtime_ns, told.st_size)
            if known is not None and known[0].is_of(name):
                found.append((path, told.st_mtime_ns, *known))
    groups: dict[tuple[str, str], list[tuple[Path, int, _Identity, str]]] = {}
    for one in [one for one in found if one[2].name == name] or found:
        groups.setdefault((one[2].name, one[2].called), []).append(one)
    made = []
    for (object_name, called), group in groups.items():
        _, time, _, quality = max(group, key=lambda one: one[1])
        made.append(NamedBake(object_name, called, tuple(one[0] for one in group), time, quality))
    return tuple(sorted(made, key=lambda one: (-one.time, one.called)))


@lru_cache(maxsize=4096)
def _known(path: Path, _time: int, _size: int) -> tuple[_Identity, str] | None:
    """A sidecar's identity and its quality in words, kept for a file of that time and size.

    None if it is none of ours.
    """
    try:
        file = SidecarFile.read(path)
        return _identity(file), str(Quality.in_facts(file.facts))
    except FormatError:
        return None


def find_bakes_of_all(
    place: Path, purpose: str, kinds: Collection[str] = (DEFAULT_KIND,)
) -> list[SidecarFile]:
    """Like `find_bakes`, but of a folder those of all objects that have a bake of one of the `kinds`."""
    if not _is_folder(place):
        return find_bakes(place, None, purpose, kinds)
    files = _bakes_in(place)
    identities = [identity for _, identity in files.values() if identity.kind in kinds]
    names = sorted({identity.name for identity in identities})
    if not names:
        return _chosen(place, files, None, purpose, kinds)
    return [file for name in names for file in _chosen(place, files, name, purpose, kinds)]


def _is_folder(place: Path) -> bool:
    """Whether it is a folder. Raises InputError if there is nothing."""
    try:
        found_there, is_folder = place.exists(), place.is_dir()
    except (OSError, ValueError):  # not a valid file name
        found_there = is_folder = False
    if not found_there:
        raise InputError(f"there is no {place}: name the folder of a bake, or its sidecar, a .json file")
    return is_folder


def _bakes_in(folder: Path) -> dict[Path, tuple[SidecarFile, _Identity]]:
    """All bakes in a folder. Raises InputError if there are none."""
    files = {path: ours for path in _json_files(folder) if (ours := _read_if_ours(path))}
    if not files:
        raise InputError(f"{folder} holds no bake: name a folder with a sidecar, NAME.{DEFAULT_KIND}.json")
    return {path: (file, _identity(file)) for path, file in files.items()}


def _chosen(
    place: Path,
    files: Mapping[Path, tuple[SidecarFile, _Identity]],
    object_name: str | None,
    purpose: str,
    kinds: Collection[str],
) -> list[SidecarFile]:
    """Those of a folder's bakes that `find_bakes` returns."""
    found = {path: identity for path, (_, identity) in files.items()}
    wanted = {path: identity for path, identity in found.items() if identity.is_of(object_name)}
    wanted = _nearest(wanted, object_name)
    if not wanted:
        raise InputError(f"{place} holds no bake of '{object_name}': it has {_listed(found.values())}")
    of_radiance = [path for path, identity in wanted.items() if is_default_kind(identity.kind)]
    fitting = of_radiance or [path for path, identity in wanted.items() if identity.kind in kinds]
    if len({wanted[path].name for path in fitting}) > 1:
        raise InputError(f"{place} holds bakes of {_listed(wanted.values())}", do("name one", Setting.OBJECT))
    plain = [path for path in fitting if path.name == wanted[path].plain_file]
    whole = [path for path in plain if wanted[path].split is None]
    fitting = whole or plain or fitting  # prefer whole objects to parts, and these to frames and single lamps
    splits = {(wanted[path].split, wanted[path].variant) for path in fitting}
    alike = len(splits) == 1 and len({wanted[path].called for path in fitting}) == 1
    if len(fitting) > 1 and (not alike or wanted[fitting[0]].split is None):
        names = ", ".join(path.name for path in fitting)
        raise InputError(f"{place} holds {names}: name one of these files instead of the folder")
    if not fitting:
        _check(*next(iter(wanted.items())), object_name, purpose, kinds)
    return [files[path][0] for path in fitting]


def _nearest(wanted: dict[Path, _Identity], name: str | None) -> dict[Path, _Identity]:
    """Of bakes that a name may mean, the object's that is called like it, else all of the object."""
    own = {path: each for path, each in wanted.items() if each.name == name}
    plain = {path: each for path, each in own.items() if each.called == name}
    return plain or own or wanted


def check_whole(sidecar: AnySidecar) -> None:
    """Make sure that a bake is of whole objects.

    Raises InputError if it is of a part, FormatError for a file that is no sidecar.
    """
    if _identity(sidecar).split:
        raise InputError(
            f"{sidecar} is of a part of an object, which no report judges: compare it instead "
            "(bake.py compare)"
        )


def object_of(sidecar: AnySidecar) -> str:
    """The object that a sidecar names. Raises FormatError."""
    return _identity(sidecar).name


def is_bake_of(sidecar: AnySidecar, name: str) -> bool:
    """Whether a bake is of the object or atlas `name`, and not only called so. Raises FormatError."""
    return _identity(sidecar).is_of(name)


def called_of(sidecar: AnySidecar) -> str:
    """What the files of a sidecar's bake are called. Raises FormatError."""
    return _identity(sidecar).called


def objects_and_frame(sidecar: AnySidecar) -> tuple[tuple[str, ...], int | None]:
    """The objects that an atlas is of, and the frame at which it was baked, if one was asked for.

    Raises FormatError for a file that is no sidecar.
    """
    found = _identity(sidecar)
    return found.objects or (found.name,), found.frame


@dataclass(frozen=True)
class _Identity:
    """The facts that tell a folder's bakes apart: name, kind and objects.

    For a part of an object, `split` is how the object was split and again the kind, and `part` is the part's
    name. `variant` is the bake's frame, if one was specified, and its lamps, if not all. `called` is what its
    files are called before all these.
    """

    name: str
    called: str
    kind: str
    objects: tuple[str, ...]
    split: tuple[str, str] | None
    part: str | None
    variant: tuple[object, ...]

    @property
    def frame(self) -> int | None:
        frame = self.variant[0]
        return frame if isinstance(frame, int) else None

    @property
    def plain_file(self) -> str:
        """The sidecar's file name if the bake is of all light and of no specified frame."""
        return file_name(self.called, self.kind, "json", part=self.part)

    def is_of(self, name: str | None) -> bool:
        """Whether the bake or one of its objects has this name; True for None."""
        return name is None or name == self.name or name in self.objects


def _json_files(folder: Path) -> list[Path]:
    try:
        return sorted(folder / name for name in os.listdir(folder) if name.endswith(".json"))  # noqa: PTH208  # it raises
    except OSError as error:
        raise InputError(f"{folder} cannot be read: {error.strerror or error}; name another") from error


def _identity(sidecar: AnySidecar) -> _Identity:
    facts = read_facts(sidecar)
    facts.text("layout")
    objects = facts.texts("objects") if "objects" in facts.values else ()
    part, kind = part_in(facts), facts.text("kind")
    lights = facts.texts("lights") if "lights" in facts.values else ()
    variant = (facts.whole_number("frame", 0) if "frame" in facts.values else None, lights)
    name = facts.text("object")
    called = called_in(facts) or name
    if part is None:
        return _Identity(name, called, kind, objects, None, None, variant)
    return _Identity(name, called, kind, objects, (part.by, kind), part.name, variant)


def _read_if_ours(path: Path) -> SidecarFile | None:
    try:
        file = SidecarFile.read(path)
        _identity(file)
    except FormatError:
        return None
    return file


def _check(
    path: Path, identity: _Identity, object_name: str | None, purpose: str, kinds: Collection[str]
) -> None:
    name, kind = identity.name, identity.kind
    if not identity.is_of(object_name):
        raise InputError(f"{path} is a bake of '{name}', not of '{object_name}'", leave_out(Setting.OBJECT))
    if kind not in tuple(Kind):
        raise InputError(f"{path} is of kind {kind}, which this RadTex does not know: update RadTex")
    if kind not in kinds:
        raise InputError(
            f"{path} holds {kind} light, which no camera sees: "
            f"only a bake of {' or '.join(kinds)} can be {purpose}"
        )


def _listed(identities: Iterable[_Identity]) -> str:
    return ", ".join(sorted({f"'{identity.name}'" for identity in identities}))


def read_bake(sidecar: AnySidecar) -> Finished:
    """Read a finished bake by its sidecar.

    Raises FormatError, with the path, for files that are missing, damaged, or of different bakes.
    """
    file = opened(sidecar)
    form = form_in(file.facts)
    bake = form.open(file)
    return Finished(
        file=file,
        form=form,
        sidecar=bake.sidecar,
        images=bake.images,
        radiance=_looked_up(bake.lookup),
        texels=bake.texels,
        compression=bake.compression,
        loss=bake.loss,
        alpha=bake.alpha,
    )


def _looked_up(lookup: Lookup) -> Callable[[GBuffer], Array]:
    """Wrap a lookup: apply it to a G-buffer's rays in chunks of _PER_LOOKUP."""

    def radiance(buffer: GBuffer) -> Array:
        at = buffer.fragments
        parts = (slice(first, first + _PER_LOOKUP) for first in range(0, len(at.uv), _PER_LOOKUP))
        seen = [lookup(at.part(some)) for some in parts]
        return buffer.spread(np.concatenate(seen) if seen else np.zeros((0, 3)))

    return radiance
