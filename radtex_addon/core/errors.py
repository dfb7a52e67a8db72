# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every error that RadTex raises on purpose: one line that names the thing and says what to do."""

from __future__ import annotations


class RadTexError(Exception):
    """Root of our errors; `exit_code` is what the batch leaves with."""

    exit_code = 2


class InputError(RadTexError):
    """What the user asked for cannot be done; nothing was started."""


class FormatError(RadTexError):
    """A file is not what it should be."""


class ShapeError(RadTexError, ValueError):
    """An array has the wrong shape or type."""


class BakeError(RadTexError):
    """The bake began and failed."""

    exit_code = 1


class Cancelled(RadTexError):
    """The user stopped the bake."""

    exit_code = 130
