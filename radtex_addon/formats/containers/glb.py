# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Binary glTF 2.0: one JSON chunk, one binary chunk, and accessors as numpy arrays."""

from __future__ import annotations

import json
import os
import struct
from dataclasses import dataclass
from io import BufferedReader
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ...core.errors import FormatError
from ..disk.memory import check_memory
from ..disk.regular import MOST_TEXT, open_regular

_MAGIC, _VERSION = b"glTF", 2
_JSON, _BINARY = b"JSON", b"BIN\0"
_TYPES: dict[int, np.dtype[Any]] = {
    5120: np.dtype("i1"),
    5121: np.dtype("u1"),
    5122: np.dtype("<i2"),
    5123: np.dtype("<u2"),
    5125: np.dtype("<u4"),
    5126: np.dtype("<f4"),
}
_COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963

Values = npt.NDArray[Any]


@dataclass(eq=False)
class Glb:
    """A glTF document and the buffer of its buffer views; `source` names it in errors."""

    document: dict[str, Any]
    buffer: bytearray
    source: str = "the glTF"

    @classmethod
    def read(cls, path: Path) -> Glb:
        """Read a .glb. Raises FormatError, with the path, if it is damaged, no .glb, or too large."""
        try:
            with open_regular(path) as file:
                chunks = _read_chunks(path, file)
        except OSError as error:
            raise FormatError(f"{path} cannot be read: {error.strerror or error}") from error
        try:
            document = json.loads(chunks.get(_JSON, b""))
        except (ValueError, RecursionError) as error:
            raise FormatError(f"{path} is damaged, its JSON cannot be read: {error}") from error
        if not isinstance(document, dict):
            raise FormatError(f"{path} is damaged: its JSON is no object")
        return cls(document, chunks.get(_BINARY, bytearray()), str(path))

    def write(self, path: Path) -> None:
        """Write the file directly to `path`. Raises OSError where the system refuses."""
        others = self.document.get("buffers", [])[1:]
        self.document["buffers"] = [{"byteLength": len(self.buffer)}, *others]
        text = json.dumps(self.document, separators=(",", ":"), ensure_ascii=False).encode()
        chunks = _chunk(_JSON, text, b" ") + _chunk(_BINARY, bytes(self.buffer), b"\0")
        path.write_bytes(struct.pack("<4sII", _MAGIC, _VERSION, 12 + len(chunks)) + chunks)

    def accessor(self, index: int) -> Values:
        """The values of an accessor: (N,) for scalars, else (N, components); not sparse.

        Normalised ones are float32, in [-1, 1]. Raises FormatError, with the source, if the document has no
        such accessor or the buffer is too short.
        """
        try:
            accessor = self.document["accessors"][index]
            view = self.document["bufferViews"][accessor["bufferView"]]
            dtype, width = _TYPES[accessor["componentType"]], _COMPONENTS[accessor["type"]]
            if view.get("buffer", 0) != 0:
                raise FormatError(f"{self.source} is compressed by {', '.join(view.get('extensions', {}))}")
            numbers = [view.get("byteOffset", 0), accessor.get("byteOffset", 0), accessor["count"]]
            stride = view.get("byteStride", width * dtype.itemsize)
        except (LookupError, TypeError, AttributeError) as error:
            raise self._without(index) from error
        if any(type(number) is not int or number < 0 for number in (*numbers, stride)):
            raise self._without(index)
        first, count, size = numbers[0] + numbers[1], numbers[2], width * dtype.itemsize
        if stride < size or first + ((count - 1) * stride + size if count else 0) > len(self.buffer):
            raise self._without(index)
        values: Values = np.ndarray(
            (count, width), dtype, self.buffer, first, (stride, dtype.itemsize)
        ).copy()
        if accessor.get("normalized") is True and dtype.kind != "f":
            values = np.maximum(values / np.float32(np.iinfo(dtype).max), -1).astype(np.float32)
        return values[:, 0] if width == 1 else values

    def _without(self, index: int) -> FormatError:
        return FormatError(
            f"{self.source} is damaged: it holds no values of accessor {index}; export it again"
        )

    def add_view(self, data: bytes, **facts: object) -> int:
        """Append bytes to the buffer, aligned to four bytes; returns the index of their view."""
        self.buffer.extend(b"\0" * (-len(self.buffer) % 4))
        views = self.document.setdefault("bufferViews", [])
        views.append({"buffer": 0, "byteOffset": len(self.buffer), "byteLength": len(data), **facts})
        self.buffer.extend(data)
        return len(views) - 1

    def add_vertices(self, values: Values, bounds: bool = False, dtype: str = "<f4") -> int:
        """Append an attribute of vertices (N, 2 to 4); returns the index of its accessor.

        As float32, or rounded to a `dtype` of whole numbers, which stand for [0, 1] or [-1, 1]. Each vertex
        begins at a multiple of four bytes, as glTF wants it. With `bounds` the accessor has the minimum and
        maximum of each component.
        """
        kind = {width: name for name, width in _COMPONENTS.items()}[values.shape[1]]
        number, whole = np.dtype(dtype), np.dtype(dtype).kind in "iu"
        size = values.shape[1] * number.itemsize
        filler = -size % 4 // number.itemsize
        if whole:
            values = np.rint(values.astype(np.float64) * np.iinfo(number).max)
        stored = values.astype(number)
        padded = np.pad(stored, ((0, 0), (0, filler)))
        stride = {"byteStride": size + filler * number.itemsize} if filler else {}
        accessor = {
            "bufferView": self.add_view(padded.tobytes(), **stride, target=ARRAY_BUFFER),
            "componentType": next(code for code, each in _TYPES.items() if each == number),
            **({"normalized": True} if whole else {}),
            "count": len(stored),
            "type": kind,
        }
        if bounds:
            accessor |= {"min": stored.min(axis=0).tolist(), "max": stored.max(axis=0).tolist()}
        accessors = self.document.setdefault("accessors", [])
        accessors.append(accessor)
        return len(accessors) - 1

    def rows(self, index: int) -> npt.NDArray[np.uint8]:
        """The bytes of an accessor of vertices that `add_vertices` made, or Blender: (N, stride)."""
        accessor = self.document["accessors"][index]
        view = self.document["bufferViews"][accessor["bufferView"]]
        begin = view.get("byteOffset", 0)
        data = np.frombuffer(self.buffer[begin : begin + view["byteLength"]], np.uint8)
        return data.reshape(accessor["count"], -1)

    def add_rows(self, like: int, rows: npt.NDArray[np.uint8]) -> int:
        """Append vertices (N, stride), bytes as of the accessor `like`; returns the index of theirs."""
        former = self.document["accessors"][like]
        view = self.document["bufferViews"][former["bufferView"]]
        facts = {key: view[key] for key in ("byteStride", "target") if key in view}
        accessors = self.document["accessors"]
        accessors.append({**former, "bufferView": self.add_view(rows.tobytes(), **facts), "count": len(rows)})
        return len(accessors) - 1

    def add_indices(self, indices: Values) -> int:
        """Append numbers of vertices (N,), of 16 bits if these suffice; returns their accessor's index."""
        number = np.dtype("<u2" if indices.max(initial=0) < 0xFFFF else "<u4")
        accessor = {
            "bufferView": self.add_view(indices.astype(number).tobytes(), target=ELEMENT_ARRAY_BUFFER),
            "componentType": next(code for code, each in _TYPES.items() if each == number),
            "count": len(indices),
            "type": "SCALAR",
        }
        accessors = self.document.setdefault("accessors", [])
        accessors.append(accessor)
        return len(accessors) - 1

    def compact(self) -> None:
        """Remove accessors and buffer views that no primitive and no image uses."""
        primitives = [part for mesh in self.document["meshes"] for part in mesh["primitives"]]
        used: list[int] = []
        for part in primitives:
            for index in (*part["attributes"].values(), part["indices"]):
                if index not in used:
                    used.append(index)
        accessors = [self.document["accessors"][index] for index in used]
        number = {index: place for place, index in enumerate(used)}
        for part in primitives:
            part["attributes"] = {name: number[index] for name, index in part["attributes"].items()}
            part["indices"] = number[part["indices"]]
        self.document["accessors"] = accessors
        owners = [*accessors, *self.document.get("images", [])]
        old, views = self.buffer, self.document["bufferViews"]
        self.buffer, self.document["bufferViews"] = bytearray(), []
        moved: dict[int, int] = {}
        for owner in owners:
            index = owner["bufferView"]
            if index not in moved:
                view = dict(views[index])
                first = view.pop("byteOffset", 0)
                data = bytes(old[first : first + view.pop("byteLength")])
                moved[index] = self.add_view(data, **{k: v for k, v in view.items() if k != "buffer"})
            owner["bufferView"] = moved[index]


