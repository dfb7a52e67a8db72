# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The web page's mirror ball in a real Chromium, against Cycles' pictures of the same ball.

With RADTEX_FIGURES=docs/figures the pictures are kept: path traced above, the page's below.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from tests.real.browser import TO_GLTF, Shown
from tests.real.exhibit import Form, decibels
from tests.real.mirror_scene import CAMERA, LEAST, PLACES, RADIUS, SKY, Stage, keep_row
from tests.real.web import Site

SETTINGS: dict[Form, dict[str, Any]] = {
    Form.LAYERED: {"mirror": True},
    Form.PLAIN: {"mirror": True, "sky": SKY},
}


@pytest.fixture(scope="module", params=tuple(Form))
def opened(
    request: pytest.FixtureRequest, web: Site, stages: dict[Form, Stage]
) -> Iterator[tuple[Form, Shown, Stage]]:
    """The stage's page, before the ball stands still."""
    form: Form = request.param
    web.add(f"mirror-{form}", stages[form].bake, **SETTINGS[form])
    with web.opened(f"mirror-{form}/") as shown:
        shown.page.evaluate("radtex.ready")
        yield form, shown, stages[form]


def test_the_ball_moves_by_itself_and_can_be_dragged_and_hidden(opened: tuple[Form, Shown, Stage]) -> None:
    _, shown, _ = opened
    page = shown.page
    first = page.evaluate("radtex.mirror()")
    page.wait_for_function(
        "before => Math.hypot(...radtex.mirror().place.map((p, k) => p - before[k])) > 0.01",
        arg=first["place"],
    )
    page.keyboard.press("b")
    assert not page.evaluate("radtex.mirror().moving")
    page.evaluate("radtex.setMirror({ place: [0, 0.6, 0.4], radius: 0.3 })")
    shown.still()
    found = ball_in(shown)
    assert found is not None
    x, y = found
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 60, y - 20, steps=3)
    page.mouse.up()
    moved = page.evaluate("radtex.mirror().place")
    assert np.linalg.norm(np.array(moved) - [0, 0.6, 0.4]) > 0.05
    with_ball = shown.screen()
    page.get_by_role("button", name="Mirror").click()
    assert not page.evaluate("radtex.mirror().shown")
    shown.still()
    assert np.abs(shown.screen() - with_ball).max() > 0.2
    page.get_by_role("button", name="Mirror").click()


def ball_in(shown: Shown) -> tuple[float, float] | None:
    """The middle of the pixels that change when the ball is hidden, in CSS pixels."""
    shown.still()
    before = shown.screen()
    shown.page.evaluate("radtex.setMirror({ shown: false })")
    shown.still()
    changed = np.abs(shown.screen() - before).max(axis=2) > 0.05
    shown.page.evaluate("radtex.setMirror({ shown: true })")
    shown.still()
    rows, columns = np.nonzero(changed)
    return (float(np.median(columns)), float(np.median(rows))) if len(rows) else None


def test_the_ball_shows_what_cycles_shows(opened: tuple[Form, Shown, Stage]) -> None:
    form, shown, stage = opened
    pictures = []
    for number, place in enumerate(PLACES):
        x, y, z, _ = TO_GLTF @ [*place, 1]
        shown.page.evaluate(
            "state => radtex.setMirror(state)", {"place": [x, y, z], "radius": RADIUS, "shown": True}
        )
        shown.set_camera(CAMERA)
        seen = shown.pixels()[..., :3].astype(np.float64)
        pictures.append(seen)
        found = decibels(seen, stage.reference(number), stage.inside[number])
        print(f"{form}, ball at {place}: {found:.1f} dB")
    keep_row(f"mirror-web-{form}", [*stage.pictures], pictures)
    for number, seen in enumerate(pictures):
        assert decibels(seen, stage.reference(number), stage.inside[number]) >= LEAST
        other = stage.reference((number + 1) % len(PLACES))
        assert decibels(seen, other, stage.inside[number]) < LEAST
