# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""UV coordinates for a bake: of one or several objects, in one atlas or in one atlas for each part."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import bpy
import numpy as np

from ..bake.piece_store import Arrays, PieceStore
from ..bake.progress import Progress, relayed
from ..core.arrays import Bools, Floats
from ..core.errors import InputError
from ..core.islands import signed_areas, surface_areas, uv_islands, weld
from ..core.messages import Message, Remedy, Setting, do
from ..core.near_digest import is_same
from ..scene.geometry_digests import matrix_digest, mesh_digest
from ..scene.mesh.backs import with_twins_moved
from ..scene.mesh.copy import UV_LAYER
from ..scene.mesh.evaluated import EvaluatedMesh, evaluate
from ..scene.mesh.joined import side_by_side
from ..scene.mesh.mesh_parts import Parts, in_first_tile, parts_of, taken
from ..scene.mesh.painted_weights import UNPAINTED, painted_triangles
from ..scene.mesh.seen_faces import faces_inside, seen_faces
from ..scene.scratch import at_frame
from ..scene.uv.artist_islands import ArtistIslands
from ..scene.uv.unwrap import unwrap_steps
from ..scene.uv.unwrap_options import AtlasUnwrap, UnwrapOptions
from ..scene.uv.uv_layer import check_apart, user_uv, why_unfit
from ..scene.uv.uvunwrap_job import unwrap_progress
from ..settings.choices import Backs
from ..settings.parts import Split
from ..settings.spec import BakeSpec, Unwrap
from ..settings.texel_density import side_for

log = logging.getLogger(__name__)

Unwraps: TypeAlias = dict[str, Arrays]  # a cache: the key is made of the meshes' digests and the settings

_ROOM = 1.0  # metres: where so much is free, a camera can be
_UNWRAP = "unwrap"  # a piece's name
COUNTED = 1_000_000  # triangles whose islands are counted in a second or two
_WHOLE = ""  # the name of the only part if nothing is split


@dataclass(frozen=True, eq=False)
class AtlasPart:
    """The part of the meshes that one atlas covers: `faces` (F,) marks the triangles of each mesh.

    `islands` is their number, None where a large mesh has a UV layer of its own. `needed` is about how many
    texels along the longer side the density that was asked for would need, if these are fewer; else 0.
    """

    name: str
    faces: tuple[Bools, ...]
    width: int
    height: int
    islands: int | None
    needed: int = 0


@dataclass(frozen=True, eq=False)
class Unwrapped:
    """UV coordinates (F, 3, 2) of each mesh for its `layer`; each part's are 0..1 in an atlas of its own."""

    uvs: tuple[Floats, ...]
    layer: str
    parts: tuple[AtlasPart, ...]

    def chosen(self, spec: BakeSpec, name: str) -> tuple[int, AtlasPart]:
        """The index and the part that the specification names. Raises InputError if there is no such part."""
        for index, part in enumerate(self.parts):
            if part.name == (spec.part or _WHOLE):
                return index, part
        known = ", ".join(f"'{part.name}'" for part in self.parts)
        raise InputError(f"object '{name}' has no {spec.split} '{spec.part}' in renders: it has {known}")


