# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Damage that knows an EXR's header: attributes, channels, tiles, the table of chunks, and our JSON in it."""

from __future__ import annotations

import struct
from random import Random
from typing import NamedTuple

from radtex_addon.formats.containers.exr import ATTRIBUTE

from .mutate import ODD, damage, odd, set_field
from .mutate_json import mutate_json

_EXR_TYPES = ("int", "float", "string", "box2i", "chlist", "compression", "tiledesc", "bytes", "stringvector")
_EXR_NAMES = (
    *("dataWindow", "displayWindow", "chunkCount", "name", "type", "tiles", "view", "multiView"),
    "x" * 40,
)
_DEEP = ("deepscanline", "deeptile", "tiledimage", "scanlineimage", "nonsense")


class _Attribute(NamedTuple):
    """Of an EXR's header: where it begins, its type, and where its value lies."""

    start: int
    name: bytes
    type: bytes
    value: int
    size: int


def mutate_exr(data: bytearray, random: Random) -> None:
    """Change the header, the chunks' table or a chunk."""
    attributes = _attributes(data)
    deed = random.randrange(10)
    if deed == 0:
        data[4:8] = struct.pack("<I", 2 | random.choice((0, 0x200, 0x400, 0x800, 0x1000, 0x1800, 0x1A00, 1)))
    elif deed == 1:
        _mutate_chunks(data, random, attributes)
    elif deed == 2:
        one = _sidecar(data)
        text = data[one.value : one.value + one.size]
        mutate_json(text, random)
        put_text(data, bytes(text))
    elif deed == 3:
        value = struct.pack("<4i", *(random.choice((*ODD[:37], 3, -1, -5, 11, 7)) for _ in range(4)))
        _add(data, random, random.choice((b"dataWindow", b"displayWindow")), b"box2i", value)
    elif deed == 4:
        value = odd(random, 4) + odd(random, 4) + bytes([random.choice((0, 1, 2, 16, 17, 255))])
        _add(data, random, b"tiles", b"tiledesc", value)
    elif deed == 5:
        name, kind = (random.choice(words).encode() for words in (_EXR_NAMES, _EXR_TYPES))
        value = random.randbytes(random.choice((0, 4, 9, 90)))
        _add(data, random, name * random.choice((1, 1, 20)), kind, value)
    else:
        _mutate_attribute(data, random, random.choice(attributes))


def _mutate_attribute(data: bytearray, random: Random, one: _Attribute) -> None:
    deed = random.randrange(7)
    value = bytes(data[one.value : one.value + one.size])
    if deed == 0:
        set_field(data, random, one.value - 4, 4)  # its size
    elif deed == 1:
        del data[one.start : one.value + one.size]
    elif deed == 2:
        data[one.start : one.start] = data[one.start : one.value + one.size]  # twice
    elif deed == 3:
        data[one.start : one.start + 1] = random.randbytes(1)
    elif one.type == b"chlist" and deed < 6:
        _put(data, one, _channels(value, random))
    elif one.type == b"compression":
        data[one.value] = random.choice((*range(14), 127, 255))
    elif one.name == b"type" or (one.type == b"string" and deed == 4):
        _put(data, one, random.choice(_DEEP).encode())
    else:
        place = random.randrange(max(1, one.size))
        set_field(data, random, one.value + place - place % 4, 4)


def _channels(value: bytes, random: Random) -> bytes:
    """A list of channels, altered: its names, pixel types and sampling, or more of them."""
    channels = []
    while value[:1] not in (b"", b"\0"):
        name, _, rest = value.partition(b"\0")
        channels.append([name, *struct.unpack("<iB3x2i", rest[:16])])
        value = rest[16:]
    one = random.choice(channels)
    deed = random.randrange(5)
    if deed == 0:
        one[0] = random.choice((b"R", b"\xff", b"a" * 300, b"a.b.c", b"..", b"word0000", b"x\n", b" "))
    elif deed == 1:
        one[1] = random.choice((0, 1, 2, 3, -1, 2**31 - 1))
    elif deed == 2:
        one[random.choice((3, 4))] = random.choice((0, 2, 3, 16, -1, -(2**31), 2**31 - 1))
    elif deed == 3:
        channels += ([b"c%05d" % index, *one[1:]] for index in range(random.choice((1, 20, 1000))))
    else:
        channels.append(list(one))
    return b"".join(channel[0] + b"\0" + struct.pack("<iB3x2i", *channel[1:]) for channel in channels) + b"\0"


def _mutate_chunks(data: bytearray, random: Random, attributes: list[_Attribute]) -> None:
    end = attributes[-1].value + attributes[-1].size + 1
    deed = random.randrange(4)
    if deed == 0:
        set_field(data, random, end + 8 * random.randrange(4), 8)
        return
    (place,) = struct.unpack_from("<Q", data, end + 8 * random.randrange(3))
    if deed in (1, 2):
        set_field(data, random, place + random.choice((0, 4, 4, 8)), 4)
    else:
        inner = bytearray(data[place:])
        damage(inner, random)
        data[place:] = inner


def _attributes(data: bytearray) -> list[_Attribute]:
    found, place = [], 8
    while place < len(data) and data[place]:
        name_end = data.index(0, place)
        type_end = data.index(0, name_end + 1)
        (size,) = struct.unpack_from("<I", data, type_end + 1)
        value = type_end + 5
        found.append(
            _Attribute(place, bytes(data[place:name_end]), bytes(data[name_end + 1 : type_end]), value, size)
        )
        place = value + size
    return found


def _sidecar(data: bytearray) -> _Attribute:
    """The sidecar's JSON in the header."""
    return next(attribute for attribute in _attributes(data) if attribute.name == ATTRIBUTE.encode())


def put_text(data: bytearray, text: bytes) -> None:
    """Put another JSON into the header."""
    _put(data, _sidecar(data), text)


def _put(data: bytearray, one: _Attribute, value: bytes) -> None:
    """Another value for an attribute, which the chunks' table then does not know of: it is moved along."""
    moved = len(value) - one.size
    ends = _attributes(data)[-1]
    data[one.value - 4 : one.value + one.size] = struct.pack("<I", len(value)) + value
    _move_chunks(data, ends.value + ends.size + 1 + moved, moved)


def _add(data: bytearray, random: Random, name: bytes, kind: bytes, value: bytes) -> None:
    """An attribute with that value, in the place of one of its name if there is one."""
    known = [attribute for attribute in _attributes(data) if attribute.name == name]
    if known and random.random() < 0.9:
        _put(data, known[0], value)
        return
    added = name + b"\0" + kind + b"\0" + struct.pack("<I", len(value)) + value
    data[8:8] = added
    last = _attributes(data)[-1]
    _move_chunks(data, last.value + last.size + 1, len(added))


def _move_chunks(data: bytearray, table: int, by: int) -> None:
    """Correct the table's offsets, as far as they look like some."""
    place = table
    first = len(data)
    while place + 8 <= min(first, len(data)):
        (offset,) = struct.unpack_from("<Q", data, place)
        if not table <= offset + by <= len(data):
            return
        first = min(first, offset + by)
        struct.pack_into("<Q", data, place, offset + by)
        place += 8
