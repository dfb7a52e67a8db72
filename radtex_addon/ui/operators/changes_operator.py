# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is new after an update: a dialog with a few lines, and a button that takes the offer away."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import bpy

from ...core.errors import FormatError
from ...version import VERSION
from ..panel.fitting import draw_wrapped
from ..panel.labels import iface_, remark
from ..panel.redraw import redraw
from ..settings.preferences import website
from ..settings.seen_version import mark_seen, news, news_title, seen_version

if TYPE_CHECKING:
    from bpy.stub_internal.rna_enums import OperatorReturnItems

_WIDTH = 440  # of the dialog, in pixels at UI scale 1
_MOST = 5  # lines on what is new, so that no screen is too low for it


class RADTEX_OT_show_changes(bpy.types.Operator):
    """Show what is new in this version of RadTex: after an update, what came since the version before"""

    bl_idname = "radtex.show_changes"
    bl_label = "What's New"
    bl_options = {"INTERNAL"}

    changes: list[str]

    def invoke(
        self, context: bpy.types.Context | None, event: bpy.types.Event | None
    ) -> set[OperatorReturnItems]:
        try:
            self.changes = shown_changes()
        except (OSError, FormatError) as error:
            self.report({"ERROR"}, remark(f"CHANGELOG.md cannot be read ({error}): install RadTex anew"))
            return {"CANCELLED"}
        mark_seen()
        assert context is not None  # Blender always gives one
        manager: Any = context.window_manager
        asked: set[OperatorReturnItems] = manager.invoke_props_dialog(
            self, width=_WIDTH, title=news_title(), confirm_text="Close"
        )
        return asked

    def draw(self, context: bpy.types.Context | None) -> None:
        layout: Any = self.layout
        for line in self.changes:
            draw_wrapped(layout, line, "DOT", _WIDTH - 60)
        row = layout.row()
        texts = iface_("All Changes"), iface_("Manual and Reports")
        row.operator("wm.path_open", text=texts[0], icon="TEXT", translate=False).filepath = _changelog()
        if url := website():
            row.operator("wm.url_open", text=texts[1], icon="URL", translate=False).url = url

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        mark_seen()
        redraw()
        return {"FINISHED"}


class RADTEX_OT_dismiss_changes(bpy.types.Operator):
    """Take this line away until the next update. Preferences > Add-ons > RadTex shows the changes again"""

    bl_idname = "radtex.dismiss_changes"
    bl_label = "Dismiss What's New"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, _: bpy.types.Context | None) -> bool:
        if not news():
            cls.poll_message_set("The changes of this version were shown or dismissed already")
            return False
        return True

    def execute(self, context: bpy.types.Context | None) -> set[OperatorReturnItems]:
        mark_seen()
        redraw()
        return {"FINISHED"}


def shown_changes() -> list[str]:
    """What the dialog shows, a line each: of the releases since the last one that was seen, else of this one.

    Raises OSError and FormatError.
    """
    from ...formats.changelog import CHANGELOG, changes_since, highlights, parse_changelog

    releases = parse_changelog(CHANGELOG.read_text(encoding="utf-8"))
    since = changes_since(releases, seen_version(), VERSION)
    since = since or [release for release in releases if release.version == VERSION]
    return highlights(since, _MOST)


def _changelog() -> str:
    from ...formats.changelog import CHANGELOG

    return str(CHANGELOG)
