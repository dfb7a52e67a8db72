# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The reference of errors and of the names of settings in messages."""

from __future__ import annotations

import inspect

from radtex_addon.cli.wording import option
from radtex_addon.core import errors
from radtex_addon.core.messages import Setting
from radtex_addon.settings.options import CALLED
from radtex_addon.ui.panel.labels import LABELS

from .markdown import code, escaped, table


def exit_codes(_: str) -> str:
    """The errors, with the exit code that the batch ends with."""
    kinds = [
        kind
        for _, kind in inspect.getmembers(errors, inspect.isclass)
        if issubclass(kind, errors.RadTexError) and kind is not errors.RadTexError
    ]
    rows = [
        (
            str(kind.exit_code),
            f"{{py:class}}`~radtex_addon.core.errors.{kind.__name__}`",
            escaped((inspect.getdoc(kind) or "").splitlines()[0]),
        )
        for kind in sorted(kinds, key=lambda kind: (kind.exit_code, kind.__name__))
    ]
    return table(("exit code", "error", "what it means"), [("0", "", "Done."), *rows])


def setting_names(_: str) -> str:
    """What a setting is called in messages as data, on the command line, and in the panel."""
    rows = [
        (code(setting), code(option(setting)), escaped(LABELS.get(setting, "")))
        for setting in sorted({*Setting, *CALLED}, key=option)
    ]
    return table(("in `settings` of an event", "option", "in the panel"), rows)
