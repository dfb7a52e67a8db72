# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads EXT_meshopt_compression by its specification, step by step as it is written there."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from radtex_addon.formats.containers.glb import Glb

EXTENSION = "EXT_meshopt_compression"


def attributes(stream: bytes, count: int, stride: int) -> npt.NDArray[np.uint8]:
    """Mode 0: (count, stride) bytes."""
    assert stream[0] == 0xA0
    before = list(stream[-stride:])
    rows: list[tuple[int, ...]] = []
    at = 1
    most = min((8192 // stride) & ~15, 256)
    while len(rows) < count:
        size = min(count - len(rows), most)
        groups = -(-size // 16)
        columns = []
        for byte in range(stride):
            header = stream[at : at + -(-groups // 4)]
            at += len(header)
            deltas: list[int] = []
            for group in range(groups):
                found, at = _group(stream, at, header[group // 4] >> 2 * (group % 4) & 3)
                deltas += found
            column, value = [], before[byte]
            for delta in deltas[:size]:
                value = (value + (~(delta >> 1) if delta & 1 else delta >> 1)) & 0xFF
                column.append(value)
            before[byte] = value
            columns.append(column)
        rows += list(zip(*columns, strict=True))
    assert at == len(stream) - max(32, stride)
    return np.array(rows, np.uint8)


def _group(stream: bytes, at: int, mode: int) -> tuple[list[int], int]:
    """The 16 deltas of a group, and where the next begins."""
    if mode in (0, 3):
        return (list(stream[at : at + 16]), at + 16) if mode else ([0] * 16, at)
    bits = 2 * mode
    packed = int.from_bytes(stream[at : at + 2 * bits], "big")
    at += 2 * bits
    found = []
    for place in range(16):
        value = packed >> bits * (15 - place) & (1 << bits) - 1
        if value == (1 << bits) - 1:
            value, at = stream[at], at + 1
        found.append(value)
    return found, at


class _Triangles:
    def __init__(self, stream: bytes, count: int) -> None:
        assert stream[0] == 0xE1
        self.codes, self.data = stream[1 : 1 + count], list(stream[1 + count : -16])
        self.table = stream[-16:]
        assert self.table[-2:] == b"\0\0"
        self.next = self.last = 0
        self.edges: list[tuple[int, int]] = []
        self.vertices: list[int] = []

    def free(self) -> int:
        value = shift = 0
        while True:
            byte = self.data.pop(0)
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                break
        self.last += ~(value >> 1) if value & 1 else value >> 1
        return self.last

    def following(self) -> int:
        self.next += 1
        return self.next - 1

    def read(self, code: int) -> tuple[int, int, int]:
        if code < 0xF0:
            a, b = self.edges[-1 - (code >> 4)]
            low = code & 15
            if 0 < low < 13:
                c = self.vertices[-1 - low]
            else:
                c = (
                    self.following()
                    if low == 0
                    else self.last + (1, -1)[low == 13]
                    if low < 15
                    else self.free()
                )
                self.last = self.last if low == 0 else c
                self.vertices.append(c)
            self.edges += [(c, b), (a, c)]
            return a, b, c
        places = self.table[code & 15] if code < 0xFE else self.data.pop(0)
        self.next = 0 if code >= 0xFE and places == 0 else self.next
        a = self.free() if code == 0xFF else self.following()
        b, c = (self._named(place) for place in (places >> 4, places & 15))
        self.edges += [(b, a), (c, b), (a, c)]
        self.vertices.append(a)
        self.vertices += [
            vertex for vertex, place in ((b, places >> 4), (c, places & 15)) if place in (0, 15)
        ]
        return a, b, c

    def _named(self, place: int) -> int:
        if place == 0:
            return self.following()
        return self.free() if place == 15 else self.vertices[-place]


def triangles(stream: bytes, count: int) -> npt.NDArray[np.int64]:
    """Mode 1: `count` triangles, (count, 3)."""
    reader = _Triangles(stream, count)
    found = [reader.read(code) for code in reader.codes]
    assert not reader.data
    return np.array(found, np.int64)


def unfiltered(rows: npt.NDArray[np.uint8], kind: str) -> npt.NDArray[np.uint8]:
    """What a filter makes of rows of bytes: OCTAHEDRAL of 16 bits, EXPONENTIAL."""
    if kind == "EXPONENTIAL":
        numbers = rows.view("<i4")
        floats = (numbers << 8 >> 8) * 2.0 ** (numbers >> 24)
        return np.ascontiguousarray(floats.astype("<f4")).view(np.uint8)
    assert kind == "OCTAHEDRAL"
    numbers = rows.view("<i2").astype(np.float64)
    x, y = numbers[:, 0] / numbers[:, 2], numbers[:, 1] / numbers[:, 2]
    z = 1 - np.abs(x) - np.abs(y)
    t = np.minimum(z, 0)
    x, y = x + np.where(x >= 0, t, -t), y + np.where(y >= 0, t, -t)
    length = np.sqrt(x * x + y * y + z * z)
    unit = np.stack([x / length, y / length, z / length], axis=1)
    shorts = np.concatenate([np.rint(unit * 32767), numbers[:, 3:]], axis=1).astype("<i2")
    return np.ascontiguousarray(shorts).view(np.uint8)


def expanded(glb: Glb) -> Glb:
    """The same glTF without the extension; it is changed in place."""
    document, packed = glb.document, bytes(glb.buffer)
    views, document["bufferViews"], glb.buffer = document["bufferViews"], [], bytearray()
    for view in views:
        told: dict[str, Any] = view.get("extensions", {}).get(EXTENSION, view)
        begin = told.get("byteOffset", 0)
        data = packed[begin : begin + told["byteLength"]]
        if told is not view:
            data = _decoded(data, told)
            assert len(data) == view["byteLength"]
        facts = {key: view[key] for key in ("byteStride", "target") if key in view}
        glb.add_view(data, **facts)
    document["buffers"] = document["buffers"][:1]
    return glb


def _decoded(stream: bytes, told: dict[str, Any]) -> bytes:
    count, stride = told["count"], told["byteStride"]
    if told["mode"] == "TRIANGLES":
        return triangles(stream, count // 3).astype(f"<u{stride}").tobytes()
    rows = attributes(stream, count, stride)
    return (unfiltered(rows, told["filter"]) if "filter" in told else rows).tobytes()
