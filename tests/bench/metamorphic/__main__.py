# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Relations between bakes that must hold whatever the scene, tried over small random scenes.

    python -m tests.bench.metamorphic --scenes 20 --seed 1
    python -m tests.bench.metamorphic --scenes 1 --seed 17 --relation "the scene mirrored"

Each relation bakes a scene twice, in two ways that must give the same light, or the same bits. Prints a
table, and the seed of each scene in which one did not hold; exit code 1 if there is any.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from radtex_addon.core.errors import RadTexError
from tests.bench.metamorphic import exporting, kinds, placing, settings, shaping
from tests.bench.metamorphic.trial import Outcome, Relation, Trial

RELATIONS: dict[str, Relation] = {
    **placing.RELATIONS,
    **shaping.RELATIONS,
    **settings.RELATIONS,
    **kinds.RELATIONS,
    **exporting.RELATIONS,
}


def main() -> int:
    """Try, tell; the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m tests.bench.metamorphic",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--scenes", type=int, default=5, help="how many random scenes (5)")
    parser.add_argument("--seed", type=int, default=0, help="of the first scene; the next has the next (0)")
    parser.add_argument("--relation", action="append", choices=RELATIONS, help="only this one; repeatable")
    options = parser.parse_args()
    print("| relation | tries | worst deviation | allowed | found in scenes |\n|---|---|---|---|---|")
    found = False
    for name in options.relation or RELATIONS:
        seeds = range(options.seed, options.seed + options.scenes)
        outcomes = {seed: outcome for seed in seeds if (outcome := tried(RELATIONS[name], seed)) is not None}
        against = [str(seed) for seed, outcome in outcomes.items() if not outcome.holds]
        found = found or bool(against)
        worst = max(outcomes.values(), key=_by_share, default=Outcome(0, 0))
        row = (
            name,
            len(outcomes),
            f"{worst.deviation:.2g}",
            f"{worst.allowed:g}",
            " ".join(against) or "none",
        )
        print(f"| {' | '.join(map(str, row))} |", flush=True)
    return int(found)


def _by_share(outcome: Outcome) -> tuple[bool, float]:
    return not outcome.holds, outcome.deviation / (outcome.allowed or 1)


def tried(relation: Relation, seed: int) -> Outcome | None:
    """One try in the scene of a seed; None where the scene is none for it. An error of ours is a finding."""
    start = time.monotonic()
    with _hushed():
        try:
            outcome = relation(Trial(seed))
        except RadTexError as error:
            outcome = Outcome(float("inf"), 0)
            print(f"scene {seed}: {relation.__name__}: {error}", file=sys.stderr)
    if outcome is not None and not outcome.holds:
        print(
            f"scene {seed}: {relation.__name__}: {outcome.deviation:.3g}, allowed {outcome.allowed:g} "
            f"({time.monotonic() - start:.1f} s)",
            file=sys.stderr,
        )
    return outcome


@contextmanager
def _hushed() -> Iterator[None]:
    """Keep Blender's lines about renders out of the table."""
    sys.stdout.flush()
    kept = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    try:
        yield
    finally:
        sys.stdout.flush()
        os.dup2(kept, 1)
        os.close(kept)
        os.close(nowhere)


if __name__ == "__main__":
    CODE = main()
    sys.stdout.flush()
    os._exit(CODE)  # Blender's own end may hang on drivers
