# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Digests of values that are rounded otherwise each time."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from radtex_addon.core.near_digest import NearDigest, NearHash, is_same, joined

HEX = "0123456789abcdef" * 4


def digest(values: npt.NDArray[np.float32], exact: str = "", of: str = "cube") -> NearDigest:
    found = NearHash(of)
    found.feed("UVMap", values, varies=True)
    return found.digest(exact or f"sha256:{hash(values.tobytes()) % 16**8:064x}")


@pytest.mark.parametrize("count", [1, 7, 192, 100_000])
@pytest.mark.parametrize("scale", [1e-3, 1, 1e4])
def test_the_last_bits_make_no_difference(count: int, scale: float) -> None:
    random = np.random.default_rng(count)
    values = (scale * random.random(count)).astype(np.float32)
    up = np.nextafter(values, np.float32(np.inf))
    some = np.where(random.random(count) < 0.5, up, np.nextafter(values, np.float32(-np.inf)))
    for other in (up, some.astype(np.float32)):
        assert digest(values) != digest(other)
        assert digest(values).is_like(digest(other))
    outlier = values.copy()  # where a bevel's seam comes apart, subdivision smooths UVs otherwise
    outlier[count // 2] *= 1 + 1e-5
    assert digest(values).is_like(digest(outlier))


@pytest.mark.parametrize("count", [1, 7, 192, 50_000])
def test_a_change_is_one(count: int) -> None:
    values = np.random.default_rng(count).random(count).astype(np.float32)
    changed = values + np.float32(1e-3)
    assert not digest(values).is_like(digest(changed))
    if count > 1:
        one = values.copy()
        one[count // 3] += 0.1
        assert not digest(values).is_like(digest(one))
        assert not digest(values).is_like(digest(np.roll(values, 1)))
    assert not digest(values).is_like(digest(np.append(values, np.float32(0))))
    assert not digest(values, of="cube").is_like(digest(values + np.float32(1e-9), "other", of="ball"))


def test_numbers_that_are_none_are_told_apart_by_the_others() -> None:
    assert digest(np.zeros(0, np.float32), "one").is_like(digest(np.zeros(0, np.float32), "other"))
    values = np.array([1, np.nan, np.inf, 2], dtype=np.float32)
    assert digest(values, "one").is_like(digest(values, "other"))
    assert not digest(values, "one").is_like(digest(values + np.float32(1), "other"))


def test_texts_come_back_and_other_texts_are_what_they_are() -> None:
    one = digest(np.random.default_rng(1).random(100).astype(np.float32), f"sha256:{HEX}")
    assert NearDigest.parse(str(one)).is_like(one)
    assert str(NearDigest.parse(str(one))) == str(one)
    assert is_same(str(one), f"sha256:{HEX}")  # as an earlier RadTex wrote it
    for text in ("Cube", "Cube of 3", "", f"sha256:{HEX}", f"sha256:{HEX} {HEX} 1,,2", f"{one} "):
        assert NearDigest.parse(text) == NearDigest(text)
    assert not is_same("Cube 1", "Cube 2")
    other = NearDigest(f"sha256:{'0' * 64}", one.of, one.sums)
    assert is_same(str(one), str(other))
    assert not is_same(str(one), other.exact)


def test_several_are_like_where_each_is() -> None:
    random = np.random.default_rng(2)
    values = [random.random(50).astype(np.float32) for _ in range(3)]
    plain = NearDigest("plain")

    def whole(arrays: list[npt.NDArray[np.float32]], exact: str, *beside: str) -> NearDigest:
        return joined(exact, [plain, *(digest(each, exact) for each in arrays)], beside)

    near = whole([each + np.float32(1e-8) for each in values], "near", "world")
    assert whole(values, "one", "world").is_like(near)
    assert not whole(values, "one", "sky").is_like(near)
    moved = whole([values[0], values[1] + np.float32(0.01), values[2]], "moved", "world")
    assert not moved.is_like(near)
    assert joined("all", [plain, plain]) == NearDigest("all")
