# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From an object to the points on it that a bake captures: the same for every layout."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Generator
from dataclasses import dataclass, replace
from typing import TypeAlias

import bpy
import numpy as np

from ..bake.checkpoint import KEEPS_NOTHING, Arrays, Keeper
from ..bake.progress import Progress, Stage
from ..bake.spec import BakeSpec
from ..core.arrays import Floats
from ..core.inset import inset
from ..core.surface import SurfaceMesh
from ..core.texel_map import TexelMap, rasterise
from ..cycles.offset import ray_offset
from ..formats import sidecar
from ..scene.copy import UV_LAYER, baked_mesh, surface_mesh
from ..scene.digests import matrix_digest, mesh_digest, scene_digests
from ..scene.evaluated import EvaluatedMesh, evaluate
from ..scene.frames import at_frame
from ..scene.source import Landing, default_extrusion, find_source, land
from ..scene.unwrap import unwrap_steps
from ..scene.unwrap_options import UnwrapOptions
from ..scene.uv_layer import user_uv

log = logging.getLogger(__name__)

Unwraps: TypeAlias = dict[str, Arrays]  # by what is unwrapped, and how

_UNWRAP = "unwrap"  # a piece's name
_RIM = 0.2  # of a ray's offset: how far from its triangle's edges a ray starts


@dataclass(frozen=True, eq=False)
class Prepared:
    """The baked copy: `mesh` and the same as arrays, `surface`; `matrix_world` (4, 4) is its object's.

    The atlas has `width` x `height` texels on the mesh's `uv_layer`, and `islands` if it was unwrapped anew.
    The `digest` tells its shape and UVs from others, wherever it stands.
    What is baked lies on the `source`, if there is one.
    """

    mesh: bpy.types.Mesh
    surface: SurfaceMesh
    matrix_world: Floats
    uv_layer: str
    width: int
    height: int
    islands: int | None
    digest: str
    source: Landing | None = None

    @property
    def seen(self) -> tuple[bpy.types.Mesh, Floats]:
        """The mesh that texels' points lie on, and its object's matrix (4, 4)."""
        return (self.mesh, self.matrix_world) if self.source is None else self.source.seen

    @property
    def source_facts(self) -> sidecar.Source | None:
        """What the sidecar says of the source."""
        if self.source is None:
            return None
        return sidecar.Source(self.source.name, self.source.extrusion, self.source.missed)

    def texels(self, finer: int = 1) -> TexelMap:
        """Points to capture, `finer` times as many along each side; with a source those on it."""
        if self.source is not None:
            return self.source.texels
        found = rasterise(self.surface, self.width * finer, self.height * finer)
        return inset(found, self.surface, _RIM * ray_offset(self.surface.position))


def prepare(
    scratch: bpy.types.Scene,
    original: bpy.types.Object,
    spec: BakeSpec,
    kept: list[bpy.types.ID],
    keeper: Keeper = KEEPS_NOTHING,
    unwraps: Unwraps | None = None,
) -> Generator[Progress, None, Prepared]:
    """Evaluate and unwrap the scratch scene's object; the copy's mesh joins what is `kept`.

    The `keeper` learns of the scene, and is given the unwrap; `unwraps` that may be this one are, too. Ends
    amid the stage RASTER, which `texels` goes on with. Raises InputError for what cannot be baked, or is not
    what the keeper's pieces are of.
    """
    yield Progress(Stage.EVALUATE, 0, 1)
    evaluated = evaluate(scratch, original)
    if keeper is not KEEPS_NOTHING:
        keeper.expect({"mesh": mesh_digest(evaluated), "object's place": matrix_digest(evaluated)})
        keeper.expect(scene_digests(scratch))
    source = None if spec.source is None else _evaluate_source(scratch, original, spec.source, keeper)
    yield Progress(Stage.UNWRAP, 0, 1)
    shape = evaluated
    if spec.unwrap_at is not None and spec.unwrap_at != spec.frame:
        shape = _shape_at(scratch, original, spec.unwrap_at, evaluated)
    unwrapped = yield from _unwrap(shape, spec, keeper, {} if unwraps is None else unwraps)
    yield Progress(Stage.RASTER, 0, 1)
    mesh = baked_mesh(evaluated, unwrapped.uv, unwrapped.layer)
    kept.append(mesh)
    prepared = Prepared(
        mesh=mesh,
        surface=surface_mesh(evaluated, mesh, unwrapped.layer),
        matrix_world=evaluated.matrix_world,
        uv_layer=unwrapped.layer,
        width=unwrapped.width,
        height=unwrapped.height,
        islands=unwrapped.islands,
        digest=_digest(evaluated, unwrapped.uv),
    )
    if source is None:
        return prepared
    extrusion = spec.extrusion or default_extrusion(prepared.surface.position)
    landing = yield from land(prepared.texels(), source, original.name, extrusion)
    if landing.missed:
        log.warning(landing.complaint)
    return replace(prepared, source=landing)


def _evaluate_source(
    scratch: bpy.types.Scene, original: bpy.types.Object, name: str, keeper: Keeper
) -> EvaluatedMesh:
    source = evaluate(scratch, find_source(scratch, original, name))
    if keeper is not KEEPS_NOTHING:
        keeper.expect({"source's mesh": mesh_digest(source), "source's place": matrix_digest(source)})
    return source


def _digest(evaluated: EvaluatedMesh, uv: Floats) -> str:
    found = hashlib.sha256()
    for values in (evaluated.position, evaluated.triangles, evaluated.normal, uv):
        found.update(f"{values.shape}".encode() + np.ascontiguousarray(values).tobytes())
    return f"sha256:{found.hexdigest()}"


@dataclass(frozen=True)
class _Unwrapped:
    uv: Floats
    layer: str
    width: int
    height: int
    islands: int | None


def _shape_at(
    scratch: bpy.types.Scene, original: bpy.types.Object, frame: int, evaluated: EvaluatedMesh
) -> EvaluatedMesh:
    """The mesh as it is at another frame, if it has the same triangles then, else as it was `evaluated`."""
    with at_frame(scratch, frame):
        found = evaluate(scratch, original)
    if np.array_equal(found.triangles, evaluated.triangles):
        return found
    log.warning(
        "object '%s' has other faces at frame %d than at %d: it is unwrapped anew, "
        "and its atlases do not fit one mesh",
        original.name,
        frame,
        scratch.frame_current,
    )
    return evaluated


def _unwrap(
    evaluated: EvaluatedMesh, spec: BakeSpec, keeper: Keeper, known: Unwraps
) -> Generator[Progress, None, _Unwrapped]:
    if spec.uv_layer is not None:
        uv = user_uv(evaluated, spec.uv_layer)
        return _Unwrapped(uv, spec.uv_layer, spec.texels, spec.texels, None)
    piece = keeper.found(_UNWRAP)
    if piece is None:
        key = (
            f"{mesh_digest(evaluated)} {matrix_digest(evaluated)} {spec.texels} {spec.unwrap} {spec.padding}"
        )
        if key not in known:
            options = UnwrapOptions(padding=spec.padding)
            found = yield from unwrap_steps(evaluated, spec.texels, spec.unwrap, options)
            known[key] = {"uv": found.uv, "size": np.array([found.width, found.height, found.islands])}
        piece = known[key]
        keeper.keep(_UNWRAP, piece)
    width, height, islands = (int(number) for number in piece["size"])
    return _Unwrapped(piece["uv"], UV_LAYER, width, height, islands)