def unwrap_surfaces(
    meshes: Sequence[EvaluatedMesh],
    spec: BakeSpec,
    metres: float,
    store: PieceStore,
    known: Unwraps,
    cameras: Floats | None = None,
) -> Generator[Progress, None, Unwrapped]:
    """Unwrap the meshes, or use the UV layer that the specification names, or one of theirs that is fit.

    A scene unit is so many `metres`. Where all `cameras` (C, 3) are inside what is baked, its outside gets
    few texels.

    An unwrap is kept in the `store` and in the cache `known`. Yields progress. Raises InputError for a layer
    that cannot be used, and for meshes that cannot be unwrapped.
    """
    parts = split_surfaces(meshes, spec)
    if spec.uv_layer is not None:
        return _of_layer(meshes, parts, spec, metres, spec.uv_layer)
    if spec.unwrap is Unwrap.AUTO and spec.split is None and painted_triangles(meshes) is None:
        layer = _own_layer(meshes, spec, metres)
        if layer is not None:
            return _of_layer(meshes, parts, spec, metres, layer)
    piece = store.found(_UNWRAP)
    if piece is None:
        digests = [text for mesh in meshes for text in (str(mesh_digest(mesh)), matrix_digest(mesh))]
        options = unwrap_options(spec, metres)
        size = spec.texels if spec.density is None else f"{options.density} {options.most}"
        inside = None
        if cameras is not None and _weighs(spec.unwrap, options):
            inside = yield from relayed(faces_inside(meshes, cameras), lambda _: unwrap_progress(0))
            if inside is not None:
                log.warning(_few_outside(meshes, inside))
        seen = "" if inside is None else hashlib.sha256(np.packbits(inside).tobytes()).hexdigest()
        key = "\n".join((f"{size} {spec.unwrap} {spec.padding} {spec.split} {seen}", *digests))
        piece = _known(known, key)
        if piece is None:
            piece = known[key] = yield from _anew(meshes, parts, spec, options, inside)
        store.keep(_UNWRAP, piece)
    ends = np.cumsum([len(mesh.triangles) for mesh in meshes])
    sizes = piece["sizes"].tolist()
    made = [AtlasPart(name, parts[name], *size) for name, size in zip(parts, sizes, strict=True)]
    return Unwrapped(tuple(np.split(piece["uv"], ends[:-1])), UV_LAYER, tuple(made))


def _known(known: Unwraps, key: str) -> Arrays | None:
    """The cache's unwrap of the same meshes, but for rounding."""
    wanted = key.split("\n")
    for other, piece in known.items():
        found = other.split("\n")
        if len(found) == len(wanted) and all(map(is_same, found, wanted)):
            return piece
    return None


def unwrap_options(spec: BakeSpec, metres: float) -> UnwrapOptions:
    """The options of the specification's unwrap in a scene whose unit is so many `metres`."""
    density = None if spec.density is None else spec.density * metres
    return UnwrapOptions(padding=spec.padding, density=density, most=spec.most_texels, room=_ROOM / metres)


def split_surfaces(meshes: Sequence[EvaluatedMesh], spec: BakeSpec) -> dict[str, tuple[Bools, ...]]:
    """The parts by name, each with marks (F,) of every mesh's triangles; without a split one called ""."""
    if spec.split is None:
        return {_WHOLE: tuple(np.ones(len(mesh.triangles), dtype=bool) for mesh in meshes)}
    found: list[Parts] = [parts_of(mesh, spec.split, spec.uv_layer) for mesh in meshes]
    names = list(dict.fromkeys(name for parts in found for name in parts))
    if spec.split is Split.UDIM:
        names.sort(key=int)
    return {
        name: tuple(
            parts.get(name, np.zeros(len(mesh.triangles), dtype=bool))
            for mesh, parts in zip(meshes, found, strict=True)
        )
        for name in names
    }


def shapes_at(
    scratch: bpy.types.Scene,
    originals: Sequence[bpy.types.Object],
    frame: int,
    evaluated: Sequence[EvaluatedMesh],
    weights: str | None = None,
) -> list[EvaluatedMesh]:
    """The meshes at another frame, with the vertex group called `weights`.

    Those that have other triangles there are returned as `evaluated`.
    """
    with at_frame(scratch, frame):
        found = [evaluate(scratch, original, weights) for original in originals]
    for index, (there, here) in enumerate(zip(found, evaluated, strict=True)):
        if not np.array_equal(there.triangles, here.triangles):
            log.warning(
                "object '%s' has other faces at frame %d than at %d: it is unwrapped anew, "
                "and its atlases do not fit one mesh",
                here.name,
                frame,
                scratch.frame_current,
            )
            found[index] = here
    return found


