# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which materials of a bake can be shown by their own images, and how their colours follow from these.

The nodes say which images a material has (`scene.image_materials`), the texels' maps what Cycles makes of
these. A few constants of each material are fitted to both. It keeps the maps of the bake where its images
differ from what Cycles saw.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from ....core.arrays import Bools, Floats, Ints
from ....core.frame import normalised
from ....core.surface import SurfaceMesh
from ....formats.codecs.srgb import from_srgb
from ....prepare.prepared import Prepared
from ....scene.image_materials import ImageMaterial, ImageSource, image_materials, looked_up, pixels_of
from ....scene.mesh.backs import fronts, twin_numbers
from ....scene.mesh.cage import barycentric
from ....scene.mesh.copy import calc_tangents
from ....scene.mesh.joined import values_in
from ....scene.working_space import REC_709, working_space
from ..fit.texel_maps import mean_colours
from ..lookup.images import Colour, ImageLook, normal_of_image
from ..samples import LayeredSamples

_LEAST = 8  # texels of a material, from which on its constants can be fitted
_SURE = 0.85  # of the texels
_OFF, _ANYWAY = 0.15, 0.01  # how far these may be off what Cycles saw: times its mean, plus
_TURNED = 10.0  # degrees between normals, likewise
_ROUNDS = 3
_USUAL = 0.04  # the glossy colour of a dielectric, to which few texels of it are drawn
_DRAWN = 1e-5


@dataclass(frozen=True, eq=False)
class _Texels:
    """Texels of one material: their `uv` (K, 2) on its layer, and colours and normals (K, 3) that Cycles saw.

    `frame`: T, B and N there, (K, 3) each, in world space, interpolated but not normalised.
    """

    uv: Floats
    diffuse: Floats
    glossy: Floats
    normal: Floats
    frame: tuple[Floats, Floats, Floats]


def image_looks(prepared: Prepared, capture: LayeredSamples, triangle: Ints) -> tuple[ImageLook | None, ...]:
    """How each of the bake's materials is shown by its own images, None where it is not; empty if none is.

    `triangle` (K,) are the captured texels' in the prepared surface.
    """
    if prepared.source is not None or prepared.part is not None or capture.exits is not None:
        return ()
    if working_space() != REC_709:  # images would be converted to it, and the lookup is in Rec.709
        return ()
    found = image_materials((piece.original, piece.mesh) for piece in prepared.pieces)
    means = mean_colours(capture.material, capture.coarse["glossy"], capture.light.plan)
    looks: list[ImageLook | None] = [None] * (int(prepared.surface.material_numbers.max()) + 1)
    own = _own_faces(prepared)
    for number, material in found.items():
        some = np.flatnonzero((capture.material == number) & own[triangle])
        if len(some) >= _LEAST:
            texels = _texels(prepared, capture, material.uv_map, triangle, some)
            looks[number] = _fitted(material, texels, means[number])
    return tuple(looks) if any(looks) else ()


def _own_faces(prepared: Prepared) -> Bools:
    """Which triangles of the surface are no twins, (F,)."""
    found = []
    for piece in prepared.pieces:
        twin = twin_numbers(piece.mesh)
        count = len(cast(Any, piece.mesh).polygons)
        found.append(np.ones(count, dtype=bool) if twin is None else fronts(twin))
    return np.concatenate(found)


def _texels(prepared: Prepared, capture: LayeredSamples, layer: str, triangle: Ints, some: Ints) -> _Texels:
    plan, surface = capture.light.plan, prepared.surface
    faces, place = triangle[some], plan.points[some].astype(np.float64)
    weight = barycentric(surface.position[surface.triangles[faces]], place)
    uv = _layer_uv(prepared, layer)

    def at(corners: Floats) -> Floats:
        mixed: Floats = np.einsum("kc,kcx->kx", weight, corners)
        return mixed

    corner = _corner_normals(surface)
    tangent, sign = calc_tangents(surface.position, surface.triangles, corner, uv)
    normal, along = at(corner[faces]), at(tangent[faces])
    bitangent = sign[faces, :1] * np.cross(normal, along)

    def seen(name: str) -> Floats:
        return capture.coarse[name].reshape(-1, 3)[plan.texel[some]].astype(np.float64)

    frame = (along, bitangent, normal)
    return _Texels(at(uv[faces]), seen("diffuse"), seen("glossy"), seen("normal"), frame)


def _layer_uv(prepared: Prepared, layer: str) -> Floats:
    """The coordinates of the surface's triangles on a UV layer, (F, 3, 2), 0 for pieces that lack it."""
    found = []
    for piece in prepared.pieces:
        mesh: Any = piece.mesh
        if layer in mesh.attributes:
            found.append(values_in(mesh.attributes[layer].data, "vector", 2).reshape(-1, 3, 2))
        else:
            found.append(np.zeros((len(mesh.polygons), 3, 2), dtype=np.float32))
    return np.concatenate(found)


