# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run by test_install.py in a bare environment: install ZIP, use it, remove it; write REPORT.

Usage: python -I install.py ZIP REPORT
"""

from __future__ import annotations

import hashlib
import importlib.util
import json
import platform
import sys
from collections.abc import Callable
from pathlib import Path

import bpy

EXTENSION = "bl_ext.user_default.radtex"
INTEL_MAC = (sys.platform, platform.machine()) == ("darwin", "x86_64")  # nobody makes FLIP for it
WHEELS = ("OpenEXR", "uvunwrap", "xatlas", *(() if INTEL_MAC else ("flip_evaluator",)))


def main(archive: str, answer: str) -> None:
    """Take Blender through the extension's life and note its state after each step."""
    folder = Path(answer).parent / "baked"
    folder.mkdir()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="bl_pkg")
    steps: dict[str, Callable[[], object]] = {
        "before": lambda: None,
        "enabled": lambda: bpy.ops.extensions.package_install_files(
            filepath=archive, repo="user_default", enable_on_install=True
        ),
        "baked": lambda: bake(folder),
        "disabled": lambda: bpy.ops.preferences.addon_disable(module=EXTENSION),
        "enabled_again": lambda: bpy.ops.preferences.addon_enable(module=EXTENSION),
        "removed": lambda: bpy.ops.extensions.package_uninstall(
            repo_index=user_repository(), pkg_id="radtex"
        ),
    }
    report = {}
    for name, step in steps.items():
        report[name] = {"error": attempt(step)} | state()
    Path(answer).write_text(json.dumps(report, indent=1))


def attempt(step: Callable[[], object]) -> str | None:
    """Take a step; return what Blender said if it failed, so that the steps after it still run."""
    try:
        step()
    except RuntimeError as error:
        return str(error)
    return None


def bake(folder: Path) -> None:
    """Bake a plane, small, by the operator, as a user's script would."""
    bpy.ops.mesh.primitive_plane_add()
    bpy.ops.radtex.bake(  # type: ignore[attr-defined]  # the stubs know Blender's own
        atlas_layout="buckets", texels=2, bucket=2, samples=1, directory=str(folder)
    )


def preferences() -> bpy.types.Preferences:
    """Blender's preferences: never None outside of restricted contexts."""
    assert bpy.context.preferences is not None
    return bpy.context.preferences


def user_repository() -> int:
    """The index of the repository "user_default" in the preferences."""
    return [repository.module for repository in preferences().extensions.repos].index("user_default")


def state() -> dict[str, object]:
    """Whatever an extension may leave behind, in lists that can be compared."""
    return {
        "addons": [addon.module for addon in preferences().addons if "radtex" in addon.module],
        "operator": "bake" in dir(bpy.ops.radtex),  # type: ignore[attr-defined]  # the stubs know Blender's own
        "types": sorted(name for name in dir(bpy.types) if "radtex" in name.lower()),
        "properties": properties(),
        "handlers": handlers(),
        "key_maps": key_maps(),
        "modules": sorted(name for name in sys.modules if name.startswith(EXTENSION)),
        "wheels": {name: origin(name) for name in WHEELS},
        "files": files(),
        "loaded_wheels": [name for name in WHEELS if name in sys.modules],
    }


def files() -> dict[str, str]:
    """SHA-256 of each file of the installed extension, but for what Python compiled of it."""
    folder = Path(preferences().extensions.repos[user_repository()].directory, "radtex")
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file() and path.parent.name != "__pycache__"
    }


def properties() -> list[str]:
    """Properties that Python code added to Blender's own types."""
    types = (getattr(bpy.types, name) for name in dir(bpy.types))
    return sorted(
        f"{cls.__name__}.{prop.identifier}"
        for cls in types
        if hasattr(cls, "bl_rna")
        for prop in cls.bl_rna.properties
        if prop.is_runtime and "radtex" in prop.identifier.lower()
    )


def handlers() -> dict[str, int]:
    """How many functions wait for each of Blender's events."""
    events = bpy.app.handlers
    return {
        name: len(getattr(events, name)) for name in dir(events) if isinstance(getattr(events, name), list)
    }


def key_maps() -> int:
    """How many keys add-ons have bound."""
    assert bpy.context.window_manager is not None
    configuration = bpy.context.window_manager.keyconfigs.addon
    return sum(len(key_map.keymap_items) for key_map in configuration.keymaps) if configuration else 0


def origin(name: str) -> str | None:
    """Where a module would be imported from."""
    spec = importlib.util.find_spec(name)
    return spec.origin if spec else None


if __name__ == "__main__":
    main(*sys.argv[1:])
