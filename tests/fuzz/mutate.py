# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Damage to bytes that knows nothing of formats, and odd values for what does."""

from __future__ import annotations

import struct
from collections.abc import Callable
from random import Random

ODD = (
    *(0, 1, 2, 3, 4, 5, 7, 8, 9, 15, 16, 17, 31, 32, 33, 63, 64, 65, 127, 128, 129, 255, 256, 257),
    *(1000, 4095, 4096, 16383, 16384, 16385, 30000, 32767, 32768, 65535, 65536, 10**6, 10**8),
    *(2**30, 2**31 - 2, 2**31 - 1, 2**31, 2**31 + 1, 2**32 - 2, 2**32 - 1),
    *(2**32, 2**40, 2**62, 2**63 - 1, 2**63, 2**64 - 2, 2**64 - 1),
)
Mutator = Callable[[bytearray, Random], None]  # in place


def odd(random: Random, size: int) -> bytes:
    """A whole number of `size` bytes, little-endian, that programs stumble over."""
    value = random.choice(ODD) if random.random() < 0.8 else random.getrandbits(64)
    return (value % (1 << 8 * size)).to_bytes(size, "little")


def nudged(random: Random, data: bytes) -> bytes:
    """The little-endian number `data` a little larger or smaller."""
    step = random.choice((-8, -4, -2, -1, 1, 2, 4, 8))
    return ((int.from_bytes(data, "little") + step) % (1 << 8 * len(data))).to_bytes(len(data), "little")


def set_field(data: bytearray, random: Random, place: int, size: int) -> None:
    """Put another number into a field, if the file is as long."""
    if 0 <= place <= len(data) - size:
        field = bytes(data[place : place + size])
        data[place : place + size] = nudged(random, field) if random.random() < 0.3 else odd(random, size)


def damage(data: bytearray, random: Random) -> None:
    """Flip, set, cut, repeat or move some bytes, those near the beginning more often."""
    if not data:
        data += random.randbytes(16)
        return
    place = random.randrange(len(data))
    if random.random() < 0.6:
        place = random.randrange(min(len(data), 256))
    length = min(random.choice((1, 2, 4, 8, 16, 64, 300)), len(data) - place)
    kind = random.randrange(8)
    if kind == 0:
        data[place] ^= 1 << random.randrange(8)
    elif kind == 1:
        data[place] = random.choice((0, 1, 9, 10, 32, 34, 46, 92, 127, 128, 192, 237, 254, 255))
    elif kind in (2, 3):
        set_field(data, random, place, random.choice((2, 4, 4, 8)))
    elif kind == 4:
        del data[place : place + length]
    elif kind == 5:
        data[place:place] = random.randbytes(length)
    elif kind == 6:
        other = random.randrange(len(data))
        data[other:other] = data[place : place + length]
    else:
        del data[place:]


def mutated(data: bytes, random: Random, ways: tuple[Mutator, ...], most: int = 1 << 16) -> bytes:
    """`data` after one to eight changes, by `ways` that know its format or by `damage`."""
    changed = bytearray(data)
    for _ in range(random.choice((1, 1, 1, 2, 2, 3, 5, 8))):
        way = random.choice(ways) if ways and random.random() < 0.7 else damage
        try:
            way(changed, random)
        except (ValueError, LookupError, TypeError, StopIteration, struct.error, RecursionError):
            damage(changed, random)  # what it was made for is not there any more
        del changed[most:]
    return bytes(changed)
