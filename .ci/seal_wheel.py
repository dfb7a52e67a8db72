# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Make a Linux wheel's modules keep to their own symbols, so that they run inside Blender's binary.

Blender links OpenEXR dynamically, and on Linux what a program links comes first when a module that it loads
looks up a symbol: our OpenEXR would call Blender's older one in the midst of its work. Blender 4.5 crashes so
on the first file, 5.2 writes noise. Marked DT_SYMBOLIC, a module looks into itself first; nothing else in it
changes. (RTLD_DEEPBIND at run time would also go round Blender's memory allocator, and aborts.)
NOTICE.md tells whoever gets the zip.
"""

from __future__ import annotations

import hashlib
import io
import struct
from base64 import urlsafe_b64encode
from collections.abc import Iterator
from zipfile import ZIP_DEFLATED, ZipFile

_ELF_64_LITTLE = b"\x7fELF\x02\x01"
_PT_DYNAMIC = 2
_DT_NULL, _DT_SYMBOLIC, _DT_FLAGS, _DF_SYMBOLIC = 0, 16, 30, 2


def seal_wheel(wheel: bytes) -> bytes:
    """The wheel with every module in it sealed and its RECORD brought up to date."""
    sealed = io.BytesIO()
    with ZipFile(io.BytesIO(wheel)) as source, ZipFile(sealed, "w", ZIP_DEFLATED) as target:
        contents = {info.filename: source.read(info) for info in source.infolist()}
        record = next(name for name in contents if name.endswith(".dist-info/RECORD"))
        for name in [name for name in contents if name.endswith(".so")]:
            published = contents[name]
            contents[name] = seal_module(published)
            contents[record] = contents[record].replace(_entry(name, published), _entry(name, contents[name]))
        for info in source.infolist():
            target.writestr(info, contents[info.filename], ZIP_DEFLATED)
    return sealed.getvalue()


def seal_module(module: bytes) -> bytes:
    """The ELF file with DT_SYMBOLIC set. Raises ValueError if it is no 64-bit ELF or has no room for it."""
    if not module.startswith(_ELF_64_LITTLE):
        raise ValueError("not a 64-bit little-endian ELF file")
    result = bytearray(module)
    entries = list(_dynamic(module))
    tags = [tag for _offset, tag, _value in entries]
    if _DT_SYMBOLIC in tags:
        return module
    if _DT_FLAGS in tags:
        offset, tag, value = entries[tags.index(_DT_FLAGS)]
        struct.pack_into("<qQ", result, offset, tag, value | _DF_SYMBOLIC)
        return bytes(result)
    if tags.count(_DT_NULL) < 2:  # the last one ends the table; linkers leave some spare
        raise ValueError("no room in its dynamic section")
    struct.pack_into("<qQ", result, entries[tags.index(_DT_NULL)][0], _DT_SYMBOLIC, 0)
    return bytes(result)


def _dynamic(module: bytes) -> Iterator[tuple[int, int, int]]:
    """The dynamic section's entries: where each lies, its tag, its value."""
    (table,) = struct.unpack_from("<Q", module, 32)
    size, count = struct.unpack_from("<HH", module, 54)
    for header in range(table, table + size * count, size):
        kind, _flags, offset, _address, _physical, length = struct.unpack_from("<IIQQQQ", module, header)
        if kind == _PT_DYNAMIC:
            for entry in range(offset, offset + length, 16):
                tag, value = struct.unpack_from("<qQ", module, entry)
                yield entry, tag, value


def _entry(name: str, content: bytes) -> bytes:
    """A file's line in RECORD, as the wheel's specification has it."""
    digest = urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
    return f"{name},sha256={digest},{len(content)}".encode()
