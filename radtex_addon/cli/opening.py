# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Open the scene of a run."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol, cast

import bpy

from ..core.errors import InputError
from ..formats.disk.path_checks import check_for_blender
from ..scene.checks.file_checks import check_outside_files, file_warnings
from ..scene.demo import build_demo_scene
from ..worker.unsaved_images import load_unsaved
from .interruption import Interruption


class SceneRequest(Protocol):
    """What requests have that open a scene."""

    @property
    def scene(self) -> Path | None: ...

    @property
    def demo(self) -> bool: ...

    @property
    def in_scene(self) -> str | None: ...

    @property
    def unsaved_images(self) -> Path | None: ...

    @property
    def parent_pipe(self) -> bool: ...


log = logging.getLogger(__name__)


@contextmanager
def scripts_off(inside_blender: bool) -> Iterator[None]:
    """Context manager that disables Python scripts and drivers of .blend files, whatever the preferences say.

    Inside Blender nothing changes: Blender's own `--enable-autoexec` and preferences apply.
    """
    if inside_blender:
        yield
        return
    context: Any = bpy.context  # the stubs type preferences as optional
    before = context.preferences.filepaths.use_scripts_auto_execute
    context.preferences.filepaths.use_scripts_auto_execute = False  # preferences are not saved
    try:
        yield
    finally:
        context.preferences.filepaths.use_scripts_auto_execute = before


def open_asked(request: SceneRequest, interruption: Interruption) -> bpy.types.Scene:
    """The scene of a request, with its unsaved images; cancelled from now on by the parent's pipe, if any.

    Raises InputError as `open_scene` does.
    """
    if request.parent_pipe:
        interruption.ask_when_input_ends()
    scene = open_scene(request.scene, request.demo, request.in_scene)
    if request.unsaved_images is not None:
        load_unsaved(request.unsaved_images)
    return scene


def open_scene(path: Path | None, demo: bool, name: str | None = None) -> bpy.types.Scene:
    """The demo scene, the scene of the .blend `path`, or of the open file. Raises InputError.

    `name` selects one of several scenes; the default is the file's active scene.
    """
    if demo:
        return build_demo_scene()
    if path is not None:
        _open(path)
        check_outside_files()
        for complaint in file_warnings():
            log.warning(complaint)
    if name is not None:
        return _named(name)
    scene = bpy.context.scene
    assert scene is not None  # None only while Blender starts
    return scene


def _named(name: str) -> bpy.types.Scene:
    """Make the scene called `name` the active one. Raises InputError if there is none."""
    scene = bpy.data.scenes.get(name)
    if scene is None:
        known = ", ".join(f"'{scene.name}'" for scene in bpy.data.scenes)
        raise InputError(f"there is no scene '{name}' in the file: it has {known}")
    assert bpy.context.window is not None  # exists in background mode too
    bpy.context.window.scene = scene
    return scene


def _open(path: Path) -> None:
    """Open a .blend without running its scripts. Raises InputError."""
    check_for_blender(path)
    try:
        if path.is_dir():
            raise InputError(f"{path} is a folder: name a .blend file in it")
        if not path.is_file():
            raise InputError(f"there is no file {path}: check its name, and where it lies")
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}; name another") from error
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path.resolve()), load_ui=False, use_scripts=False)
    except RuntimeError as error:
        reason = " ".join(str(error).removeprefix("Error:").split())
        raise InputError(f"{path} does not open as a .blend: {reason}; name another") from error
    major, minor, _ = cast("tuple[int, int, int]", bpy.data.version)  # the stubs do not type its items
    if (major, minor) > bpy.app.version[:2]:
        log.warning("%s was saved by Blender %d.%d, newer than this: some of it is lost", path, major, minor)
