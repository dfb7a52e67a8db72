# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Vertices and triangles as the streams of glTF's EXT_meshopt_compression, written by its specification.

Appendix A of the extension's README has the streams, appendix B the filters. Streams of triangles are short
if neighbours follow one another and vertices are numbered as they are first met: `triangle_order`.
"""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from ...core.arrays import Floats

Rows = npt.NDArray[np.uint8]
Indices = npt.NDArray[np.int64]

_GROUP = 16  # vertices whose bytes are packed alike
_MOST_BLOCK, _BLOCK_BYTES = 256, 8192
_TAIL = 32
_ONE = 2**15 - 1  # stands for 1 in 16 bits
_EDGES, _VERTICES = 15, 13  # how many pushes ago edges, and vertices beside an edge, a code can name
_TABLE, _PLACES = 14, 14  # of triangles without such an edge: the table's entries, and places of vertices
_FREE = 15  # names no place: an index follows
_KEPT = 256  # edges and vertices that a writer remembers at most, of which only the latest count
_LONG = 1 << 40  # an age that no code names
_FOLLOWING = ((1, 2), (1, -1), (-2, -1))


def encode_vertices(rows: Rows) -> bytes:
    """Mode 0: `rows` (N, stride) of one vertex or more, whose stride is a multiple of four up to 256.

    Each byte is stored as its difference to the vertex before.
    """
    count, stride = rows.shape
    block = min(_BLOCK_BYTES // stride // _GROUP * _GROUP, _MOST_BLOCK)
    steps = np.diff(rows, axis=0, prepend=rows[:1])
    steps = np.where(steps & 0x80, ~(steps << 1), steps << 1).astype(np.uint8)
    whole = count // block * block
    parts = [_blocks(steps[:whole].reshape(-1, block, stride))] if whole else []
    if rest := count - whole:
        parts.append(_blocks(np.pad(steps[whole:], ((0, -rest % _GROUP), (0, 0)))[None]))
    return b"".join([b"\xa0", *parts, bytes(max(0, _TAIL - stride)), rows[0].tobytes()])


def _blocks(steps: Rows) -> bytes:
    """Blocks of differences (blocks, vertices, stride), of each block all first bytes before all second."""
    blocks, vertices, stride = steps.shape
    lines = blocks * stride
    groups = steps.transpose(0, 2, 1).reshape(lines, vertices // _GROUP, _GROUP)
    costs = [
        np.where(groups.any(axis=2), _TAIL, 0),
        4 + (groups >= 3).sum(axis=2),
        8 + (groups >= 15).sum(axis=2),
        np.full(groups.shape[:2], _GROUP),
    ]
    mode = np.stack(costs).argmin(axis=0)
    header = _packed(np.pad(mode, ((0, 0), (0, -mode.shape[1] % 4))), 2)
    narrow, wide = (_packed(np.minimum(groups, 2**bits - 1), bits, first_high=True) for bits in (2, 4))
    packed = np.where((mode == 1)[..., None], np.pad(narrow, ((0, 0), (0, 0), (0, 4))), wide)
    length, least = np.array([0, 4, 8, 0])[mode], np.array([256, 3, 15, 0])[mode]
    kept = np.concatenate([np.arange(8) < length[..., None], groups >= least[..., None]], axis=2)
    told = np.concatenate([packed, groups], axis=2)
    mask = np.concatenate([np.full(header.shape, True), kept.reshape(lines, -1)], axis=1)
    stream: Rows = np.concatenate([header, told.reshape(lines, -1)], axis=1)[mask]
    return stream.tobytes()


def _packed(numbers: npt.NDArray[Any], bits: int, first_high: bool = False) -> Rows:
    """Numbers (..., n) of so many bits as bytes; the first of a byte in its lowest bits, or its highest."""
    shifts = bits * np.arange(8 // bits)
    parts = numbers.reshape(*numbers.shape[:-1], -1, len(shifts)).astype(np.int64)
    packed: Rows = (parts << (shifts[::-1] if first_high else shifts)).sum(axis=-1).astype(np.uint8)
    return packed


def octahedral(vectors: Floats, bits: int, last: Floats) -> npt.NDArray[np.int16]:
    """Filter 1: unit vectors (N, 3) as octahedral numbers of so many bits, up to 16: (N, 4).

    `last` (N,), in [-1, 1], becomes the fourth number, which the filter does not touch.
    """
    one = 2 ** (bits - 1) - 1
    flat = vectors / np.abs(vectors).sum(axis=1, keepdims=True)
    folded = np.copysign(1 - np.abs(flat[:, 1::-1]), flat[:, :2])
    told = np.empty((len(vectors), 4), dtype="<i2")
    told[:, :2] = np.rint(np.where(flat[:, 2:] < 0, folded, flat[:, :2]) * one)
    told[:, 2] = one
    told[:, 3] = np.rint(last * _ONE)
    return told


def from_octahedral(told: npt.NDArray[np.int16]) -> npt.NDArray[np.int16]:
    """What readers make of `octahedral`'s numbers: (N, 4) of 16 bits, which stand for [-1, 1]."""
    one = told[:, 2:3].astype(np.float64)
    flat = told[:, :2] / one
    z = 1 - np.abs(flat).sum(axis=1, keepdims=True)
    flat -= np.copysign(np.maximum(-z, 0), flat)
    vectors = np.concatenate([flat, z], axis=1)
    vectors /= np.linalg.norm(vectors, axis=1, keepdims=True)
    scaled = np.rint(vectors * _ONE).astype("<i2")
    return np.concatenate([scaled, told[:, 3:]], axis=1)


