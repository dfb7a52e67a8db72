# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a user should know of a finished bake: how close it is, why not closer, and what it weighs.

Everything is measured against path-traced views of the object in its scene, never modelled.
"""
