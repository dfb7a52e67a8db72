# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Films: that they repeat, keep to a limit of bytes and show Blender's colours; that cameras come back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from radtex_addon.core.errors import InputError
from tests.bench.films.encode import graded, save_film
from tests.bench.films.still_life import tube
from tests.bench.gallery.looking import Camera


def _moving(count: int) -> list[np.ndarray[tuple[int, ...], np.dtype[np.float64]]]:
    """A bright square that moves over noise, which no codec makes small."""
    rng = np.random.default_rng(1)
    frames = [rng.uniform(0, 0.6, (64, 64, 3)) for _ in range(count)]
    for number, frame in enumerate(frames):
        frame[20:40, 8 * number : 8 * number + 16] = 1
    return frames


def test_film_repeats_and_keeps_to_its_limit(tmp_path: Path) -> None:
    frames = _moving(5)
    large = save_film(tmp_path / "large.webp", frames, 10, 1_000_000)
    small = save_film(tmp_path / "small.webp", frames, 10, large // 2)
    assert small <= large // 2 < large
    for name in ("large.webp", "small.webp"):
        with Image.open(tmp_path / name) as film:
            assert (getattr(film, "n_frames", 1), film.info["loop"]) == (5, 0)
            film.seek(3)
            shown = np.asarray(film.convert("RGB"), dtype=np.float64) / 255
        assert shown[24:36, 26:38].min() > 0.85  # the square of the fourth frame
    with pytest.raises(InputError, match=r"none\.webp"):
        save_film(tmp_path / "none.webp", frames, 10, 100)
    assert not (tmp_path / "none.webp").exists()


def test_graded_light_rises_from_black_to_white_and_rows_stay_in_order() -> None:
    light = np.zeros((4, 3, 3))
    light[0], light[1], light[2] = 100.0, 1.0, 0.18
    shown = graded(light)
    assert shown.shape == light.shape
    assert shown[0].min() > 0.98
    assert 0.98 > shown[1].max() > shown[2].max() > 0.3
    assert shown[3].max() < 0.02


def test_swinging_camera_keeps_its_distance_and_comes_back() -> None:
    camera = Camera((1.0, -4.0, 2.0), (0.5, 0.0, 0.2))
    swung = list(camera.swung(30, 12))
    np.testing.assert_allclose(swung[0].place, camera.place)
    away = np.subtract([one.place for one in swung], camera.target)
    np.testing.assert_allclose(np.linalg.norm(away, axis=1), np.linalg.norm(away[0]))
    turned = np.degrees(np.arctan2(away[:, 1], away[:, 0]))
    np.testing.assert_allclose([turned.max() - turned[0], turned.min() - turned[0]], [30, -30])
    assert abs(turned[1] - turned[0]) == pytest.approx(abs(turned[-1] - turned[0]))


def test_pipe_is_closed_and_as_thick_as_asked() -> None:
    path = np.array([(0.0, 0.0), (0.0, 1.0), (0.0, 2.0)])
    vertices, faces = tube(path, (0.5, 0.25))
    edges: dict[tuple[int, int], int] = {}
    for face in faces:
        for a, b in zip(face, (*face[1:], face[0]), strict=True):
            edges[a, b] = edges.get((a, b), 0) + 1
    assert set(edges.values()) == {1}  # each edge once in each direction
    assert all((b, a) in edges for a, b in edges)
    place = np.array(vertices).reshape(3, -1, 3)
    np.testing.assert_allclose(np.linalg.norm(place[..., :2], axis=2).mean(axis=1), [0.5, 0.375, 0.25])
