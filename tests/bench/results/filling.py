# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the cells that a table still lacks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from time import perf_counter

from .cells import Cells
from .matrix import NOTHING, Group, Setting, keys_of
from .measuring import open_scene
from .scenes import SCENES

_Job = tuple[Setting, int, Group]


def fill(cells: Cells, settings: Iterable[Setting], seeds: Sequence[int], groups: Sequence[Group]) -> None:
    """Measure every scene at the settings, by the groups of methods, with the seeds, where cells lack."""
    baked = [group for group in groups if group is not Group.UNBAKED]
    jobs: list[_Job] = [(s, seed, group) for s in settings for seed in seeds for group in baked]
    if Group.UNBAKED in groups:
        jobs.append((NOTHING, 0, Group.UNBAKED))
    for name in SCENES:
        missing = [job for job in jobs if any(key not in cells for key in keys_of(name, *job))]
        if not missing:
            continue
        opened = open_scene(name)
        for number, (setting, seed, group) in enumerate(missing, 1):
            started = perf_counter()
            for cell in opened.measure(setting, seed, group):
                cells.add(cell)
                print(f"{cell.key}: {cell.mean('psnr'):.2f} dB", flush=True)
            spent = perf_counter() - started
            print(f"{name}: {number} of {len(missing)} in {spent:.0f} s", flush=True)
