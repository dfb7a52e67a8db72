# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes drawn by chance, so that nothing can be tuned on them."""

from __future__ import annotations

from .draw import is_lottery, lottery, lottery_name

__all__ = ["is_lottery", "lottery", "lottery_name"]
