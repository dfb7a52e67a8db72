# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The report on a finished bake: how large its error is, which settings cause it, and the size of the files.

Errors are measured against path-traced views of the object in its scene, never estimated.
"""
