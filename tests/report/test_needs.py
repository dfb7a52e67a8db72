# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What takes more memory than is allowed, or than there is, is refused before any image is opened."""

from __future__ import annotations

from pathlib import Path

import pytest

from radtex_addon.cli.compare_arguments import parse_compare
from radtex_addon.cli.report_arguments import parse_report
from radtex_addon.core.errors import FormatError, InputError
from radtex_addon.formats.disk import memory
from radtex_addon.formats.sidecar import Sidecar, write_sidecar
from radtex_addon.report.sizes import check_judged, check_shown


@pytest.fixture
def large(tmp_path: Path) -> Path:
    """The sidecar of an atlas of 32768 x 32768 pixels, which is nowhere."""
    path = tmp_path / "Vase.radiance.json"
    write_sidecar(path, Sidecar("Vase", "radiance", 2048, 2048, 16, "UV", 4, 0, "portal", "RadTex", "5.2"))
    return path


def test_more_than_is_allowed_is_refused(large: Path) -> None:
    report = parse_report([str(large), "--scene", "a.blend", "--memory", "2GB"], inside_blender=False)
    with pytest.raises(InputError) as caught:
        check_judged(large, report.spec.memory_mb)
    assert str(caught.value) == (
        f"a report on {large} takes about 16.0 GiB of memory, 1.9 GiB are allowed: allow more"
    )
    line = ["a.blend", "--object", "Vase", "--memory", "2GiB"]
    with pytest.raises(InputError) as caught:
        check_shown([large, large], parse_compare(line, inside_blender=False).spec.memory_mb)
    said = f"a picture of {large}, {large} takes about 56.0 GiB of memory, 2.0 GiB are allowed"
    assert str(caught.value) == f"{said}: allow more"


def test_more_than_there_is_is_refused_and_less_is_not(large: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "physical_memory", lambda: 24 * 2**30)
    check_judged(large, None)
    with pytest.raises(FormatError, match=r"a picture of .* needs 28\.0 GiB of memory, this machine has 24"):
        check_shown([large], None)
    check_judged(large, 32 * 2**10)
