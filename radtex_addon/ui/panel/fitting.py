# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Fit texts and settings into the sidebar's width: wrap, shorten, choose shorter words, or use a line more.

Blender wraps no label, and cuts what is too long in its middle. All widths are in pixels at UI scale 1.
Margins and icons were measured in Blender's window, at UI scales 1 and 1.5.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import blf
import bpy

from .labels import iface_

ICON = 24.0  # an icon before a text
BUTTON = 21.0  # a square button with an icon alone
_UI_FONT = 0
_MARGINS = 68.0  # of the sidebar's width that no text in a box can use: tabs, the panel's margins, the box's
_BOX = 14.0  # of these, the box's
_LEAST = 24.0  # a few letters, however narrow the sidebar is
_WITHOUT_REGION = 300.0  # the sidebar's width where there is none, as in tests
_LABELS_SHARE = 0.4  # of a setting's row, as Blender splits it
_PADDING = 8.0  # around a text in a field, a button or a setting's label
_ARROW = 18.0  # of a menu
_MENU = 6.0  # of that what a button's own margin does not hold
_NUMBER = 40.0  # a field for a number needs as much
_SEPARATORS = "/\\_-.,:"  # after which a long word is broken


def sidebar_room(*, icon: bool = False, buttons: int = 0, boxed: bool = True) -> float:
    """The width of a line in the sidebar, in a box or not, beside an icon and some square buttons if any."""
    region = bpy.context.region
    width = region.width / _scale() if region is not None and region.width > 1 else _WITHOUT_REGION
    margins = _MARGINS - (0 if boxed else _BOX)
    return max(_LEAST, width - margins - (ICON if icon else 0) - BUTTON * buttons)


def text_width(text: str) -> float:
    """The width of a text in the font of buttons and labels."""
    preferences, scale = bpy.context.preferences, _scale()
    assert preferences is not None  # only restricted contexts have none
    blf.size(_UI_FONT, preferences.ui_styles[0].widget.points * scale)
    return float(blf.dimensions(_UI_FONT, text)[0] / scale)


def wrapped(text: str, room: float) -> list[str]:
    """Split the text into lines of at most `room`; breaks longer words, such as paths, after a separator."""
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".strip()
        if text_width(longer) <= room:
            lines[-1] = longer
            continue
        parts = _broken(word, room)
        if lines[-1]:
            lines += parts
        else:
            lines[-1:] = parts
    return lines


