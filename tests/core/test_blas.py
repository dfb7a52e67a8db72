# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""NumPy's BLAS works in one thread where that is asked for, and only there."""

from __future__ import annotations

import numpy as np
import pytest

from radtex_addon.core import blas
from radtex_addon.core.blas import one_blas_thread


def threads() -> int:
    found = blas._openblas()
    if found is None:
        pytest.skip("this NumPy has no OpenBLAS")
    library, name = found
    return int(library[name.format("get")]())


def test_openblas_has_its_threads_again_afterwards_even_after_an_error() -> None:
    before = threads()
    with one_blas_thread():
        assert threads() == 1
        with one_blas_thread():
            assert threads() == 1
        assert threads() == 1
    assert threads() == before
    with pytest.raises(ZeroDivisionError), one_blas_thread():
        _ = 1 // 0
    assert threads() == before


def test_another_blas_is_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(blas, "_openblas", lambda: None)
    with one_blas_thread():
        assert np.eye(2) @ np.ones(2) == pytest.approx(1)
