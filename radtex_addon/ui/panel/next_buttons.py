# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The buttons of what can be done next, with the same words in panel, Object menu and pie menu."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from ..settings.chosen_objects import told_names
from .fitting import draw_button
from .labels import iface_
from .panel_state import Forecast, Next

if TYPE_CHECKING:
    from collections.abc import Iterable

# Texts and icon of operators that are called alike wherever they have a button; the first is drawn that fits.
ACTIONS = {
    "radtex.bake_scene": (("Bake the Scene…", "Bake Scene…", "Scene…"), "SCENE_DATA"),
    "radtex.compare": (("Compare with Cycles", "Compare"), "IMAGE_REFERENCE"),
    "radtex.delete_bake": (("Delete Bake…", "Delete…"), "TRASH"),
    "radtex.export": (("Export…",), "EXPORT"),
    "radtex.open_folder": (("Open Folder", "Folder"), "FILE_FOLDER"),
    "radtex.show_in_browser": (("Show in Browser", "Browser"), "URL"),
}


class NextButton(NamedTuple):
    """A button: its operator, its icon, and whether it may be pressed.

    `texts` are in Blender's language; menus have the first one, the panel the first that fits.
    """

    operator: str
    texts: tuple[str, ...]
    icon: str
    enabled: bool = True
    resume: bool = False
    overwrite: bool = False


def bake_buttons(found: Forecast | None) -> tuple[NextButton, ...]:
    """The buttons that bake what is chosen, that of the next step first; for copies, what is done with them.

    `found` is None while the panel still looks.
    """
    if found is not None and found.copies:
        return _copy_buttons(found)
    doing = found.next if found is not None else Next.NOTHING
    if found is not None and doing is Next.RESUME:
        others = iface_("Bake the Others"), iface_("Others")
        texts = (iface_("Resume"),) if found.unfinished else others
        return NextButton("radtex.bake", texts, "PLAY", resume=True), _again()
    if doing is Next.REPLACE:
        return (_again(),)
    if doing is Next.WAIT:
        return (NextButton("radtex.bake", (iface_("Being Baked"), iface_("Baking")), "RENDER_STILL", False),)
    texts = iface_("Bake Radiance Texture"), iface_("Bake")
    return (NextButton("radtex.bake", texts, "RENDER_STILL", doing is Next.BAKE),)


def _again() -> NextButton:
    return NextButton("radtex.bake", (iface_("Bake Again"), iface_("Again")), "FILE_REFRESH", overwrite=True)


def _copy_buttons(found: Forecast) -> tuple[NextButton, ...]:
    """To go to the originals of chosen copies, to update the copies, and to delete them."""
    several = len(found.copies) > 1
    there = any(one.has_original for one in found.copies)
    newer = any(one.bake == "newer" for one in found.copies)
    select = iface_("Select Originals" if several else "Select Original"), iface_("Select")
    update = iface_("Update Copies" if several else "Update Copy"), iface_("Update")
    delete = iface_("Delete Copies" if several else "Delete Copy"), iface_("Delete")
    return (
        NextButton("radtex.select_original", select, "OBJECT_ORIGIN", there),
        NextButton("radtex.update_copy", update, "FILE_REFRESH", newer),
        NextButton("radtex.delete_copy", delete, "TRASH"),
    )


def told_copies(found: Forecast) -> list[str]:
    """What the chosen copies show, and why buttons for them are grey, a line each."""
    lines = []
    originals = tuple(dict.fromkeys(one.original for one in found.copies))
    if len(found.copies) == 1:
        lines.append(iface_("A copy that shows the bake of {}").format(originals[0]))
    else:
        lines.append(
            iface_("{} copies that show bakes of {}").format(len(found.copies), ", ".join(originals))
        )
    missing = dict.fromkeys(one.original for one in found.copies if not one.has_original)
    if missing:
        lines.append(iface_("{} is not in this scene").format(", ".join(missing)))
    if all(one.bake == "same" for one in found.copies):
        lines.append(
            iface_("It shows the latest bake")
            if len(found.copies) == 1
            else iface_("They show the latest bakes")
        )
    elif any(one.bake == "newer" for one in found.copies):
        lines.append(iface_("There is another bake by now: update it"))
    if any(not one.bake for one in found.copies):
        lines.append(iface_("The files of its bake are not there"))
    return lines


def draw_buttons(
    layout: Any,
    found: Forecast | None,
    buttons: Iterable[NextButton],
    *,
    grey: bool = True,
    share: float | None = None,
) -> None:
    """Draw buttons; one that bakes is refused if other objects are chosen by the time it is pressed.

    Those that have nothing to do are `grey`; else their operators say why, for menus have no room for that.
    In the panel each has a `share` of its width.
    """
    for one in buttons:
        place = layout
        if grey and not one.enabled:
            place = layout.row()
            place.enabled = False
        if share is None:
            button = place.operator(one.operator, text=one.texts[0], icon=one.icon, translate=False)
        else:
            button = draw_button(place, one.operator, one.icon, *one.texts, share=share, boxed=False)
        if one.operator != "radtex.bake":
            continue
        button.resume, button.overwrite, button.show_object = one.resume, one.overwrite, True
        button.expected = "" if found is None else told_names(found.chosen)


def draw_action(
    layout: Any,
    operator: str,
    *,
    as_icon: bool = False,
    fit: bool = False,
    buttons: int = 0,
    boxed: bool = True,
) -> Any:
    """Draw the button of one of `ACTIONS`, or its icon alone; returns the operator's properties.

    In the panel its text is to `fit`, beside some square `buttons`, in a box or not.
    """
    texts, icon = ACTIONS[operator]
    if as_icon:
        return layout.operator(operator, text="", icon=icon)
    if fit:
        return draw_button(layout, operator, icon, *map(iface_, texts), buttons=buttons, boxed=boxed)
    return layout.operator(operator, text=iface_(texts[0]), icon=icon, translate=False)