def shortened(text: str, room: float) -> str:
    """The text, or its beginning and its end, as in `Kitch….012`, where the whole is wider than `room`."""
    if text_width(text) <= room:
        return text
    for kept in range(len(text) - 1, 1, -1):
        end = min(kept // 2, 8)
        shorter = f"{text[: kept - end].rstrip()}…{text[-end:].lstrip()}"
        if text_width(shorter) <= room:
            return shorter
    return f"{text[:1]}…"


def fitting(room: float, *texts: str) -> str:
    """The first of the texts that fits, else the beginning of the last one."""
    for text in texts:
        if text_width(text) <= room:
            return text
    last = texts[-1].removesuffix("…")
    most = next((n for n in range(len(last), 1, -1) if text_width(f"{last[:n]}…") <= room), 1)
    return f"{last[:most].rstrip()}…"


def draw_button(
    layout: Any,
    operator: str,
    icon: str,
    *texts: str,
    buttons: int = 0,
    share: float = 1.0,
    menu: str = "",
    boxed: bool = True,
    **options: Any,
) -> Any:
    """Draw a button with the first of the texts that fits; returns its operator's properties.

    It has a `share` of the sidebar's width, less some square `buttons` beside it; where that is too narrow
    for an icon and a text, it has no icon. Those that are not `boxed` have a box's margins more. With `menu`,
    a property of the operator, it opens the menu of that. `options` are Blender's.
    """
    room = sidebar_room(buttons=buttons, boxed=boxed) * share - (_MENU if menu else 0)
    if min(map(text_width, texts)) > room - ICON:
        icon = "NONE"
    text = fitting(max(room - (0 if icon == "NONE" else ICON), _LEAST), *texts)
    if menu:
        return layout.operator_menu_enum(operator, menu, text=text, icon=icon, translate=False, **options)
    return layout.operator(operator, text=text, icon=icon, translate=False, **options)


def fit_in_a_row(texts: Sequence[str], most: int, *, icon: bool = False) -> int:
    """How many buttons of these texts may stand in a row, `most` at most and one at least."""
    widest = max(map(text_width, texts)) + _PADDING + (ICON if icon else 0)
    return max(1, min(most, int((sidebar_room() + 2 * _PADDING) // widest)))


def side_by_side(layout: Any, texts: Sequence[str]) -> tuple[Any, float]:
    """A row for buttons with these texts and icons, or a column, and the share of its width that each has."""
    fit = fit_in_a_row(texts, len(texts), icon=True) == len(texts)
    return (layout.row(align=True), 1 / len(texts)) if fit else (layout.column(align=True), 1.0)


def draw_wrapped(layout: Any, text: str, icon: str, room: float) -> None:
    """Draw a text on lines of at most `room`, the first one with the icon; "NONE" for none."""
    column = layout.column(align=True)
    column.scale_y = 0.85
    further = "NONE" if icon == "NONE" else "BLANK1"
    for number, line in enumerate(wrapped(text, room)):
        column.label(text=line, icon=icon if number == 0 else further, translate=False)


def draw_text(layout: Any, text: str, icon: str = "NONE", *, buttons: int = 0, boxed: bool = True) -> None:
    """Draw a message on as many lines as the sidebar needs for it, beside some square buttons if any.

    It has no icon where that would break a word. One that is not `boxed` has a box's margins more.
    """
    beside = sidebar_room(icon=True, buttons=buttons, boxed=boxed)
    alone = sidebar_room(buttons=buttons, boxed=boxed)
    if beside <= _LEAST or any(beside < text_width(word) <= alone for word in text.split()):
        icon = "NONE"
    draw_wrapped(layout, text, icon, sidebar_room(icon=icon != "NONE", buttons=buttons, boxed=boxed))


def draw_title(layout: Any, text: str, icon: str, *, buttons: int = 0) -> bool:
    """Draw a title on two lines at most, beside some square buttons; returns whether all of it is there."""
    room = sidebar_room(icon=True, buttons=buttons)
    whole = len(wrapped(text, room)) <= 2
    draw_wrapped(layout, text if whole else shortened(text, room), icon, room)
    return whole


def draw_setting(layout: Any, data: Any, name: str, *, boxed: bool = False, **options: Any) -> None:
    """Draw a setting with its name beside it, or above it where the sidebar is too narrow for both.

    `options` are those of `UILayout.prop`.
    """
    place = _place(layout, data, name, options, boxed=boxed)
    if place is layout:
        layout.prop(data, name, **options)
    else:
        place.prop(data, name, **options | _nameless(data, name, expand="expand" in options))


def draw_search(layout: Any, data: Any, name: str, owner: Any, found: str, **options: Any) -> None:
    """The same for a setting that is chosen from the collection `found` of `owner`."""
    place = _place(layout, data, name, options)
    if place is not layout:
        options |= {"text": ""}
    place.prop_search(data, name, owner, found, **options)


def headed(layout: Any, heading: str, data: Any, names: Sequence[str]) -> Any:
    """A column for the switches `names` below a heading: beside it, or below it in a narrow sidebar."""
    shown = [iface_(data.bl_rna.properties[name].name) for name in names]
    if fits_beside(heading, shown, BUTTON):
        return layout.column(heading=heading)
    column = layout.column()
    column.use_property_split = False
    column.label(text=heading, translate=False)
    return column


def fits_beside(label: str, values: Sequence[str], more: float = 0.0) -> bool:
    """Whether a label and each of the values, with `more` beside it, fit into a row, as Blender splits it."""
    row = sidebar_room() + _PADDING
    widest = max(map(text_width, values), default=_NUMBER)
    label_fits = text_width(label) + _PADDING <= row * _LABELS_SHARE
    return label_fits and widest + _PADDING + more <= row * (1 - _LABELS_SHARE)


def _scale() -> float:
    """The interface's scale, which is 0 where Blender has no window."""
    preferences = bpy.context.preferences
    return (preferences.system.ui_scale if preferences is not None else 0.0) or 1.0


def _place(layout: Any, data: Any, name: str, options: dict[str, Any], *, boxed: bool = False) -> Any:
    """Where to draw a setting: the layout itself, or a column of its own, below its name."""
    known = data.bl_rna.properties[name]
    label = options.get("text", iface_(known.name))
    if known.type == "BOOLEAN":
        beside = fits_beside("", [label], BUTTON)
    elif known.type == "ENUM":
        values = [iface_(item.name) for item in known.enum_items]
        if options.get("expand"):
            values = [" ".join(values)]
        beside = fits_beside(label, values, _ARROW)
    else:
        beside = fits_beside(label, ())
    if beside or not label:
        return layout
    column = layout.column(align=True)
    column.use_property_split = False
    if known.type != "BOOLEAN":
        draw_text(column, label, boxed=boxed)
    return column.row(align=True) if options.get("expand") else column


def _nameless(data: Any, name: str, *, expand: bool) -> dict[str, str]:
    """The options that leave out a setting's name, which stands above it.

    A switch has its name beside it. Without a name Blender draws a row of choices without theirs, too.
    """
    known = data.bl_rna.properties[name]
    named = known.type == "BOOLEAN" or (known.type == "ENUM" and (expand or known.is_enum_flag))
    return {} if named else {"text": ""}


def _broken(word: str, room: float) -> list[str]:
    """A word in pieces that fit, broken after a separator if one is there; each has a letter at least."""
    pieces = []
    while text_width(word) > room and len(word) > 1:
        most = next((n for n in range(len(word) - 1, 1, -1) if text_width(word[:n]) <= room), 1)
        after = max((word.rfind(sign, 0, most) + 1 for sign in _SEPARATORS), default=0)
        slash = max(word.rfind(sign, 0, most) + 1 for sign in "/\\")
        end = slash if slash > 2 else after if after > most // 3 else most
        pieces.append(word[:end])
        word = word[end:]
    return [*pieces, word]
