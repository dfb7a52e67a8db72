# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Messages in the words of the command line, which has an option for a setting."""

from __future__ import annotations

from typing import Any

from ..core.messages import Message, Remedy, Setting, joined
from ..settings.options import CALLED

_UNLIKE: dict[str, str] = {  # options that are not called as their settings
    Setting.SCRIPTS: "blender -b --enable-autoexec FILE -P bake.py -- ...",
}


def option(setting: str) -> str:
    """The option for a setting, such as --save-preview."""
    if setting in CALLED and CALLED[setting].flag:
        return CALLED[setting].flag
    return _UNLIKE.get(setting, f"--{Setting(setting).name.lower().replace('_', '-')}")


def worded(message: Message) -> str:
    """A message with the options that its remedies are about."""
    return joined(message.problem, map(_worded, message.remedies))


def told(message: Message) -> dict[str, Any]:
    """A message for an event: for people, and as data for programs with other names of settings."""
    return {"message": worded(message), **message.facts()}


def _worded(remedy: Remedy) -> str:
    without = [option(setting) for setting in remedy.without]
    if remedy.leaves_out:
        return f"leave {' and '.join(without)} out {remedy.text}".rstrip()
    used = [option(setting) for setting in remedy.settings]
    if remedy.value:
        used[0] += f" {remedy.value}"
    if without:
        used.append(f"without {' and '.join(without)}")
    return f"{remedy.text} ({', '.join(used)})" if used else remedy.text
