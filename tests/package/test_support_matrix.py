# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The page on what goes with what says what the code does, for every kind and layout."""

from __future__ import annotations

import pytest

from radtex_addon.bake.spec import Kind
from tests.package import support_matrix

pytestmark = pytest.mark.one_blender


def test_the_page_is_what_the_code_refuses() -> None:
    remedy = "python -m tests.package.support_matrix"
    assert support_matrix.PAGE.read_text(encoding="utf-8") == support_matrix.page(), remedy


def test_no_cell_is_empty_and_no_kind_is_left_out() -> None:
    rows = [line for line in support_matrix.page().splitlines() if line.startswith("| ")]
    cells = [cell.strip() for row in rows for cell in row.strip("|").split("|")]
    assert all(cells)
    assert {row.split("|")[1].strip().partition(",")[0] for row in rows} >= set(Kind)
