# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished bake in its folder: found by its sidecar, read back, looked up by the reference samplers."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..bake.kinds import USUAL_KIND, Kind, is_usual
from ..bake.spec import BakeSpec, Compression, parse_capture, parse_kind, parse_layout
from ..core.arrays import Floats
from ..core.errors import FormatError, InputError
from ..formats.sidecar import Sidecar, file_name, part_in, preview_path, read_facts
from ..forms import Form, form_in
from ..forms.form import Lookup
from ..scene.mesh.copy import UV_LAYER
from .gbuffer import Array, GBuffer

_PER_LOOKUP = 1 << 18  # fragments that are looked up at once


@dataclass(frozen=True, eq=False)
class Finished:
    """A bake's sidecar, its images, and the light in them.

    `radiance` gives the light (N, 3), linear, along a G-buffer's N rays, zero where they miss. `texels`
    (H, W, K) are what each texel has of its own, as it is stored: light, or what `own_texels` finds.
    `compression` is None for one that RadTex does not write, and for textures. `loss` is how far two of
    `texels` may be apart that were the same before they were packed, over the larger. `budget` is how many
    bytes a condensed bake's textures take on a GPU, None for another.
    """

    path: Path
    form: Form
    sidecar: Sidecar
    images: tuple[Path, ...]
    radiance: Callable[[GBuffer], Array]
    texels: Floats
    compression: Compression | None
    loss: float = 0.0
    budget: int | None = None

    @property
    def preview(self) -> Path:
        """Where the preview lies, if one was saved."""
        return preview_path(self.path, self.sidecar.kind, self.sidecar.part)

    @property
    def unwrapped(self) -> bool:
        """Whether the bake made its UV layer itself, as far as the sidecar tells."""
        return self.sidecar.uv_map == UV_LAYER

    def spec(self, device: str) -> BakeSpec:
        """The specification of the same bake again, as far as its files tell; condensed to as many bytes."""
        bake, source = self.sidecar, self.sidecar.source
        return BakeSpec(
            kind=parse_kind(bake.kind),
            layout=parse_layout(self.form.traits.layout),
            texels=max(bake.width, bake.height),
            bucket=bake.bucket,
            samples=bake.samples,
            seed=bake.seed,
            capture=parse_capture(bake.capture),
            uv_layer=None if self.unwrapped else bake.uv_map,
            compression=self.compression or Compression.ZIP,
            device=device,
            budget=self.budget,
            source=None if source is None else source.object_name,
            extrusion=None if source is None or source.cage is not None else source.extrusion,
            cage=None if source is None else source.cage,
            frame=bake.frame,
            lights=bake.lights,
        )


def find_bake(
    place: Path,
    object_name: str | None,
    purpose: str = "judged",
    kinds: Collection[str] = (USUAL_KIND,),
) -> Path:
    """The sidecar of a bake of one of the `kinds`: `place` itself, or the one in the folder `place`.

    `object_name` tells several apart, one of radiance goes before others; `purpose` is what errors say of it.
    Raises InputError where there is none, or more than one; FormatError for a file that is no sidecar.
    """
    found = find_bakes(place, object_name, purpose, kinds)
    if len(found) > 1:
        names = ", ".join(path.name for path in found)
        raise InputError(f"{place} holds {names}: name one of these files instead of the folder")
    return found[0]


def find_bakes(
    place: Path, object_name: str | None, purpose: str, kinds: Collection[str] = (USUAL_KIND,)
) -> list[Path]:
    """What `find_bake` finds, or where an object is split the sidecars of all parts that are there."""
    try:
        found_there, is_folder = place.exists(), place.is_dir()
    except (OSError, ValueError):  # no name that a file can have
        found_there = is_folder = False
    if not found_there:
        raise InputError(f"there is no {place}: name the folder of a bake, or its sidecar, a .json file")
    if not is_folder:
        _check(place, _identity(place), object_name, purpose, kinds)
        return [place]
    found = {path: identity for path in _json_files(place) if (identity := _identity_if_ours(path))}
    if not found:
        raise InputError(f"{place} holds no bake: name a folder with a sidecar, NAME.{USUAL_KIND}.json")
    wanted = {path: identity for path, identity in found.items() if identity.is_of(object_name)}
    wanted = {path: wanted[path] for path in wanted if wanted[path].name == object_name} or wanted
    if not wanted:
        raise InputError(f"{place} holds no bake of '{object_name}': it has {_listed(found.values())}")
    of_radiance = [path for path, identity in wanted.items() if is_usual(identity.kind)]
    fitting = of_radiance or [path for path, identity in wanted.items() if identity.kind in kinds]
    if len({wanted[path].name for path in fitting}) > 1:
        raise InputError(f"{place} holds bakes of {_listed(wanted.values())}: name one (--object)")
    plain = [path for path in fitting if path.name == wanted[path].plain_file]
    whole = [path for path in plain if wanted[path].split is None]
    fitting = whole or plain or fitting  # before parts, and before frames, and lamps alone
    splits = {(wanted[path].split, wanted[path].variant) for path in fitting}
    if len(fitting) > 1 and (len(splits) > 1 or wanted[fitting[0]].split is None):
        names = ", ".join(path.name for path in fitting)
        raise InputError(f"{place} holds {names}: name one of these files instead of the folder")
    if not fitting:
        _check(*next(iter(wanted.items())), object_name, purpose, kinds)
    return fitting