def _read_chunks(path: Path, file: BufferedReader) -> dict[bytes, bytearray]:
    """Read the JSON and the binary chunk. Raises FormatError if the file is no .glb, OSError."""
    size = os.fstat(file.fileno()).st_size
    head = file.read(12)
    if size < 20 or head[:4] != _MAGIC or struct.unpack_from("<I", head, 4)[0] != _VERSION:
        raise FormatError(f"{path} is no binary glTF 2.0")
    if struct.unpack_from("<I", head, 8)[0] != size:
        raise FormatError(f"{path} is damaged: it is not as long as it says")
    chunks: dict[bytes, bytearray] = {}
    while len(head := file.read(8)) == 8:
        length, kind = struct.unpack("<I4s", head)
        if length > size - file.tell():
            raise FormatError(f"{path} is damaged: it is cut short")
        if kind not in (_JSON, _BINARY) or kind in chunks:
            file.seek(length, os.SEEK_CUR)
            continue
        if kind == _JSON and length > MOST_TEXT:
            raise FormatError(f"{path} is damaged: {length} bytes of it are JSON")
        check_memory(str(path), length)
        chunks[kind] = bytearray(length)
        if file.readinto(memoryview(chunks[kind])) != length:
            raise FormatError(f"{path} was cut short while it was read: export it again")
    return chunks


def _chunk(kind: bytes, data: bytes, filler: bytes) -> bytes:
    padded = data + filler * (-len(data) % 4)
    return struct.pack("<I4s", len(padded), kind) + padded
