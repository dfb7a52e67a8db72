# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sphinx's settings for RadTex's site; .ci/build_docs.py builds it."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

# The addresses of the site and the repository, once there are any: Documentation and Repository in
# pyproject.toml's [project.urls]. Nothing else names them.
URLS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"].get("urls", {})

project = "RadTex"
author = "RadTex authors"
copyright = "2026 RadTex authors"  # noqa: A001  # Sphinx names it
version = release = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))["version"]

extensions = [
    "docs._ext.generated",
    "docs._ext.plain_docstrings",
    "docs._ext.repository_links",
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.githubpages",  # or GitHub leaves out folders that begin with an underscore
    "sphinx_copybutton",
]
exclude_patterns = ["_ext"]
smartquotes = False  # options begin with two dashes
highlight_language = "none"  # a block that names no language is output, or a formula
myst_enable_extensions = ["attrs_inline", "colon_fence", "html_image"]
myst_heading_anchors = 6  # links such as format.md#lookups, as code hosts have them

nitpicky = True
nitpick_ignore_regex = [
    ("py:class", r"(?!radtex_addon\.).*"),  # other packages': the site is built without the internet
    ("py:class", r"radtex_addon\.forms\.form\.Form"),  # these two are handed on by those who get them
    ("py:class", r"radtex_addon\.formats\.fingerprint\.Fingerprint"),
    ("py:class", r".*\._\w+"),  # type variables
]
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
python_maximum_signature_line_length = 88
python_use_unqualified_type_names = True

html_theme = "furo"
html_baseurl = URLS.get("Documentation", "")
html_title = f"RadTex {version}"
html_favicon = "figures/listing-icon.png"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False
html_theme_options = {
    **({"source_repository": URLS["Repository"], "source_branch": "main"} if "Repository" in URLS else {}),
    "source_directory": "docs/",
    "light_css_variables": {"color-brand-primary": "#a04a00", "color-brand-content": "#a04a00"},
    "dark_css_variables": {"color-brand-primary": "#ffb454", "color-brand-content": "#ffb454"},
}
pygments_dark_style = "github-dark"
linkcheck_timeout = 20  # seconds
