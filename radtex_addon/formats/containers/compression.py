# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The compressions of EXR files, apart from what loads OpenEXR."""

from __future__ import annotations

from enum import StrEnum


class Compression(StrEnum):
    """Compression of the atlas: `dwaa` is lossy and small, the others are lossless."""

    ZIP = "zip"
    PIZ = "piz"
    DWAA = "dwaa"
