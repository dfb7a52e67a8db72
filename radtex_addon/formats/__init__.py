# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The files: atlas and sidecar, written whole or not at all. Rows are flipped here and nowhere else."""
