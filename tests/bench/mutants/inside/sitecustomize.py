# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""In a Python that a test starts: tell the test which lines of the package ran, by a file in its folder."""

import atexit
import os
import sys
from pathlib import Path

FOLDER, TEST = (os.environ.get(name) for name in ("RADTEX_LINES", "RADTEX_LINES_TEST"))

if FOLDER and TEST and sys.version_info >= (3, 12):
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
    import lines  # type: ignore[import-not-found]

    sys.path.pop(0)
    at_once = os._exit

    def tell() -> None:
        said = "".join(f"{file}\t{line}\n" for file, line in lines.take())
        Path(str(FOLDER), f"{TEST}-{os.getpid()}.txt").write_text(said, encoding="utf-8")

    def leave(code: int) -> None:
        tell()
        at_once(code)

    atexit.register(tell)
    os._exit = leave  # type: ignore[assignment]
    lines.begin()
