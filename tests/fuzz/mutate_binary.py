# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Damage that knows where formats keep their sizes: GLB and the pieces of a checkpoint."""

from __future__ import annotations

import hashlib
import io
import json
import re
import struct
import zipfile
from random import Random
from typing import Any

import numpy as np

from .mutate import damage, set_field
from .mutate_json import mutate_json

_NPY_WORDS = (
    (b"'<f4'", b"'|O'"),
    (b"'<f4'", b"[('a', '<f4'), ('b', '|O')]"),
    (b"'<f4'", b"'<f8'"),
    (b"'<f4'", b"'|V0'"),
    (b"'<f4'", b"'<U1000000000'"),
    (b"(4, 4, 4)", b"(9999999999999, 4)"),
    (b"(4, 4, 4)", b"(-1, 4)"),
    (b"(4, 4, 4)", b"(" + b"1," * 70 + b")"),
    (b"(4, 4, 4)", b"(0, 9223372036854775807, 9)"),
    (b"(4, 4, 4)", b"(4.0,)"),
    (b"(4, 4, 4)", b"()"),
    (b"False", b"True"),
    (b"'shape'", b"'shop'"),
    (b"{", b"{" + b"(" * 300),
)


def mutate_glb(data: bytearray, random: Random) -> None:
    """Change a field of the header or a chunk, or the JSON with its sizes made right again."""
    if random.random() < 0.2:
        set_field(data, random, random.choice((4, 8, 12, 16)), 4)
        return
    (length,) = struct.unpack_from("<I", data, 12)
    text, rest = bytearray(data[20 : 20 + length]), bytes(data[20 + length :])
    mutate_json(text, random)
    body = struct.pack("<I4s", len(text), b"JSON") + text + rest
    data[:] = struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def mutate_npy(data: bytearray, random: Random) -> None:
    """Change an array's header, or cut it."""
    (length,) = struct.unpack_from("<H", data, 8)
    header = bytes(data[10 : 10 + length])
    deed = random.randrange(4)
    if deed == 0:
        before = header[header.index(b"(") : header.index(b")") + 1]
        shape = [int(word) for word in before.strip(b"()").split(b",") if word.strip()]
        odd = (0, 1, -1, 2**31, 2**63, 10**30, 3)
        shape[random.randrange(len(shape))] = random.choice(odd)
        shape = random.choice((shape, shape[::-1], shape[:-1], [*shape, 1], []))
        header = header.replace(before, f"({', '.join(map(str, shape))},)".encode() if shape else b"()")
    elif deed == 1:
        kind = random.choice(
            (b"'|O'", b"'<f4'", b"'<f8'", b"'|V0'", b"'|b1'", b"'<U9'", b"'>i2'", b"'<M8[s]'")
        )
        header = re.sub(rb"'[<>|][a-z]\d+'", kind, header)
    elif deed == 2:
        header = header.replace(*random.choice(((b"False", b"True"), (b"'shape'", b"'shop'"), (b"}", b""))))
    else:
        damage(data, random)
        return
    data[8 : 10 + length] = struct.pack("<H", len(header)) + header


def mutate_npz(data: bytearray, random: Random) -> None:
    """Change an archive's members, or the archive."""
    if random.random() < 0.3:
        damage(data, random)
        return
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            members = {name: bytearray(archive.read(name)) for name in archive.namelist()}
    except Exception as error:  # zipfile raises whatever it meets in a damaged one
        raise ValueError("it is no archive any more") from error
    name = random.choice(list(members))
    deed = random.randrange(6)
    if deed == 0:
        del members[name]
    elif deed == 1:
        members[random.choice(("../texel.npy", "texel", "other.npy"))] = members.pop(name)
    elif deed == 2:
        values = _values(members[name])
        flat = values.ravel()
        flat[random.randrange(len(flat))] = random.choice((0, 1, 255, 7))
        changed = io.BytesIO()
        np.save(changed, random.choice((values, values[::-1], values[:-1], values.repeat(2, 0))))
        members[name] = bytearray(changed.getvalue())
    elif deed == 3:
        members[name] += bytes(random.choice((1, 1 << 10, 1 << 18)))
    else:
        mutate_npy(members[name], random)
    packed = io.BytesIO()
    method = random.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA))
    with zipfile.ZipFile(packed, "w", method) as archive:
        for name, member in members.items():
            archive.writestr(name, bytes(member))
    data[:] = packed.getvalue()


def _values(data: bytearray) -> Any:
    """The array of a .npy. Raises ValueError where it is none any more."""
    try:
        return np.load(io.BytesIO(data))
    except Exception as error:  # numpy raises whatever it meets
        raise ValueError("it is no array any more") from error


def mutate_piece(data: bytearray, random: Random) -> None:
    """Change what a piece says of itself or an array's header; the digest at its end is made right again."""
    body = bytearray(data[:-32])
    deed = random.randrange(4)
    line_end = body.index(b"\n")
    if deed == 0:
        text = bytearray(body[:line_end])
        mutate_json(text, random)
        body[:line_end] = text.replace(b"\n", b" ")
    elif deed == 1:
        says = json.loads(body[:line_end])
        says["arrays"] = random.choice(
            ([], says["arrays"] * 2, ["a"] * 100, "rows", {"a": 1}, [["a"]], [None])
        )
        body[:line_end] = json.dumps(says).encode()
    elif deed == 2:
        before, after = random.choice(_NPY_WORDS)
        body[:] = body.replace(before, after, 1)
    else:
        inner = body[line_end:]
        damage(inner, random)
        body[line_end:] = inner
    data[:] = body + hashlib.sha256(body).digest()
