# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Let pages link to files of the repository outside docs, as code hosts show them.

A file that is a page of the site becomes a link to that page; any other must be there, and is offered for download.
"""

from __future__ import annotations

import posixpath
import re
from typing import Any

from sphinx.application import Sphinx

# Files of the repository that pages of the site include.
PAGES = {
    "CHANGELOG.md": "/project/changelog.md",
    "CONTRIBUTING.md": "/project/contributing.md",
    "README.md": "/index.md",
    "shaders/README.md": "/reference/shaders.md",
}
_LINK = re.compile(r"\]\((?P<path>\.\./[^)#\s]+)(?P<anchor>#[^)\s]*)?\)")


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the extension; called by Sphinx."""
    app.connect("source-read", _replace_links)
    return {"parallel_read_safe": True}


def _replace_links(_app: Sphinx, name: str, source: list[str]) -> None:
    source[0] = replaced(source[0], posixpath.join("docs", posixpath.dirname(name)))


def replaced(text: str, folder: str) -> str:
    """A page's text with links to included files as links to the pages that include them.

    `folder` is the page's, relative to the repository.
    """

    def link(found: re.Match[str]) -> str:
        target = posixpath.normpath(posixpath.join(folder, found["path"]))
        page = PAGES.get(target)
        return f"]({page}{found['anchor'] or ''})" if page else found[0]

    return _LINK.sub(link, text)