def exponential(whole: Indices, exponent: int) -> npt.NDArray[np.uint32]:
    """Filter 3: the floats whole * 2^exponent, where `whole` has 24 bits with its sign."""
    low = (whole & 0xFFFFFF).astype(np.uint32)
    told: npt.NDArray[np.uint32] = np.uint32(exponent & 0xFF) << np.uint32(24) | low
    return told


def triangle_order(triangles: Indices) -> Indices:
    """The triangles (T, 3) in an order in which most share an edge with one shortly before, (T, 3).

    Each begins at the corner at which that edge does.
    """
    twins = _twins(triangles).tolist()
    vertices = triangles.ravel().tolist()
    done, met = bytearray(len(triangles)), bytearray(int(triangles.max(initial=-1)) + 1)
    recent: deque[int] = deque(maxlen=_EDGES)
    earlier: list[int] = []
    order: list[int] = []
    begun = 0
    while len(order) < len(triangles):
        edge = _closest(recent, done, met, vertices)
        while edge < 0 and earlier:
            edge = earlier.pop()
            edge = -1 if done[edge // 3] else edge
        if edge < 0:
            begun = done.index(0, begun)
            edge = 3 * begun
        done[edge // 3] = 1
        order.append(edge)
        met[vertices[edge]] = 1
        for corner in _following(edge):
            met[vertices[corner]] = 1
            recent.append(twins[corner])
            if twins[corner] >= 0:
                earlier.append(twins[corner])
    begin = np.array(order, dtype=np.int64)
    turned = begin[:, None] // 3 * 3 + (begin[:, None] + np.arange(3)) % 3
    ordered: Indices = triangles.ravel()[turned]
    return ordered


def _closest(recent: deque[int], done: bytearray, met: bytearray, vertices: Sequence[int]) -> int:
    """A recent half edge of a triangle that is not done, best one all of whose corners were met; or -1."""
    found = -1
    for edge in reversed(recent):
        if edge >= 0 and not done[edge // 3]:
            if met[vertices[_following(edge)[1]]]:
                return edge
            if found < 0:
                found = edge
    return found


def _following(edge: int) -> tuple[int, int]:
    """The two half edges that follow one of a triangle, of which 3 t to 3 t + 2 are those of triangle t."""
    return _FOLLOWING[edge % 3][0] + edge, _FOLLOWING[edge % 3][1] + edge


def _twins(triangles: Indices) -> Indices:
    """For each half edge (3 T,) of triangles (T, 3) one that runs the other way; -1 where there is none."""
    begin, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    size = int(begin.max(initial=0)) + 1
    along, against = begin * size + end, end * size + begin
    order = np.argsort(along, kind="stable")
    found = order[np.minimum(np.searchsorted(along[order], against), len(along) - 1)]
    twins: Indices = np.where(along[found] == against, found, -1)
    return twins


def encode_triangles(triangles: Indices) -> bytes:
    """Mode 1: triangles (T, 3), in their order; each may be read back from another of its corners."""
    writer = _TriangleWriter()
    for a, b, c in triangles.tolist():
        writer.write(a, b, c)
    return writer.stream()


class _Code(NamedTuple):
    """A triangle's code, the byte of its vertices' places, -1 for none, and steps to indices that follow."""

    code: int
    places: int
    steps: list[int]


class _TriangleWriter:
    """What a reader knows at each triangle: edges and vertices by when they were last pushed."""

    def __init__(self) -> None:
        self._codes: list[_Code] = []
        self._edges: dict[tuple[int, int], int] = {}
        self._vertices: dict[int, int] = {}
        self._edge_count = self._vertex_count = 0
        self._next = self._last = 0

    def write(self, a: int, b: int, c: int) -> None:
        turns = ((a, b, c), (b, c, a), (c, a, b))
        age, turn = min((self._edge_age(x, y), place) for place, (x, y, _) in enumerate(turns))
        if age < _EDGES:
            self._beside(age, *turns[turn])
        else:
            self._alone(*next((each for each in turns if each[0] == self._next), turns[0]))

    def _beside(self, age: int, a: int, b: int, c: int) -> None:
        """A triangle at a recent edge a, b."""
        back, steps = self._vertex_age(c), []
        if c == self._next:
            self._next += 1
            place = 0
        elif 0 < back < _VERTICES:
            place = back
        else:
            place = {-1: 13, 1: 14}.get(c - self._last, _FREE)
            if place == _FREE:
                steps.append(c - self._last)
            self._last = c
        if not 0 < place < _VERTICES:
            self._push_vertex(c)
        self._codes.append(_Code(age << 4 | place, -1, steps))
        self._push_edges((c, b), (a, c))

    def _alone(self, a: int, b: int, c: int) -> None:
        steps: list[int] = []
        places = [self._place(vertex, steps, first) for vertex, first in ((a, True), (b, False), (c, False))]
        for vertex, place in zip((a, b, c), places, strict=True):
            if place in (0, _FREE):
                self._push_vertex(vertex)
        first, second, third = places
        self._codes.append(_Code(0xFF if first else 0xFE, second << 4 | third, steps))
        self._push_edges((b, a), (c, b), (a, c))

    def _place(self, vertex: int, steps: list[int], first: bool) -> int:
        """How a vertex is named; a free one adds its step. The first of a triangle is the next or free."""
        if vertex == self._next:
            self._next += 1
            return 0
        if not first and (back := self._vertex_age(vertex)) < _PLACES:
            return back + 1
        steps.append(vertex - self._last)
        self._last = vertex
        return _FREE

    def _edge_age(self, a: int, b: int) -> int:
        pushed = self._edges.get((a, b))
        return _LONG if pushed is None else self._edge_count - 1 - pushed

    def _vertex_age(self, vertex: int) -> int:
        pushed = self._vertices.get(vertex)
        return _LONG if pushed is None else self._vertex_count - 1 - pushed

    def _push_edges(self, *edges: tuple[int, int]) -> None:
        for edge in edges:
            self._edges[edge] = self._edge_count
            self._edge_count += 1
        if len(self._edges) > _KEPT:
            self._edges = {edge: at for edge, at in self._edges.items() if self._edge_count - at <= _EDGES}

    def _push_vertex(self, vertex: int) -> None:
        self._vertices[vertex] = self._vertex_count
        self._vertex_count += 1
        if len(self._vertices) > _KEPT:
            oldest = self._vertex_count - _PLACES
            self._vertices = {vertex: at for vertex, at in self._vertices.items() if at >= oldest}

    def stream(self) -> bytes:
        """The whole stream, with a table of the places that are named most."""
        named = (each.places for each in self._codes if each.code == 0xFE)
        counts = Counter(byte for byte in named if byte and _FREE not in (byte >> 4, byte & 15))
        table = [0, *(byte for byte, _ in counts.most_common(_TABLE - 1))]  # 0xFE and 0 means something else
        entries = {byte: 0xF0 | number for number, byte in enumerate(table)}
        codes, data = bytearray(), bytearray()
        for code, places, steps in self._codes:
            if code == 0xFE and places in entries:
                codes.append(entries[places])
            else:
                codes.append(code)
                data += bytes([places] if places >= 0 else [])
            for step in steps:
                _add_number(data, ~(step << 1) if step < 0 else step << 1)
        return b"".join([b"\xe1", codes, data, bytes(table).ljust(16, b"\0")])


def _add_number(data: bytearray, value: int) -> None:
    """Append a number of 7 bits a byte, the lowest first."""
    while value > 0x7F:
        data.append(value & 0x7F | 0x80)
        value >>= 7
    data.append(value)
