# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole job: an object and a specification in, an atlas with its sidecar and a preview out.

The batch and the panel call these functions; so can a script. Data goes one way: evaluated mesh, UVs, texel
map, captures, atlas, files.
"""

from ..store.output_files import OutputFiles
from ..store.ownership import Overwrite
from .baking import BakeResult, bake_object, bake_steps
from .changed_bakes import Changes, changes
from .checks import check_request
from .layout_choice import Choice, OpenLayout, choose_layout, choose_layouts
from .split_parts import part_specs

__all__ = [
    "BakeResult",
    "Changes",
    "Choice",
    "OpenLayout",
    "OutputFiles",
    "Overwrite",
    "bake_object",
    "bake_steps",
    "changes",
    "check_request",
    "choose_layout",
    "choose_layouts",
    "part_specs",
]
