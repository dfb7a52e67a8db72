# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertices of a glTF in fewer bytes: 16 bits a number where nobody sees the difference.

Places stay floats: 16 bits save four bytes a vertex, but scale the node, by which lookups would see other
normals and tangents, and programs that move it another object space. Where the mesh is compressed, places are
floats on a grid instead, which takes as few bytes and leaves the node as it is.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..formats.codecs.meshopt import (
    encode_triangles,
    encode_vertices,
    exponential,
    from_octahedral,
    octahedral,
    triangle_order,
)
from ..formats.containers.glb import Glb, Values
from ..settings.targets import TargetTraits

QUANTIZATION, MESHOPT = "KHR_mesh_quantization", "EXT_meshopt_compression"
_MOST_TEXELS = 2048  # along an atlas's side: coordinates are at most 1/64 of a texel off
_PLACES = 2**20  # of a compressed mesh, along its longest side
_FRAME, _ONE = ("NORMAL", "TANGENT"), 2**15 - 1
_BITS = 15  # of octahedral numbers; with one less, glass differs by 51 dB
_MOST_STEPS = 2**23  # from 0, of a place on the grid
_LEAST_EXPONENT = -100
_MOST_TRIANGLES = 2_000_000  # of a primitive that is put in order and compressed: 0.4 KB of memory each


def quantise(glb: Glb, traits: TargetTraits, texels: tuple[int, int], compressed: bool = False) -> None:
    """Store in fewer bits what the target's loaders read so, in place; `Glb.compact` drops the former values.

    `texels` are the width and height of the bake's atlas. Texture coordinates are core glTF; they stay floats
    where one of them is outside [0, 1], or if the atlas is so large that rounding could be seen. Normals and
    tangents need `KHR_mesh_quantization`; they have 16 bits, since chrome and glass show 8.

    If the mesh is going to be `compressed`, by `compress`, all of this is done, numbers are rounded to what
    compresses well, vertices that are equal then become one, and triangles change their order.
    """
    quantised = traits.quantised or compressed
    frame = _FRAME if quantised else ()
    short = traits.short_coordinates and max(texels) <= _MOST_TEXELS
    primitives = [part for mesh in glb.document["meshes"] for part in mesh["primitives"]]
    if compressed:
        _round(glb, primitives, frame)
    done: dict[int, int] = {}
    for primitive in primitives:
        attributes = primitive["attributes"]
        for name, index in attributes.items():
            if index not in done:
                done[index] = _stored(glb, name, index, frame, short)
            attributes[name] = done[index]
        if compressed and glb.document["accessors"][primitive["indices"]]["count"] <= 3 * _MOST_TRIANGLES:
            _reorder(glb, primitive)
    if quantised:
        _require(glb, QUANTIZATION)


def _require(glb: Glb, extension: str) -> None:
    for key in ("extensionsUsed", "extensionsRequired"):
        glb.document[key] = sorted({*glb.document.get(key, []), extension})


def _stored(glb: Glb, name: str, index: int, frame: Sequence[str], short: bool) -> int:
    """The index of an attribute's accessor in fewer bits, or its own."""
    if name in frame:
        return glb.add_vertices(glb.accessor(index), dtype="<i2")
    if short and name.startswith("TEXCOORD_"):
        values = glb.accessor(index)
        if _in_unit(values):
            return glb.add_vertices(values, dtype="<u2")
    return index


def _in_unit(values: Values) -> bool:
    inside: Any = (values >= 0) & (values <= 1)
    return bool(inside.all())


def _round(glb: Glb, primitives: Sequence[dict[str, Any]], frame: Sequence[str]) -> None:
    """Put all places on one grid, so that pieces still meet, and frames on the grid of an octahedron."""
    places = [glb.accessor(part["attributes"]["POSITION"]) for part in primitives]
    everything = np.concatenate(places)
    size = float(np.ptp(everything, axis=0).max(initial=0)) or 1.0
    step = 2.0 ** max(int(np.ceil(np.log2(size / _PLACES))), _LEAST_EXPONENT)
    on_grid = float(np.abs(everything).max(initial=0)) / step < _MOST_STEPS
    for part, place in zip(primitives, places, strict=True):
        attributes = part["attributes"]
        if on_grid:
            attributes["POSITION"] = glb.add_vertices(np.rint(place / step) * step, bounds=True)
        for name in frame:
            vectors = glb.accessor(attributes[name])
            rounded = from_octahedral(_octahedral(vectors)) / _ONE
            attributes[name] = glb.add_vertices(rounded[:, : vectors.shape[1]])


def _octahedral(vectors: Values) -> Values:
    last = vectors[:, 3] if vectors.shape[1] == 4 else np.zeros(len(vectors))
    return octahedral(vectors[:, :3].astype(np.float64), _BITS, last)


