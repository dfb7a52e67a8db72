# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of renders in Rec.709, whatever space they were written in."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenEXR
import pytest

from radtex_addon.core.colour_spaces import KNOWN, converted, matrix_to_rec709
from radtex_addon.core.errors import FormatError
from radtex_addon.formats.render_space import render_matrix


def rendered(path: Path, *spaces: str | None) -> Path:
    """A file of as many parts as there are spaces, each of which says its own."""
    parts = []
    for number, space in enumerate(spaces):
        header = {"type": OpenEXR.scanlineimage, "name": f"part {number}"}
        if space is not None:
            header["colorInteropID"] = space
        parts.append(OpenEXR.Part(header, {"RGB": np.ones((2, 2, 3), dtype=np.float32)}))
    OpenEXR.File(parts).write(str(path))
    return path


def test_matrices_are_those_that_others_publish() -> None:
    """ITU-R BT.2407 for Rec.2020; the ACES project's for AP1 with Bradford's adaptation."""
    rec2020 = [(1.6605, -0.5876, -0.0728), (-0.1246, 1.1329, -0.0083), (-0.0182, -0.1006, 1.1187)]
    acescg = [(1.70505, -0.62179, -0.08326), (-0.13026, 1.14080, -0.01055), (-0.02400, -0.12897, 1.15297)]
    np.testing.assert_allclose(matrix_to_rec709("lin_rec2020_scene"), rec2020, atol=1e-4)
    np.testing.assert_allclose(matrix_to_rec709("lin_ap1_scene"), acescg, atol=1e-5)


@pytest.mark.parametrize("space", sorted(KNOWN))
def test_white_stays_white(space: str) -> None:
    white = converted(np.ones((2, 3), dtype=np.float32), matrix_to_rec709(space))
    assert white.dtype == np.float32
    np.testing.assert_allclose(white, 1, atol=1e-6)


def test_the_file_says_its_space_and_data_has_none(tmp_path: Path) -> None:
    for plain in (("lin_rec709_scene", "data"), (None, None), ("data",)):
        assert render_matrix(rendered(tmp_path / "a.exr", *plain)) is None
    found = render_matrix(rendered(tmp_path / "a.exr", "data", "lin_ap1_scene", "lin_ap1_scene"))
    assert found is not None
    np.testing.assert_array_equal(found, matrix_to_rec709("lin_ap1_scene"))


def test_a_space_that_is_not_known_is_named(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"a\.exr holds colours of the space 'lin_p3d65_scene'"):
        render_matrix(rendered(tmp_path / "a.exr", "lin_p3d65_scene"))
    with pytest.raises(FormatError, match=r"a\.exr mixes colours of lin_ap1_scene and lin_rec2020_scene"):
        render_matrix(rendered(tmp_path / "a.exr", "lin_ap1_scene", "lin_rec2020_scene"))
