# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A server for web exports on this machine alone, while a bake is refined."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Thread
from urllib.parse import quote

from ..core.errors import InputError
from ..export.page_server import HERE, PageServer

_WATCHING = "watch"  # the page's parameter that has it look for new textures


@contextmanager
def serving(folder: Path, port: int | None) -> Iterator[int | None]:
    """Within the context, serve `folder` at a port, 0 for a free one; yields the port, None if none is asked.

    Raises InputError if the port is taken.
    """
    if port is None:
        yield None
        return
    try:
        server = PageServer(port, {"": folder})
    except OSError as error:
        raise InputError(f"--serve {port}: this port cannot be had ({error.strerror or error})") from error
    with server:
        thread = Thread(target=server.serve_forever, daemon=True)
        thread.start()
        try:
            yield server.port
        finally:
            server.shutdown()
            thread.join()


def address(port: int, folder: Path) -> str:
    """Where a page that looks for new textures shows the export in `folder`, of a served folder."""
    return f"http://{HERE}:{port}/{quote(folder.name)}/?{_WATCHING}"
