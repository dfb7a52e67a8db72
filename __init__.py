# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's entry: Blender calls these two, everything else lives in radtex_addon."""

from __future__ import annotations


def register() -> None:
    """Make RadTex's classes known to Blender."""
    from .radtex_addon.ui import registration

    registration.register()


def unregister() -> None:
    """Take them away again."""
    from .radtex_addon.ui import registration

    registration.unregister()
