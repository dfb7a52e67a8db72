# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Options of the bench's programs that choose scenes."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from functools import partial

from .lottery import lottery, lottery_name
from .scenes import SCENES, Stage

QUICK = ("metal_20", "ceramic", "mechanical")


def add_scene_options(parser: argparse.ArgumentParser) -> None:
    """Let a program be told which scenes and which of their views to take."""
    parser.add_argument("--quick", action="store_true", help="three scenes, one view of a sort")
    parser.add_argument("--tuning", action="store_true", help="also the views that choices are tuned on")
    parser.add_argument("--scenes", type=names_of(list(SCENES)), help="of " + ", ".join(SCENES))
    parser.add_argument("--lottery", type=int, default=0, metavar="N", help="so many scenes drawn by chance")
    parser.add_argument("--seed", type=int, default=1, help="of the lottery (1, which is for development)")


def chosen_scenes(options: argparse.Namespace) -> dict[str, Callable[[], Stage]]:
    """The scenes that the options name: the lottery's, if there is one, come after those named."""
    usual = [] if options.lottery else list(QUICK if options.quick else SCENES)
    chosen = {name: SCENES[name] for name in options.scenes or usual}
    for number in range(options.lottery):
        chosen[lottery_name(options.seed, number)] = partial(lottery, options.seed, number)
    return chosen


def names_of(known: list[str]) -> Callable[[str], list[str]]:
    """A type of option: names among those known, with commas between."""

    def names(text: str) -> list[str]:
        wanted = text.split(",")
        for name in wanted:
            if name not in known:
                raise argparse.ArgumentTypeError(f"{name} is none of {', '.join(known)}")
        return wanted

    return names
