# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Open exported web pages in the user's browser, from one server for the whole session.

The server listens at 127.0.0.1 only. It ends with Blender, and when RadTex is disabled.
"""

from __future__ import annotations

import webbrowser
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ...export.page_process import PageProcess


@dataclass
class _Session:
    """The running server, None before the first page, and the address of each folder that it serves."""

    server: PageProcess | None = None
    addresses: dict[Path, str] = field(default_factory=dict)


_session = _Session()


def address_of(folder: Path) -> str:
    """Serve an exported web folder; returns its address, which stays the same while Blender runs.

    Raises RadTexError if the server cannot be started.
    """
    from ...export.page_process import PageProcess

    if _session.server is not None and not _session.server.is_running:
        end_server()
    if _session.server is None:
        _session.server = PageProcess()
    address = _session.addresses[folder.absolute()] = _session.server.address_of(folder)
    return address


def known_address(folder: Path) -> str:
    """The address of a folder that is served; else empty. Asks no process."""
    return _session.addresses.get(folder.absolute(), "")


def open_page(folder: Path) -> tuple[str, bool]:
    """Serve the folder and open it in the default browser; its address, and whether a browser was found.

    Raises RadTexError if the server cannot be started.
    """
    address = address_of(folder)
    return address, webbrowser.open(address)


def end_server() -> None:
    """End the server, if there is one. Open pages stay, but cannot be loaded again."""
    if _session.server is not None:
        _session.server.close()
    _session.server = None
    _session.addresses.clear()
