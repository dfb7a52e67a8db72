# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Binary glTF 2.0: one JSON chunk, one binary chunk, and accessors as numpy arrays."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..core.errors import FormatError

_MAGIC, _VERSION = b"glTF", 2
_JSON, _BINARY = b"JSON", b"BIN\0"
_TYPES: dict[int, np.dtype[Any]] = {
    5121: np.dtype("u1"),
    5123: np.dtype("<u2"),
    5125: np.dtype("<u4"),
    5126: np.dtype("<f4"),
}
_COMPONENTS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
_ARRAY_BUFFER = 34962

Values = npt.NDArray[Any]


@dataclass(eq=False)
class Glb:
    """A glTF document, and the buffer that its buffer views lie in."""

    document: dict[str, Any]
    buffer: bytearray

    @classmethod
    def read(cls, path: Path) -> Glb:
        """Read a .glb. Raises FormatError, with the path, for what is none."""
        try:
            data = path.read_bytes()
        except OSError as error:
            raise FormatError(f"{path} cannot be read: {error.strerror or error}") from error
        if len(data) < 20 or data[:4] != _MAGIC or struct.unpack_from("<I", data, 4)[0] != _VERSION:
            raise FormatError(f"{path} is no binary glTF 2.0")
        if struct.unpack_from("<I", data, 8)[0] != len(data):
            raise FormatError(f"{path} is damaged: it is not as long as it says")
        chunks: dict[bytes, bytes] = {}
        place = 12
        while place + 8 <= len(data):
            length, kind = struct.unpack_from("<I4s", data, place)
            chunks.setdefault(kind, data[place + 8 : place + 8 + length])
            place += 8 + length
        try:
            document = json.loads(chunks.get(_JSON, b""))
        except (ValueError, RecursionError) as error:
            raise FormatError(f"{path} is damaged, its JSON cannot be read: {error}") from error
        if not isinstance(document, dict):
            raise FormatError(f"{path} is damaged: its JSON is no object")
        return cls(document, bytearray(chunks.get(_BINARY, b"")))

    def write(self, path: Path) -> None:
        """Write the file, straight to `path`. Raises OSError where the system refuses."""
        self.document["buffers"] = [{"byteLength": len(self.buffer)}]
        text = json.dumps(self.document, separators=(",", ":"), ensure_ascii=False).encode()
        chunks = _chunk(_JSON, text, b" ") + _chunk(_BINARY, bytes(self.buffer), b"\0")
        path.write_bytes(struct.pack("<4sII", _MAGIC, _VERSION, 12 + len(chunks)) + chunks)

    def accessor(self, index: int) -> Values:
        """The values of an accessor: (N,) of a scalar, else (N, components); not sparse, not interleaved."""
        accessor = self.document["accessors"][index]
        view = self.document["bufferViews"][accessor["bufferView"]]
        dtype, width = _TYPES[accessor["componentType"]], _COMPONENTS[accessor["type"]]
        first = int(view.get("byteOffset", 0) + accessor.get("byteOffset", 0))
        values: Values = np.frombuffer(self.buffer, dtype, int(accessor["count"]) * width, first).copy()
        return values if width == 1 else values.reshape(-1, width)

    def add_view(self, data: bytes, **facts: object) -> int:
        """Append bytes to the buffer, at a multiple of four; returns the index of their view."""
        self.buffer.extend(b"\0" * (-len(self.buffer) % 4))
        views = self.document.setdefault("bufferViews", [])
        views.append({"buffer": 0, "byteOffset": len(self.buffer), "byteLength": len(data), **facts})
        self.buffer.extend(data)
        return len(views) - 1

    def add_vertices(self, values: Values, bounds: bool = False) -> int:
        """Append an attribute of vertices (N, 2 to 4), as float32; returns the index of its accessor.

        With `bounds` the accessor says the least and the greatest of each component.
        """
        kind = {width: name for name, width in _COMPONENTS.items()}[values.shape[1]]
        stored = np.ascontiguousarray(values, dtype="<f4")
        accessor = {
            "bufferView": self.add_view(stored.tobytes(), target=_ARRAY_BUFFER),
            "componentType": 5126,
            "count": len(stored),
            "type": kind,
        }
        if bounds:
            accessor |= {"min": stored.min(axis=0).tolist(), "max": stored.max(axis=0).tolist()}
        accessors = self.document.setdefault("accessors", [])
        accessors.append(accessor)
        return len(accessors) - 1

    def compact(self) -> None:
        """Leave out accessors and buffer views that no primitive and no image uses."""
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


def _chunk(kind: bytes, data: bytes, filler: bytes) -> bytes:
    padded = data + filler * (-len(data) % 4)
    return struct.pack("<I4s", len(padded), kind) + padded
