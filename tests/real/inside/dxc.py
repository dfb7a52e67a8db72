# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Compile HLSL by Microsoft's compiler, a library: python3 dxc.py LIBRARY

Reads lines, [SOURCE, BINARY, ARGUMENTS...] in JSON each, and answers each by what the compiler says, then a
line ANSWERED; of a bad shader there is no binary. Runs where only Python is. The interface is COM's, by
tables of functions: dxcapi.h of DirectXShaderCompiler. On Linux each table has two destructors behind
IUnknown's three functions.
"""

from __future__ import annotations

import ctypes
import json
import sys
import uuid
from pathlib import Path
from typing import Any

DESTRUCTORS = 2
UTF_8 = 65001
COMPILER = "73e22d93-e6ce-47f3-b5bf-f0664f39c1b0"
COMPILER_INTERFACE = "228b4687-5a6a-4730-900c-9702b2203f54"  # IDxcCompiler3
RESULT_INTERFACE = "58346cda-dde7-4497-9461-6f87af5e0659"  # IDxcResult
COMPILE, GET_STATUS, GET_RESULT, GET_ERRORS = 3, 3, 4, 5  # places in their tables, without destructors
GET_POINTER, GET_SIZE = 3, 4


class Text(ctypes.Structure):
    """DxcBuffer."""

    _fields_ = (("pointer", ctypes.c_void_p), ("size", ctypes.c_size_t), ("encoding", ctypes.c_uint))


def guid(text: str) -> bytes:
    return uuid.UUID(text).bytes_le


def method(instance: Any, place: int, result: Any, *arguments: Any) -> Any:
    """A function of an object's table, which takes the object first."""
    table = ctypes.cast(instance, ctypes.POINTER(ctypes.POINTER(ctypes.c_void_p)))[0]
    return ctypes.CFUNCTYPE(result, ctypes.c_void_p, *arguments)(table[place + DESTRUCTORS])


def blob(result: Any, place: int) -> bytes:
    """The bytes of one of a result's blobs."""
    found = ctypes.c_void_p()
    method(result, place, ctypes.c_int, ctypes.c_void_p)(result, ctypes.byref(found))
    if found.value is None:
        return b""
    size = method(found, GET_SIZE, ctypes.c_size_t)(found)
    return ctypes.string_at(method(found, GET_POINTER, ctypes.c_void_p)(found), size)


def compiled(library: str, source: bytes, arguments: list[str]) -> tuple[bool, bytes, str]:
    """Whether it is good, the binary, and what the compiler says."""
    compiler, result, status = ctypes.c_void_p(), ctypes.c_void_p(), ctypes.c_int(1)
    create = ctypes.CDLL(library).DxcCreateInstance
    if create(guid(COMPILER), guid(COMPILER_INTERFACE), ctypes.byref(compiler)):
        raise OSError(f"{library} has no compiler")
    text = Text(ctypes.cast(ctypes.c_char_p(source), ctypes.c_void_p), len(source), UTF_8)
    words = (ctypes.c_wchar_p * len(arguments))(*arguments)
    pointers = (
        ctypes.c_void_p,
        ctypes.c_void_p,
        ctypes.c_uint,
        ctypes.c_void_p,
        ctypes.c_char_p,
        ctypes.c_void_p,
    )
    code = method(compiler, COMPILE, ctypes.c_int, *pointers)(
        compiler,
        ctypes.byref(text),
        words,
        len(arguments),
        None,
        guid(RESULT_INTERFACE),
        ctypes.byref(result),
    )
    if code:
        raise OSError(f"{library} failed: {code:#x}")
    method(result, GET_STATUS, ctypes.c_int, ctypes.c_void_p)(result, ctypes.byref(status))
    return status.value == 0, blob(result, GET_RESULT), blob(result, GET_ERRORS).decode(errors="replace")


def main() -> None:
    """Compile until the input ends."""
    library = sys.argv[1]
    for line in sys.stdin:
        source, binary, *arguments = json.loads(line)
        good, data, said = compiled(library, Path(source).read_bytes(), arguments)
        if good:
            Path(binary).write_bytes(data)
        print(f"{said}\nANSWERED", flush=True)


main()
