# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""File formats: atlas and sidecar, written atomically. Rows are flipped here and nowhere else."""
