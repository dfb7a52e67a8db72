# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a message's remedies the panel offers below it: buttons that set a setting, and the settings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from ...core.messages import Message, Remedy, Setting
from ...settings.options import CALLED
from ..settings.bake_settings import BakeSettings
from .labels import LABELS, iface_

# The panel's large buttons decide these.
_BUTTONS: frozenset[str] = frozenset({Setting.OVERWRITE, Setting.OVERWRITE_ANY, Setting.RESUME})
# Names of bake settings; those of a remedy that are missing here get no button.
PROPERTIES = {
    called: option.setting for called, option in CALLED.items() if option.title and called not in _BUTTONS
}
PREFERENCES: dict[str, str] = {Setting.DEVICE: "device", Setting.MEMORY: "memory_mb"}


@dataclass(frozen=True)
class Offer:
    """A button with a `text` that sets the setting `name` to `value`, or to its default if that is empty.

    Without a text, the setting itself; with `preference`, one of the add-on's preferences.
    """

    name: str
    text: str = ""
    value: str = ""
    preference: bool = False


def offers(message: Message, settings: BakeSettings) -> tuple[Offer, ...]:
    """What is drawn below a message, each setting once; nothing for remedies that name no setting."""
    found = (offer for remedy in message.remedies for offer in _offers_of(remedy, settings))
    return tuple({offer.name: offer for offer in found}.values())


def _offers_of(remedy: Remedy, settings: BakeSettings) -> Iterator[Offer]:
    if remedy.leaves_out:
        yield from (_left_out(setting, settings) for setting in remedy.without if setting in PROPERTIES)
        return
    asked = [setting for setting in remedy.settings if setting not in _BUTTONS]
    for number, setting in enumerate(asked):
        if setting in PREFERENCES:
            yield Offer(PREFERENCES[setting], preference=True)
        elif setting in PROPERTIES:
            yield _set(setting, remedy.value if number == 0 else "", settings)


def _left_out(setting: str, settings: BakeSettings) -> Offer:
    name = PROPERTIES[setting]
    kind = _property(settings, name).type
    text = iface_("Clear {}") if kind == "STRING" else iface_("Reset {}")
    return Offer(name, (iface_("Switch Off {}") if kind == "BOOLEAN" else text).format(LABELS[setting]))


def _set(setting: str, value: str, settings: BakeSettings) -> Offer:
    """The button that sets a setting to the remedy's value, or switches it on; else the setting itself."""
    name = PROPERTIES[setting]
    found = _property(settings, name)
    if found.type == "BOOLEAN":
        return Offer(name, iface_("Switch On {}").format(LABELS[setting]), "True")
    if found.type == "ENUM" and value in found.enum_items:
        return Offer(name, f"{LABELS[setting]}: {iface_(found.enum_items[value].name)}", value)
    if found.type == "INT" and value:
        return Offer(name, f"{LABELS[setting]}: {value}", value)
    return Offer(name)


def _property(settings: BakeSettings, name: str) -> Any:
    return settings.bl_rna.properties[name]
