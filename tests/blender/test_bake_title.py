# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What people read of which bake is meant, in the command line, the list of jobs and the export dialog."""

from __future__ import annotations

import pytest

from radtex_addon.bake.bake_title import bake_title, variant_title
from radtex_addon.bake.spec import BakeSpec
from radtex_addon.job.variants import title_of, variant_of

pytestmark = pytest.mark.one_blender


def test_a_title_has_what_tells_bakes_of_an_object_apart() -> None:
    assert bake_title("Cup") == "Cup"
    assert bake_title("Cup", part="Glaze", kind="Shadow", variant="frame 3") == "Cup, Glaze, Shadow, frame 3"
    assert variant_title(None, ()) == ""
    assert variant_title(0, ("Key", "Fill")) == "frame 0, light of Key, Fill"


def test_a_bake_that_is_to_be_made_has_the_title_of_the_finished_one() -> None:
    spec = BakeSpec(frame=3, lights=("Key",))
    assert variant_of(spec) == variant_title(3, ("Key",))
    assert title_of("Cup", spec) == bake_title("Cup", variant=variant_title(3, ("Key",)))
