# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh as renders show it: read, checked, flattened, split, joined and copied for a bake."""