def _of_layer(
    meshes: Sequence[EvaluatedMesh],
    parts: dict[str, tuple[Bools, ...]],
    spec: BakeSpec,
    metres: float,
    layer: str,
) -> Unwrapped:
    """Use a UV layer of the user's own: a square atlas for every part, of one size or density."""
    uvs = [np.zeros((len(mesh.triangles), 3, 2), dtype=np.float32) for mesh in meshes]
    for name, faces in parts.items():
        for mesh, uv, some in zip(meshes, uvs, faces, strict=True):
            if some.any():
                part = mesh if some.all() else taken(mesh, some)
                if spec.split is Split.UDIM:
                    part = in_first_tile(part, layer, name)
                uv[some] = user_uv(part, layer)
        if len(meshes) > 1:
            names = ", ".join(f"'{mesh.name}'" for mesh in meshes)
            together = np.concatenate([uv[some] for uv, some in zip(uvs, faces, strict=True)])
            check_apart(together, f"UV layer '{layer}' of objects {names} together")
    made = []
    for name, faces in parts.items():
        side, needed = _side_of_layer(meshes, uvs, faces, spec, metres)
        made.append(AtlasPart(name, faces, side, side, _counted(meshes, uvs, faces), needed))
    return Unwrapped(tuple(uvs), layer, tuple(made))


def _side_of_layer(
    meshes: Sequence[EvaluatedMesh],
    uvs: Sequence[Floats],
    faces: Sequence[Bools],
    spec: BakeSpec,
    metres: float,
) -> tuple[int, int]:
    """Texels along the sides of a UV layer's atlas, and `AtlasPart.needed`.

    With a density the `faces` have it in the mean: their area on the surface, over that in the layer.
    """
    if spec.density is None:
        return spec.texels, 0
    pairs = [
        (mesh.world_position[mesh.triangles[some]], uv[some].astype(np.float64))
        for mesh, uv, some in zip(meshes, uvs, faces, strict=True)
    ]
    surface = metres**2 * sum(float(surface_areas(corners).sum()) for corners, _ in pairs)
    covered = sum(float(np.abs(signed_areas(uv)).sum()) for _, uv in pairs)
    if not 0 < covered < np.inf:  # no layer to bake on, whatever its size
        return spec.texels, 0
    needed = side_for(surface, spec.density, covered)
    return (needed, 0) if needed <= spec.most_texels else (spec.most_texels, needed)


def _own_layer(meshes: Sequence[EvaluatedMesh], spec: BakeSpec, metres: float) -> str | None:
    """The active UV layer of the objects, if it is fit to bake on; the log says why it is not."""
    layers = {mesh.active_uv for mesh in meshes}
    (layer, *others) = layers
    if layer is None or others or len(meshes) > 1:
        return None  # of several objects, layers made one by one lie over one another
    every = np.ones(len(meshes[0].triangles), dtype=bool)
    side, _ = _side_of_layer(meshes, [meshes[0].uv(layer)], [every], spec, metres)
    why = why_unfit(meshes[0], layer, side, spec.padding)
    if why is not None:
        log.info("UV layer '%s' of '%s' is not baked on: it %s", layer, meshes[0].name, why)
        return None
    log.info("baked on UV layer '%s' of '%s'", layer, meshes[0].name)
    return layer


def _counted(meshes: Sequence[EvaluatedMesh], uvs: Sequence[Floats], faces: Sequence[Bools]) -> int | None:
    """How many islands the UV coordinates of these faces have; None where counting would take long."""
    if sum(np.count_nonzero(some) for some in faces) > COUNTED:
        return None
    return sum(
        int(uv_islands(weld(mesh.position)[mesh.triangles[some]], uv[some]).max()) + 1
        for mesh, uv, some in zip(meshes, uvs, faces, strict=True)
        if some.any()
    )


