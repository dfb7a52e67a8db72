# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What lies in an output folder: `BakeFolder` alone knows its names, states and locks (`bake_folder.py`)."""
