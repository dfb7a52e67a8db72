# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""ACEScg and Rec.2020 against Rec.709: each kind, layout and layer, and by how much the worst value differs.

uv run --group test python -m tests.bench.working_spaces [--case NAME]      (Blender 5; some minutes)
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from tests.blender.working_space_cases import CASES, REC_709, WIDE, images_of, worst


def main() -> None:
    """Print a line for each image of each case."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--case", choices=CASES, action="append")
    print(f"| bake | image | {' | '.join(WIDE)} |\n|---|---|{'---|' * len(WIDE)}")
    for name in parser.parse_args().case or CASES:
        with tempfile.TemporaryDirectory() as folder:
            expected = images_of(name, REC_709, Path(folder, REC_709))
            gaps = [worst(images_of(name, space, Path(folder, space)), expected) for space in WIDE]
        for image in expected:
            print(f"| {name} | {image} | {' | '.join(f'{gap[image]:.1e}' for gap in gaps)} |", flush=True)


if __name__ == "__main__":
    main()
