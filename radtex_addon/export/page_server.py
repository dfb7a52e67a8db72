# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A server for exported folders, for programs on this machine alone; and a script that runs it.

`python -I page_server.py` reads the folders to serve from standard input, one a line, as JSON strings, and
answers each with its address, as JSON, too. It ends when standard input closes: when its parent closes it,
ends, crashes or is killed. It needs only Python's own modules, so that no Blender has to start for it.
"""

from __future__ import annotations

import json
import os
import socket
import socketserver
import sys
from collections.abc import Mapping
from contextlib import suppress
from http import HTTPStatus
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from io import BytesIO
from pathlib import Path
from threading import Lock, Thread
from typing import Any, BinaryIO
from urllib.parse import quote, unquote

HERE = "127.0.0.1"
_NAMES = (HERE, "localhost")  # by which browsers on this machine may call it
_INDEX = ("index.html", "index.htm")  # what Python's server answers for a folder
_WAITING = 128  # connections that may be open without having asked for anything; browsers open some ahead
_PATIENCE = 60.0  # seconds in which a browser must ask, and take in some of what it is sent


class PageServer(ThreadingHTTPServer):
    """Serves folders at a port of 127.0.0.1, each below the first part of an address's path.

    `folders` maps that part to the folder; a folder with the name "" is served below "/". Connections that
    ask for nothing never keep others waiting: of too many, the oldest is closed.
    """

    daemon_threads = True
    request_queue_size = 512  # of connections that the system holds meanwhile; it refuses more for a second
    allow_reuse_address = sys.platform != "win32"  # there it would let two programs have the same port
    allow_reuse_port = False

    def __init__(self, port: int = 0, folders: Mapping[str, Path] | None = None) -> None:
        """Listen at the port, 0 for a free one. Raises OSError if it is taken."""
        super().__init__((HERE, port), _Files)
        self._lock = Lock()
        self._waiting: dict[socket.socket, None] = {}  # in the order in which they came
        self.folders = {name: folder.resolve() for name, folder in (folders or {}).items()}

    @property
    def port(self) -> int:
        return int(self.server_address[1])

    def add(self, folder: Path) -> str:
        """Serve another folder; returns its address. A folder that is served already keeps its own."""
        folder = folder.resolve()
        name = next((name for name, other in self.folders.items() if other == folder), "")
        number = 1
        while not name:
            wanted = folder.name if number == 1 else f"{folder.name}-{number}"
            name = "" if wanted in self.folders else wanted
            number += 1
        self.folders[name] = folder
        return f"http://{HERE}:{self.port}/{quote(name, safe='')}/"

    def process_request(self, request: Any, client_address: Any) -> None:
        """Answer a connection in a thread of its own; close the oldest that waits if there are too many."""
        with self._lock:
            self._waiting[request] = None
            while len(self._waiting) > _WAITING:
                oldest = next(iter(self._waiting))
                del self._waiting[oldest]
                with suppress(OSError):  # it has gone by itself
                    oldest.shutdown(socket.SHUT_RDWR)  # its thread reads the end, and closes it
        super().process_request(request, client_address)

    def has_asked(self, request: Any) -> None:
        """A connection does not wait any more: it has asked for something, or is being closed."""
        with self._lock:
            self._waiting.pop(request, None)

    def shutdown_request(self, request: Any) -> None:
        self.has_asked(request)
        super().shutdown_request(request)

    def server_bind(self) -> None:
        """Bind, without asking the network for this machine's name, which may take seconds."""
        socketserver.TCPServer.server_bind(self)
        self.server_name, self.server_port = HERE, self.port

    def handle_error(self, *_: Any) -> None:
        """A browser may close its tab in the middle of a file: no traceback for that."""
        if not isinstance(sys.exception(), OSError):
            super().handle_error(*_)


class _Files(SimpleHTTPRequestHandler):
    """Serves files without a log; browsers keep none of them, so that a new export is seen at once."""

    server: PageServer
    timeout = _PATIENCE
    # Windows looks types up in its registry, where other programs may have changed them.
    extensions_map = SimpleHTTPRequestHandler.extensions_map | {
        ".css": "text/css; charset=utf-8",
        ".exr": "image/x-exr",
        ".glb": "model/gltf-binary",
        ".html": "text/html; charset=utf-8",
        ".js": "text/javascript; charset=utf-8",
        ".json": "application/json",
        ".ktx2": "image/ktx2",
        ".png": "image/png",
        ".txt": "text/plain; charset=utf-8",
        ".wasm": "application/wasm",
    }

    def log_message(self, *_message: Any) -> None:
        pass

    def end_headers(self) -> None:
        self.send_header("Cache-Control", "no-store")
        self.send_header("X-Content-Type-Options", "nosniff")
        super().end_headers()

    def send_head(self) -> BytesIO | BinaryIO | None:
        """As of the base class, for files in the served folders only.

        A request for another host is refused: a page from the internet could have its own host's name lead
        here, and would then be allowed to read the answers.
        """
        self.server.has_asked(self.request)
        if self.headers.get("Host", "").partition(":")[0] not in _NAMES:
            self.send_error(HTTPStatus.FORBIDDEN)
            return None
        if not self._is_served():
            self.send_error(HTTPStatus.NOT_FOUND)
            return None
        return super().send_head()

    def translate_path(self, path: str) -> str:
        """The path of the file in its folder; outside of all folders where the address names none."""
        name, rest = self._parts(path)
        self.directory = str(self.server.folders[name])
        return super().translate_path(rest)

    def _parts(self, path: str) -> tuple[str, str]:
        """Which of the folders an address is in, and the rest of it. Raises KeyError for none."""
        first, _, rest = path.lstrip("/").partition("/")
        name = unquote(first.partition("?")[0].partition("#")[0])
        if name in self.server.folders:
            return name, f"/{rest}"
        if "" in self.server.folders:
            return "", path
        raise KeyError(name)

    def _is_served(self) -> bool:
        """Whether there is such a file or folder, not behind a link that leads out of the served folder."""
        try:
            found = Path(self.translate_path(self.path))
            root = Path(self.directory)
            pages = [found / page for page in _INDEX] if found.is_dir() else []
            return (found.is_file() or found.is_dir()) and all(
                path.resolve().is_relative_to(root) for path in (found, *pages)
            )
        except (KeyError, OSError, ValueError):  # no such folder; a path that no system reads
            return False


def main() -> None:
    """Serve the folders that standard input names, until it closes."""
    server = PageServer()
    Thread(target=server.serve_forever, daemon=True).start()
    for line in sys.stdin.buffer:
        sys.stdout.write(f"{json.dumps(server.add(Path(json.loads(line))))}\n")
        sys.stdout.flush()
    os._exit(0)  # whatever a browser is still being sent


if __name__ == "__main__":
    main()