def check_whole(path: Path) -> None:
    """Refuse a bake of several objects, or of a part of one, where one whole object is judged.

    Raises InputError, or FormatError for a file that is no sidecar.
    """
    identity = _identity(path)
    if identity.objects or identity.split:
        what = "several objects in one atlas" if identity.objects else "a part of an object"
        raise InputError(f"{path} is of {what}, which no report judges: compare it instead (bake.py compare)")


def object_of(path: Path) -> str:
    """The object that a sidecar names. Raises FormatError."""
    return _identity(path).name


@dataclass(frozen=True)
class _Identity:
    """What a sidecar says first: what the bake is called, its kind, the objects that it is of.

    Of an object that is split, `split` says by what, and again the kind, and `part` is the part's name.
    `variant` tells frames and lamps alone from the plain bake.
    """

    name: str
    kind: str
    objects: tuple[str, ...]
    split: tuple[str, str] | None
    part: str | None
    variant: tuple[object, ...]

    @property
    def plain_file(self) -> str:
        """What the sidecar is called of a bake of all light, at no frame that was asked for."""
        return file_name(self.name, self.kind, "json", part=self.part)

    def is_of(self, name: str | None) -> bool:
        """Whether the bake is called so, or of an object that is; any is, of None."""
        return name is None or name == self.name or name in self.objects


def _json_files(folder: Path) -> list[Path]:
    try:
        return sorted(folder / name for name in os.listdir(folder) if name.endswith(".json"))  # noqa: PTH208  # it raises
    except OSError as error:
        raise InputError(f"{folder} cannot be read: {error.strerror or error}; name another") from error


def _identity(path: Path) -> _Identity:
    facts = read_facts(path)
    facts.text("layout")
    objects = facts.texts("objects") if "objects" in facts.values else ()
    part, kind = part_in(facts), facts.text("kind")
    lights = facts.texts("lights") if "lights" in facts.values else ()
    variant = (facts.whole_number("frame", 0) if "frame" in facts.values else None, lights)
    if part is None:
        return _Identity(facts.text("object"), kind, objects, None, None, variant)
    return _Identity(facts.text("object"), kind, objects, (part.by, kind), part.name, variant)


def _identity_if_ours(path: Path) -> _Identity | None:
    try:
        return _identity(path)
    except FormatError:
        return None


def _check(
    path: Path, identity: _Identity, object_name: str | None, purpose: str, kinds: Collection[str]
) -> None:
    name, kind = identity.name, identity.kind
    if not identity.is_of(object_name):
        raise InputError(f"{path} is a bake of '{name}', not of '{object_name}': leave --object out")
    if kind not in tuple(Kind):
        raise InputError(f"{path} is of kind {kind}, which this RadTex does not know: update RadTex")
    if kind not in kinds:
        raise InputError(
            f"{path} holds {kind} light, which no camera sees: "
            f"only a bake of {' or '.join(kinds)} can be {purpose}"
        )


def _listed(identities: Iterable[_Identity]) -> str:
    return ", ".join(sorted({f"'{identity.name}'" for identity in identities}))


def read_bake(path: Path) -> Finished:
    """Read the bake whose sidecar is the file `path`.

    Raises FormatError, with the path, for files that are missing, damaged, or of different bakes.
    """
    form = form_in(read_facts(path))
    opened = form.open(path)
    return Finished(
        path=path,
        form=form,
        sidecar=opened.sidecar,
        images=opened.images,
        radiance=_looked_up(opened.lookup),
        texels=opened.texels,
        compression=opened.compression,
        loss=opened.loss,
        budget=opened.budget,
    )


def _looked_up(lookup: Lookup) -> Callable[[GBuffer], Array]:
    """A lookup along all rays, which are many, a part at a time."""

    def radiance(buffer: GBuffer) -> Array:
        hit = (buffer.uv, buffer.normal, buffer.incoming, buffer.incidence)
        uv, normal, viewer, incidence = (part[buffer.hit] for part in hit)
        parts = (slice(first, first + _PER_LOOKUP) for first in range(0, len(uv), _PER_LOOKUP))
        seen = [lookup(uv[some], normal[some], viewer[some], incidence[some]) for some in parts]
        return buffer.spread(np.concatenate(seen) if seen else np.zeros((0, 3)))

    return radiance