def _reorder(glb: Glb, primitive: dict[str, Any]) -> None:
    """Make one of vertices that are equal, and number them as triangles meet them, neighbours in a row."""
    attributes = primitive["attributes"]
    rows = np.concatenate([glb.rows(index) for index in attributes.values()], axis=1)
    whole = np.ascontiguousarray(rows).view(f"V{rows.shape[1]}").ravel()
    _, first, number = np.unique(whole, return_index=True, return_inverse=True)
    triangles = number.ravel()[glb.accessor(primitive["indices"]).astype(np.int64)].reshape(-1, 3)
    triangles = triangle_order(triangles)
    met, at = np.unique(triangles, return_index=True)
    order = met[np.argsort(at)]
    renumbered = np.zeros(len(first), dtype=np.int64)
    renumbered[order] = np.arange(len(order))
    chosen = first[order]
    for name, index in attributes.items():
        attributes[name] = glb.add_rows(index, glb.rows(index)[chosen])
    primitive["indices"] = glb.add_indices(renumbered[triangles].ravel())


def compress(glb: Glb) -> None:
    """Compress all vertices and triangles by EXT_meshopt_compression, in place, without changing one.

    What would not get smaller stays as it is. Images come behind the mesh, in their order, so that a page can
    show the mesh before these have come. Afterwards `glb` is only to be written.
    """
    document, old = glb.document, glb.buffer
    owners: dict[int, tuple[str, dict[str, Any]]] = {}
    for part in (part for mesh in document["meshes"] for part in mesh["primitives"]):
        for name, index in (*part["attributes"].items(), ("", part["indices"])):
            accessor = document["accessors"][index]
            owners[accessor["bufferView"]] = (name, accessor)
    glb.buffer, views, document["bufferViews"] = bytearray(), document["bufferViews"], []
    images = [image["bufferView"] for image in document.get("images", [])]
    placed: dict[int, dict[str, Any]] = {}
    unpacked = 0
    for number in [*(each for each in range(len(views)) if each not in images), *dict.fromkeys(images)]:
        view = views[number]
        begin, length = view["byteOffset"], view["byteLength"]
        data = bytes(old[begin : begin + length])
        facts = {key: view[key] for key in ("byteStride", "target") if key in view}
        owner = owners.get(number)
        whole = owner is None or (not owner[0] and owner[1]["count"] > 3 * _MOST_TRIANGLES)
        stream = None if whole or owner is None else _stream(data, *owner)
        if stream is None or len(stream.data) >= length:
            glb.add_view(data, **facts)
            placed[number] = document["bufferViews"][-1]
            continue
        glb.add_view(stream.data)
        packed = document["bufferViews"][-1] | stream.facts()
        place = {"buffer": 1, "byteOffset": unpacked, "byteLength": length}
        placed[number] = {**place, **facts, "extensions": {MESHOPT: packed}}
        unpacked += length + -length % 4
    document["bufferViews"] = [placed[number] for number in range(len(views))]
    if unpacked:
        document["buffers"] = [{}, {"byteLength": unpacked, "extensions": {MESHOPT: {"fallback": True}}}]
        _require(glb, MESHOPT)


class _Stream(NamedTuple):
    """A compressed view, of some `elements` of `stride` bytes each."""

    data: bytes
    mode: str
    elements: int
    stride: int
    filter: str = ""

    def facts(self) -> dict[str, Any]:
        """As the extension names them."""
        told = {"byteStride": self.stride, "mode": self.mode, "count": self.elements}
        return {**told, "filter": self.filter} if self.filter else told


def _stream(data: bytes, name: str, accessor: Mapping[str, Any]) -> _Stream:
    """A view of one accessor as a stream; `name` is the attribute's, empty for indices."""
    count = accessor["count"]
    stride = len(data) // count
    if not name:
        indices = np.frombuffer(data, f"<u{stride}").astype(np.int64)
        return _Stream(encode_triangles(indices.reshape(-1, 3)), "TRIANGLES", count, stride)
    rows = np.frombuffer(data, np.uint8).reshape(count, stride)
    filtered, kind = rows, ""
    if name == "POSITION":
        places = rows.view("<f4")
        if (exponent := _exponent(places)) is not None:
            whole = np.rint(places.astype(np.float64) / 2.0**exponent).astype(np.int64)
            filtered, kind = exponential(whole, exponent).view(np.uint8), "EXPONENTIAL"
    elif name in _FRAME and accessor.get("normalized"):
        vectors = rows.view("<i2")
        coded = _octahedral(vectors / _ONE)
        if np.array_equal(from_octahedral(coded), vectors):
            filtered, kind = coded.view(np.uint8), "OCTAHEDRAL"
    return _Stream(encode_vertices(np.ascontiguousarray(filtered)), "ATTRIBUTES", count, stride, kind)


def _exponent(values: Values) -> int | None:
    """The largest power of two of which all floats are multiples, if they are so by less than 2^23."""
    mantissas, exponents = np.frexp(values[values != 0].astype(np.float64))
    if not mantissas.size:
        return 0
    whole = (np.abs(mantissas) * 2**24).astype(np.int64)
    lowest = np.round(np.log2(whole & -whole)).astype(np.int64)
    exponent = int((exponents - 24 + lowest).min())
    return exponent if np.abs(values).max() < 2.0**exponent * _MOST_STEPS else None
