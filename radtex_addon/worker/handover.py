# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Save the session's scene, with its unsaved changes, into a folder for a worker."""

from __future__ import annotations

import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from time import perf_counter, time
from typing import Any

import bpy  # noqa: TID251  # of this package, handover and images know Blender

from ..core.errors import BakeError
from ..cycles.device import preferred_device
from ..formats.disk.path_checks import one_root
from ..formats.disk.regular import FOLDER, open_regular, other_kind
from .kept_jobs import kept_folders
from .order import Handover, Program
from .unsaved_images import save_unsaved

_PREFIX = "radtex-job-"
_LEFT = 24 * 3600.0  # seconds after which a folder that shows no life was left by a Blender that died


def this_program() -> Program:
    """The program that runs RadTex now; workers are started with the same."""
    if bpy.app.module:
        return Program(sys.executable, is_blender=False)
    return Program(bpy.app.binary_path, is_blender=True, paths=tuple(path for path in sys.path if path))


def jobs_folder() -> Path:
    """The default folder for workers' files: the extension's own, else the system's temporary folder."""
    package = ".".join(__name__.split(".")[:3])
    try:
        return Path(bpy.utils.extension_path_user(package, path="jobs", create=True))
    except ValueError:  # not installed as an extension
        return Path(one_root(tempfile.gettempdir()))


def work_folder(root: Path | None = None) -> Path:
    """Make a folder for a worker below `root` (default: `jobs_folder()`). Raises BakeError."""
    root = jobs_folder() if root is None else root
    try:
        root.mkdir(parents=True, exist_ok=True)
        _remove_left(root)
        return Path(tempfile.mkdtemp(prefix=_PREFIX, dir=root)).absolute()
    except OSError as error:
        raise _refused(root, error) from error


def hand_over(scene: bpy.types.Scene, root: Path | None = None) -> Handover:
    """Save `scene` with its file as it is now, unsaved changes and painted images too, below `root`.

    Relative paths and libraries in the copy point to the same files. The session's file, images, selection
    and undo history do not change, and save handlers of other add-ons are not called. Raises BakeError if the
    system refuses.
    """
    since = perf_counter()
    folder = work_folder(root)
    try:
        images = folder / "images"
        painted = save_unsaved(images)
        blend = folder / f"{Path(bpy.data.filepath).stem or 'untitled'}.blend"
        with _sleeping_handlers():
            bpy.ops.wm.save_as_mainfile(filepath=str(blend), copy=True, relative_remap=True, **_compression())
        _copy_caches(folder)
    except (OSError, RuntimeError) as error:
        shutil.rmtree(folder, ignore_errors=True)
        raise _refused(folder.parent, error) from error
    except BaseException:
        shutil.rmtree(folder, ignore_errors=True)
        raise
    return Handover(
        folder=folder,
        blend=blend,
        scene=scene.name,
        images=images if painted else None,
        device=preferred_device(),
        stalled=perf_counter() - since,
        original=Path(bpy.data.filepath) if bpy.data.filepath else Path(),
    )


def _refused(root: Path, error: Exception) -> BakeError:
    reason = " ".join(str(error).removeprefix("Error:").split())
    return BakeError(f"nothing can be saved for a worker below {root} ({reason}): choose another folder")


def _compression() -> dict[str, Any]:
    """Keep the open file's compression: what is passed here becomes Blender's choice for the next save."""
    if not bpy.data.filepath:
        return {"compress": False}  # the quicker; for a first save the preferences decide
    with suppress(OSError), open_regular(Path(bpy.data.filepath)) as file:
        return {"compress": file.read(7) != b"BLENDER"}
    return {}


def _copy_caches(folder: Path) -> None:
    """Copy simulation caches from disk: Blender looks for them beside the .blend, by its name."""
    if bpy.data.filepath:
        file = Path(bpy.data.filepath)
        caches = file.with_name(f"blendcache_{file.stem}")
        if caches.is_dir():
            shutil.copytree(caches, folder / caches.name, ignore=_no_files)


def _no_files(folder: str, names: list[str]) -> set[str]:
    """Names in `folder` to skip: pipes, devices and links to them, which cannot be copied."""
    kinds = {name: other_kind(Path(folder, name)) for name in names}
    return {name for name, kind in kinds.items() if kind not in (None, FOLDER)}


@contextmanager
def _sleeping_handlers() -> Iterator[None]:
    lists = (bpy.app.handlers.save_pre, bpy.app.handlers.save_post, bpy.app.handlers.save_post_fail)
    saved = [list(functions) for functions in lists]
    try:
        for functions in lists:
            functions.clear()
        yield
    finally:
        for functions, before in zip(lists, saved, strict=True):
            functions[:] = before


def _remove_left(root: Path) -> None:
    kept = kept_folders(jobs_folder())
    for folder in root.glob(f"{_PREFIX}*"):
        if folder.absolute() in kept:
            continue
        with suppress(OSError):
            if time() - folder.stat().st_mtime > _LEFT:
                shutil.rmtree(folder, ignore_errors=True)