def _anew(
    meshes: Sequence[EvaluatedMesh],
    parts: dict[str, tuple[Bools, ...]],
    spec: BakeSpec,
    options: UnwrapOptions,
    inside: Bools | None,
) -> Generator[Progress, None, Arrays]:
    """Unwrap every part by itself: `uv` (F, 3, 2) of all meshes' triangles, `sizes` (P, 4) of the atlases.

    The columns of `sizes` are `AtlasPart`'s width, height, islands and needed. `inside` is as for `_seen`.
    Yields progress.
    """
    every = np.concatenate([np.stack(faces_of_mesh) for faces_of_mesh in _by_mesh(parts)], axis=1)
    uv = np.zeros((every.shape[1], 3, 2), dtype=np.float32)  # as meshes store it
    sizes = []
    seen = yield from _seen(meshes, spec.unwrap, options, inside)
    for faces, some in zip(parts.values(), every, strict=True):
        those = [
            mesh if one.all() else taken(mesh, one)
            for mesh, one in zip(meshes, faces, strict=True)
            if one.any()
        ]
        found = yield from _unwrap_together(those, seen[some], spec.texels, spec.unwrap, options)
        uv[some] = found.uv
        sizes.append([found.width, found.height, found.islands, found.needed])
    return {"uv": uv, "sizes": np.array(sizes)}


def unwrap_mesh(
    mesh: EvaluatedMesh, texels: int, method: Unwrap, options: UnwrapOptions
) -> Generator[Progress, None, AtlasUnwrap]:
    """Unwrap one mesh, with its twins, as `unwrap_surfaces` does where no layer of its own fits as it is."""
    seen = yield from _seen([mesh], method, options)
    return (yield from _unwrap_together([mesh], seen, texels, method, options))


def _few_outside(meshes: Sequence[EvaluatedMesh], inside: Bools) -> Message:
    """The line about triangles that are not `inside` (F,)."""
    ends = np.cumsum([len(mesh.triangles) for mesh in meshes])
    names = [
        f"'{mesh.name}'"
        for mesh, faces in zip(meshes, np.split(inside, ends[:-1]), strict=True)
        if not faces.all()
    ]
    return Message(
        f"all cameras are inside: what cannot be seen from there of {', '.join(names)} gets few texels",
        (do("give all sides as many", Setting.BACKS, value=Backs.ALL), Remedy("add a camera outside")),
    )


def _weighs(method: Unwrap, options: UnwrapOptions) -> bool:
    """Whether what is not seen gets few texels; not where a density is asked for."""
    return method is Unwrap.AUTO and options.density is None


def _seen(
    meshes: Sequence[EvaluatedMesh], method: Unwrap, options: UnwrapOptions, inside: Bools | None = None
) -> Generator[Progress, None, Bools]:
    """Which triangles (F,) of the meshes get all of their texels; all do where a density is asked for.

    Those for which more is painted count as seen; of others only those `inside` (F,), if that is given.
    """
    if _weighs(method, options):
        seen = yield from relayed(seen_faces(meshes, options.room), lambda _: unwrap_progress(0))
        seen = seen if inside is None else seen & inside
        painted = painted_triangles(meshes)
        return seen if painted is None else seen | (painted > UNPAINTED)
    return np.ones(sum(len(mesh.triangles) for mesh in meshes), dtype=bool)


def _unwrap_together(
    meshes: Sequence[EvaluatedMesh], seen: Bools, texels: int, method: Unwrap, options: UnwrapOptions
) -> Generator[Progress, None, AtlasUnwrap]:
    """Unwrap meshes, with their twins, into one atlas."""
    apart = [with_twins_moved(mesh) for mesh in meshes]
    artist = ArtistIslands.of_meshes(apart, options) if method is Unwrap.AUTO else None
    row = side_by_side(apart, "', '".join(mesh.name for mesh in meshes))
    painted = painted_triangles(meshes)
    if painted is not None:
        painted = np.where(seen, painted, UNPAINTED)  # what is hidden has few already
    return (yield from unwrap_steps(row, texels, method, options, artist, seen, painted))


def _by_mesh(parts: dict[str, tuple[Bools, ...]]) -> Sequence[tuple[Bools, ...]]:
    """For each mesh, the marks of its triangles in every part."""
    return list(zip(*parts.values(), strict=True))
