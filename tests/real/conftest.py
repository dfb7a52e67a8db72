# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What tests of shaders share."""

from __future__ import annotations

from collections.abc import Iterator

import moderngl
import pytest


@pytest.fixture(scope="module")
def context() -> Iterator[moderngl.Context]:
    """OpenGL over EGL, without a window."""
    with moderngl.create_context(standalone=True, backend="egl") as context:  # type: ignore[arg-type]  # wrong stub
        yield context
