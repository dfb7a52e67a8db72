# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sphinx's settings for RadTex's site; .ci/build_docs.py builds it."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "docs/_ext")]

project = "RadTex"
author = "RadTex authors"
copyright = "2026 RadTex authors"  # noqa: A001  # Sphinx names it
version = release = tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))["version"]

extensions = [
    "links_to_files",
    "myst_parser",
    "reference_pages",
    "sphinx.ext.autodoc",
    "sphinx_copybutton",
    "sphinx_design",
]
exclude_patterns = ["_ext", "gltf/*/examples"]
myst_enable_extensions = ["attrs_inline", "colon_fence"]
myst_heading_anchors = 4  # links such as format.md#lookups, as code hosts have them
suppress_warnings = ["myst.header"]  # the reference begins pages with what other pages contain

default_role = "code"  # docstrings put names between single backticks
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_class_signature = "mixed"
python_maximum_signature_line_length = 88

html_theme = "furo"
html_title = f"RadTex {version}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sphinx = False
html_copy_source = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#a04a00", "color-brand-content": "#a04a00"},
    "dark_css_variables": {"color-brand-primary": "#ffb454", "color-brand-content": "#ffb454"},
}
pygments_dark_style = "github-dark"
linkcheck_timeout = 20  # seconds
