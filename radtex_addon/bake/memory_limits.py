# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Check before a bake that it fits into memory: not a check of the specification, as machines differ."""

from __future__ import annotations

from ..core.errors import MemoryLimitError
from ..core.messages import Setting, do
from ..formats.disk.memory import physical_memory, readable_size
from .session import BYTES_PER_PIXEL
from .spec_checks import size_of
from .spec_fields import SpecFields

_LEAST_TILE = 32 << 20  # bytes that must be left for a render, unless the whole atlas needs less


def check_memory(spec: SpecFields) -> None:
    """Raises MemoryLimitError if a bake needs more memory than this machine has, or than the user allows."""
    asked = size_of(spec)
    memory, most = physical_memory(), spec.atlas_bytes + min(_LEAST_TILE, spec.pixel_count * BYTES_PER_PIXEL)
    needed = readable_size(most)
    if memory is not None and spec.atlas_bytes > memory:
        raise MemoryLimitError(
            f"{asked} needs {needed} of memory, this machine has {readable_size(memory)}",
            do("lower one of them"),
        )
    if spec.memory_mb is not None and most > spec.memory_mb << 20:
        allowed = readable_size(spec.memory_mb << 20)
        raise MemoryLimitError(
            f"{asked} needs {needed} of memory beside the scene, {allowed} are allowed",
            do("allow more", Setting.MEMORY),
            do("lower one of them"),
        )
