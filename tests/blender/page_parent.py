# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A session of its own that serves a web page, and prints its address: a script for a process.

python page_parent.py FOLDER
"""

from __future__ import annotations

import sys
from pathlib import Path
from time import sleep

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from radtex_addon.ui.jobs.browser import address_of

if __name__ == "__main__":
    print(address_of(Path(sys.argv[1])), flush=True)
    sleep(600)
