# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Let pages link to files of the repository outside docs, as code hosts show them.

A page may include such a file, as CHANGELOG.md: its relative links are made relative to the page, and links
to it lead to the page. Licences and what lies in shaders are offered for download. Any other file outside
docs is a warning, which fails the build. A link that is named after its file gets the page's title.
"""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx.util import logging

_LOG = logging.getLogger(__name__)
_INCLUDED = re.compile(r"^```\{include\} +(\S+)", re.MULTILINE)
_LINK = re.compile(r"(?<=\]\()(?![a-z]+:)(?![#/])([^)#\s]+)")
_FILE = re.compile(r"[\w./-]+\.md")
_FRONT = {"README.md": "index"}  # the repository's front page is not the site's, but as good
_OFFERED = ("shaders/", "LICENSE")


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the extension; called by Sphinx."""
    app.connect("include-read", _move_links)
    app.add_post_transform(LinkedFiles)
    return {"parallel_read_safe": True}


def _move_links(app: Sphinx, included: Path, _page: str, content: list[str]) -> None:
    """Make an included file's relative links relative to the page that includes it."""
    page = Path(app.env.doc2path(app.env.docname)).parent
    folder = Path(app.srcdir, included).parent

    def moved(found: re.Match[str]) -> str:
        return Path(os.path.relpath(folder / found[1], page)).as_posix()

    content[0] = _LINK.sub(moved, content[0])


class LinkedFiles(SphinxPostTransform):
    """Leads a page's links to files to the pages that have them; warns where there is none."""

    default_priority = 8  # before MyST's MystReferenceResolver

    def run(self, **_: Any) -> None:
        docs = Path(self.env.srcdir)
        pages = _pages_of_files(docs)
        for link in self.document.findall(addnodes.pending_xref):
            if link["reftype"] == "myst" and link["refdomain"] == "doc":
                self._lead(link, pages)
        for file in self.document.findall(addnodes.download_reference):
            path = Path(self.env.relfn2path(file["reftarget"], file["refdoc"])[1]).resolve()
            name = path.relative_to(docs.parent).as_posix()
            if not path.is_relative_to(docs) and not name.startswith(_OFFERED):
                _LOG.warning("links to %s, which is not on the site", name, location=file)

    def _lead(self, link: addnodes.pending_xref, pages: dict[str, str]) -> None:
        target = link["reftarget"]
        if Path(target).is_absolute():  # so MyST names a Markdown file outside docs, without the suffix
            name = Path(f"{target}.md").relative_to(Path(self.env.srcdir).parent).as_posix()
            link["reftarget"] = target = pages.get(name, target)
        if _FILE.fullmatch(link.astext()) and target in self.env.titles:
            title = self.env.titles[target].astext()
            link.children = [nodes.inline("", title, classes=["xref", "myst"])]


def _pages_of_files(docs: Path) -> dict[str, str]:
    """Files outside docs, relative to the repository, and the page that includes each."""
    pages = dict(_FRONT)
    for page in docs.rglob("*.md"):
        for included in _INCLUDED.findall(page.read_text(encoding="utf-8")):
            name = (page.parent / included).resolve().relative_to(docs.parent).as_posix()
            pages[name] = page.relative_to(docs).with_suffix("").as_posix()
    return pages
