# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files are told by their first bytes; a secret is no image, no font, no volume and no lamp's shape."""

from __future__ import annotations

import os
from pathlib import Path
from random import Random

import pytest

from radtex_addon.formats.disk.kinds_of_files import FileKind, open_of_kind

_TARGA = bytes([0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 24, 0]) + bytes(12)
_PACKED = [bytes([0, 0, kind, *bytes(9), 64, 0, 64, 0, 24, 0]) for kind in (10, 11)]  # Targa of few bytes
_KNOWN = {
    FileKind.IMAGE: (
        b"\x89PNG\r\n\x1a\n",
        b"\xff\xd8\xff\xe0",
        b"v/1\x01",
        b"#?RADIANCE\n",
        b"RIFF\0\0\0\0WEBP",
        _TARGA,
        *_PACKED,
        b"BM" + bytes(12) + b"(\0\0\0",
    ),
    FileKind.FONT: (b"\0\1\0\0", b"OTTO", b"ttcf\0\1", b"wOF2", b"%!PS-AdobeFont-1.0"),
    FileKind.VOLUME: (b" BDV\0\0\0\0\xe0\0\0\0",),
    FileKind.LAMP_SHAPE: (b"IESNA:LM-63-2002\r\n[TEST] x\r\nTILT=NONE\r\n1 1000 1", b"IESNA91\rTILT=NONE\r1"),
}

_SECRETS = (
    *(b"", b"\0", b"root:x:0:0:root:/root:/bin/bash\n", b"-----BEGIN OPENSSH PRIVATE KEY-----\n", b"{}"),
    *(b"[default]\naws_secret = x", b"\x7fELF\2\1\1", b"PK\3\4", b"SQLite format 3\0", b"BLENDER-v500"),
    *(b"a,b\n" * 999, b"BMW", b"true", b"OTT", b"%PDF-1.7", b"\x1f\x8b\x08", b"(\xb5/\xfd", bytes(4096)),
    *(b"KEY=TILT=1\n", b"#!/bin/sh\n", b"IESNA91\nTILT=NONE\n" + b" " * (2 << 20)),  # of many megabytes
)


@pytest.mark.parametrize("kind", FileKind)
def test_files_are_of_their_kind_alone(kind: FileKind, tmp_path: Path) -> None:
    path = tmp_path / "file"
    for other, beginnings in _KNOWN.items():
        for beginning in beginnings:
            path.write_bytes(beginning + bytes(100))
            if other is kind:
                with open_of_kind(path, kind) as file:
                    assert file.read(len(beginning)) == beginning
            else:
                with pytest.raises(ValueError, match=f"it is no {kind}"):
                    open_of_kind(path, kind)
    for secret in _SECRETS:
        path.write_bytes(secret)
        with pytest.raises(ValueError, match=f"it is no {kind}"):
            open_of_kind(path, kind)


def test_noise_and_text_are_hardly_ever_anything(tmp_path: Path) -> None:
    random, path, taken = Random(1), tmp_path / "file", 0
    for number in range(4000):
        data = random.randbytes(400) if number % 2 else bytes(random.choices(range(32, 127), k=400))
        path.write_bytes(data)
        for kind in FileKind:
            try:
                open_of_kind(path, kind).close()
                taken += 1
            except ValueError:
                pass
    assert taken <= 1  # of 16,000


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes")
def test_a_pipe_is_no_file_of_any_kind(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.vdb")
    with pytest.raises(OSError, match="pipe"):
        open_of_kind(tmp_path / "pipe.vdb", FileKind.VOLUME)