def _corner_normals(surface: SurfaceMesh) -> Floats:
    """The unit normals at the triangles' corners in world space, (F, 3, 3) float32.

    The surface's own have another length where the object is scaled, and a normal map would be weighed by it.
    """
    unit: Floats = normalised(surface.normal.reshape(-1, 3)).reshape(-1, 3, 3).astype(np.float32)
    return unit


def _fitted(material: ImageMaterial, texels: _Texels, mean: Floats) -> ImageLook | None:
    """The look whose constants are nearest to what Cycles saw; None if it is another.

    Some texels' rays meet what lies close above the surface: those that are furthest off count for nothing.
    """
    base = _values(material.base_image, texels.uv, colour=True) * np.array(material.base)
    metal = material.metallic * _values(material.metallic_image, texels.uv)[:, :1]
    bare, shiny = 1 - metal, base * metal
    rough = material.roughness * _values(material.roughness_image, texels.uv)[:, :1]
    fading = 0.0
    kept = np.ones(len(base), dtype=bool)
    off: Floats = np.zeros(len(base))
    diffuse: Floats = np.ones(3)
    dielectric = metallic = diffuse
    for _ in range(_ROUNDS):
        diffuse = _scale((base * bare)[kept], texels.diffuse[kept])
        fading = _fading(bare[kept], shiny[kept], rough[kept], texels.glossy[kept])
        dull = bare * (1 - fading * rough**4)
        dielectric, metallic = _glossy([dull[kept], shiny[kept]], texels.glossy[kept])
        off = np.abs(diffuse * base * bare - texels.diffuse).max(axis=1) / _tolerated(texels.diffuse)
        also = np.abs(dielectric * dull + metallic * shiny - texels.glossy).max(axis=1)
        off = np.maximum(off, also / _tolerated(texels.glossy))
        kept = off <= np.quantile(off, _SURE)
    strength = 0.0 if material.normal is None else material.strength
    bump = _values(material.normal, texels.uv)[:, :3]
    turned = _turned(normal_of_image(bump, texels.frame, strength), texels.normal)
    if off[kept].max() > 1 or np.quantile(turned, _SURE) > _TURNED:
        return None
    factor = np.array(material.base)
    return ImageLook(
        material.uv_map,
        _colour(diffuse * factor),
        _colour(dielectric / mean),
        _colour(metallic * factor / mean),
        material.metallic,
        strength,
        float(np.float32(fading * material.roughness**4)),
    )


def _scale(shown: Floats, seen: Floats) -> Floats:
    """By how much each channel of colours (K, 3) differs, (3,); 1 where they are black."""
    strong = (shown * shown).sum(axis=0)
    scale: Floats = np.where(strong > 1e-9, (shown * seen).sum(axis=0) / np.maximum(strong, 1e-9), 1.0)
    return scale


def _tolerated(seen: Floats) -> float:
    """How far a texel may be off the colours (K, 3) that were seen."""
    return _ANYWAY + _OFF * float(np.abs(seen).mean())


def _fading(bare: Floats, shiny: Floats, rough: Floats, seen: Floats) -> float:
    """By how much the roughness (K, 1) to the fourth dims what is no metal, 0 to 1."""
    full, lost, _ = _glossy([bare, -bare * rough**4, shiny], seen)
    return min(float(lost.sum()) / max(float(full.sum()), 1e-9), 1.0)


def _glossy(parts: Sequence[Floats], seen: Floats) -> list[Floats]:
    """The factors (3,) of glossy colours' parts, (K, 1) or (K, 3) each, by least squares.

    They are drawn to what is usual: the first is what is no metal, the last what is.
    """
    found = []
    usual = np.array([_USUAL, *[0.0] * (len(parts) - 2), 1.0])
    for channel in range(3):
        rows = np.stack([np.broadcast_to(part, seen.shape)[:, channel] for part in parts], axis=1)
        pull = _DRAWN * len(rows) * np.eye(len(parts))
        found.append(np.linalg.solve(rows.T @ rows + pull, rows.T @ seen[:, channel] + pull @ usual))
    return list(np.maximum(np.array(found), 0).T)


def _turned(shown: Floats, seen: Floats) -> Floats:
    """Degrees between normals (K, 3), (K,)."""
    length = np.maximum(np.linalg.norm(seen, axis=1), 1e-6)
    cosine = (shown * seen).sum(axis=1) / length
    turned: Floats = np.degrees(np.arccos(np.clip(cosine, -1, 1)))
    return turned


def _values(source: ImageSource | None, uv: Floats, colour: bool = False) -> Floats:
    """An image's values at uv (K, 2), (K, 3) or (K, 1), linear if it is of `colour`; 1 without one."""
    if source is None:
        return np.ones((len(uv), 3), dtype=np.float32)
    found = looked_up(pixels_of(source.image), uv, source.wrap)[:, :3]
    if colour:
        found = from_srgb(found)
    return found if source.channel is None else found[:, [source.channel]]


def _colour(values: Floats) -> Colour:
    red, green, blue = (float(np.float32(value)) for value in values)
    return red, green, blue
