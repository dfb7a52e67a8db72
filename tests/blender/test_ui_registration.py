# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Disabling RadTex leaves nothing: no class, property, handler, timer, key or preset."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import bpy

from radtex_addon.settings.presets import SUBDIR
from radtex_addon.ui import registration
from radtex_addon.ui.jobs import estimates, jobs
from radtex_addon.ui.panel import panel_state
from tests.blender.ui_stage import context

TIMERS = (panel_state._tick, jobs._pulse, estimates._pulse)


def state() -> dict[str, Any]:
    events = bpy.app.handlers
    lists = {name: getattr(events, name) for name in dir(events)}
    return {
        "types": sorted(name for name in dir(bpy.types) if "radtex" in name.lower()),
        "operators": sorted(dir(bpy.ops.radtex)),  # type: ignore[attr-defined]  # ours, not Blender's
        "properties": sorted(
            one.identifier for owner in (bpy.types.Scene, bpy.types.Object) for one in owner.bl_rna.properties
        ),
        "handlers": {
            name: list(functions) for name, functions in lists.items() if isinstance(functions, list)
        },
        "timers": [bpy.app.timers.is_registered(timer) for timer in TIMERS],
        # Blender puts the menu's own function beside the first one that is appended, and leaves it there.
        "menu": len(getattr(bpy.types.VIEW3D_MT_object.draw, "_draw_funcs", (None,))),
        "presets": bpy.utils.preset_paths(SUBDIR),
        "keys": sum(len(keymap.keymap_items) for keymap in context.window_manager.keyconfigs.addon.keymaps),
    }


def test_registering_twice_leaves_nothing_behind() -> None:
    before = state()
    for _ in range(2):
        registration.register()
        during = state()
        assert all(cls.is_registered for cls in registration.CLASSES)
        assert {"RADTEX_OT_bake", "RADTEX_PT_bake"} <= set(during["types"])
        assert during["handlers"] != before["handlers"]
        assert any(during["timers"])
        assert "radtex" in during["properties"]
        assert during["keys"] == before["keys"] + 2
        registration.unregister()
        assert state() == before
        assert not any(cls.is_registered for cls in registration.CLASSES)


def test_enabling_loads_no_wheel() -> None:
    lines = (
        "from radtex_addon.ui import registration",
        "registration.register()",
        "import sys",
        "wheels = {'OpenEXR', 'xatlas', 'flip_evaluator'} & set(sys.modules)",
        "registration.unregister()",
        "print('wheels:', wheels, flush=True)",
        "import os; os._exit(0)",
    )
    done = subprocess.run(
        [sys.executable, "-c", "\n".join(lines)],
        cwd=Path(__file__).parents[2],
        capture_output=True,
        text=True,
        check=True,
    )
    assert "wheels: set()" in done.stdout
