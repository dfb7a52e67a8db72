# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which version's changes the user knows: after an update, the panel offers what is new, once."""

from __future__ import annotations

import bpy

from ...version import VERSION
from ..panel.labels import iface_
from .preferences import addon_preferences


def news() -> bool:
    """Whether RadTex is newer than the version whose changes were seen or dismissed last."""
    from ...formats.changelog import as_numbers

    found = addon_preferences()
    return (
        found is not None
        and bool(found.seen_version)
        and as_numbers(found.seen_version) < as_numbers(VERSION)
    )


def news_title() -> str:
    """The words of the panel's line, and the dialog's title."""
    return iface_("RadTex {}: what's new").format(VERSION)


def seen_version() -> str:
    """The version whose changes were seen last; empty without preferences."""
    found = addon_preferences()
    return "" if found is None else found.seen_version


def mark_seen() -> None:
    """Let the panel offer nothing until the next update."""
    found = addon_preferences()
    if found is None or found.seen_version == VERSION:
        return
    found.seen_version = VERSION
    assert bpy.context.preferences is not None  # only restricted contexts have none
    bpy.context.preferences.is_dirty = True  # so that Blender saves them at its end


def register() -> None:
    """On a first install all there is is new, and nothing is said."""
    if not seen_version():
        mark_seen()
