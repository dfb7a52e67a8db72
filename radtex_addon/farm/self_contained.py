# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Make the open file independent of others: libraries local, images packed, volumes copied beside it.

Files of this machine that go along are checked for their type and size, and listed.
"""

from __future__ import annotations

import logging
import os
import shutil
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO, cast

import bpy

from ..core.errors import InputError
from ..formats.disk.kinds_of_files import FileKind, open_of_kind
from ..formats.disk.memory import readable_size

log = logging.getLogger(__name__)

MOST_PACKED = (2 << 30) - 1  # bytes of a file in a .blend
MOST_BESIDE = 16 << 30  # bytes of a file beside it
MOST = 32 << 30  # bytes of all of them

_PUT_BACK = "put the right file there, or take it out of the scene"
FILES = "files"  # the folder beside the .blend for what it cannot hold


@dataclass(frozen=True)
class Carried:
    """A file that is copied; `user` names the data-block that uses it; `bytes` is None if only a part is."""

    user: str
    path: str
    bytes: int | None
    how: str

    def __str__(self) -> str:
        size = "" if self.bytes is None else f", {readable_size(self.bytes)}"
        return f"{self.user}: {self.path} ({self.how}{size})"


class Luggage:
    """The files to be copied so far."""

    def __init__(self) -> None:
        self.carried: list[Carried] = []

    def add(self, user: str, path: Path, kind: FileKind, how: str, most: int = MOST_PACKED) -> None:
        """Check and add a file. Raises InputError as `opened` does."""
        with self.opened(user, path, kind, how, most):
            pass

    @contextmanager
    def opened(self, user: str, path: Path, kind: FileKind, how: str, most: int) -> Iterator[BinaryIO]:
        """Check and add a file, and return it open.

        Raises InputError, with its name, if it cannot be read, is no regular file, of another type than its
        user reads, or too large.
        """
        try:
            file = open_of_kind(path, kind)
        except OSError as error:
            raise InputError(
                f"{user}: {path} cannot be read ({error.strerror or error}): {_PUT_BACK}"
            ) from error
        except ValueError as error:
            raise InputError(f"{user}: {path} does not travel, for {error}: {_PUT_BACK}") from error
        with file:
            size = os.fstat(file.fileno()).st_size
            total = size + sum(each.bytes or 0 for each in self.carried)
            if size > most:
                raise InputError(
                    f"{user}: {path} has {readable_size(size)}, and {readable_size(most)} are the most that "
                    "travel: make it smaller, or bake without a farm"
                )
            if total > MOST:
                raise InputError(
                    f"{user}: with {path} {readable_size(total)} would travel, and {readable_size(MOST)} are "
                    "the most: make files smaller, or bake without a farm"
                )
            self.carried.append(Carried(user, str(path), size, how))
            yield file

    def copy(self, user: str, path: Path, kind: FileKind, target: Path) -> None:
        """Copy a file to `target`, which is new. Raises InputError as `opened` does, OSError."""
        with self.opened(user, path, kind, "beside the .blend", MOST_BESIDE) as file:
            size = os.fstat(file.fileno()).st_size
            free = shutil.disk_usage(target.parent).free
            if size > free:
                raise InputError(
                    f"{user}: {path} has {readable_size(size)}, and {target.parent} has room for "
                    f"{readable_size(free)}: free its disk, or choose another folder"
                )
            with target.open("xb") as copy:
                while size > 0 and (data := file.read(min(size, 1 << 22))):
                    copy.write(data)
                    size -= len(data)


def make_local() -> tuple[Carried, ...]:
    """Make everything that is linked or overridden local; returns the library files.

    Raises InputError for an object of a scene that loses its name, by which bakes find it, and which its
    materials may read.
    """
    shown = _shown()
    linked = list(_linked())
    while linked:
        for block in linked:
            block.make_local(clear_liboverride=True)
        left = list(_linked())
        if len(left) == len(linked):  # what nothing local uses
            break
        linked = left
    if renamed := shown - _shown():
        raise InputError(
            f"object '{min(renamed)}' has the name of another object, one of which is linked, and what is "
            "prepared for a farm has no libraries: rename one of them"
        )
    libraries: Any = bpy.data.libraries
    found = tuple(
        Carried(
            f"library '{library.name}'", bpy.path.abspath(library.filepath), None, "what is linked from it"
        )
        for library in libraries
        if library.packed_file is None
    )
    for library in list(libraries):
        libraries.remove(library)
    return found


def _shown() -> Counter[str]:
    """How many objects of each name are in scenes; there are several only of different files."""
    return Counter(item.name for scene in bpy.data.scenes for item in scene.collection.all_objects)


@dataclass(frozen=True)
class PackedFiles:
    """Files `beside` a .blend, relative to its folder, and all files of this machine that were copied."""

    beside: tuple[str, ...]
    carried: tuple[Carried, ...]


def pack_files(folder: Path, shared: Path | None = None) -> PackedFiles:
    """Pack what a .blend can hold, and copy volumes beside it; the open file is going to be in `folder`.

    Volumes that were copied already, beside another .blend in the folder `shared`, stay there.

    Raises InputError, with the name, for data that needs a file which can be neither packed nor copied, for
    files that are not of the type that the scene expects (in a .blend from elsewhere a lamp's IES file may be
    /etc/shadow), and for files that are too large.
    """
    _keep_needed_objects()
    cast(Any, bpy.data).orphans_purge(do_local_ids=True, do_linked_ids=True, do_recursive=True)
    luggage = Luggage()
    _pack_images(luggage)
    for font in bpy.data.fonts:
        if font.packed_file is None and not font.filepath.startswith("<"):
            _look_at(luggage, "font", font, FileKind.FONT)
            font.pack()
    _keep_light_shapes(luggage)
    beside = tuple(
        _copy_volume(volume, folder, luggage, shared) for volume in bpy.data.volumes if not _is_held(volume)
    )
    _refuse_other_files()
    return PackedFiles(beside, tuple(luggage.carried))


def _keep_needed_objects() -> None:
    """Give objects in no collection a user where others need them: parents and targets do not count as used.

    Without it they were taken for unused data, and what they move or shape would look otherwise.
    """
    users = bpy.data.user_map()
    left = {item for item in bpy.data.objects if not item.users_collection}
    while found := {item for item in left if users[item] - left}:
        for item in found:
            item.use_fake_user = True
        left -= found


def _look_at(luggage: Luggage, what: str, block: Any, kind: FileKind, filepath: str | None = None) -> None:
    """Check and list a data-block's file. Raises InputError."""
    path = bpy.path.abspath(block.filepath if filepath is None else filepath, library=block.library)
    luggage.add(f"{what} '{block.name}'", Path(path), kind, "in the .blend")


def _pack_images(luggage: Luggage) -> None:
    image: Any
    for image in bpy.data.images:
        packed = any(file.packed_file is not None for file in image.packed_files)
        if packed or image.type in {"RENDER_RESULT", "COMPOSITING"} or image.source == "VIEWER":
            continue
        if image.source == "GENERATED" and not image.is_dirty:
            continue
        for path in _files_of(image):
            if path.exists():
                luggage.add(f"image '{image.name}'", path, FileKind.IMAGE, "in the .blend")
        try:
            image.pack()
        except RuntimeError:
            log.warning("image '%s': its file is missing, and the bake shows it in pink", image.name)


def _files_of(image: Any) -> list[Path]:
    """The files of an image that Blender packs; none for an image that was painted in Blender."""
    if image.source not in {"FILE", "TILED", "SEQUENCE"} or not image.filepath:
        return []
    path = bpy.path.abspath(image.filepath, library=image.library)
    if image.source != "TILED":
        return [Path(path)]
    found = []
    for tile in image.tiles:
        u, v = (tile.number - 1001) % 10, (tile.number - 1001) // 10
        found.append(Path(path.replace("<UDIM>", str(tile.number)).replace("<UVTILE>", f"u{u + 1}_v{v + 1}")))
    return found


def _keep_light_shapes(luggage: Luggage) -> None:
    """Store the text of lamps' IES files in the .blend."""
    for light in bpy.data.lights:
        tree: Any = light.node_tree
        for node in tree.nodes if tree is not None else ():
            if node.type == "TEX_IES" and node.mode == "EXTERNAL" and node.filepath:
                _look_at(luggage, "lamp", light, FileKind.LAMP_SHAPE, node.filepath)
                text = bpy.data.texts.load(bpy.path.abspath(node.filepath, library=light.library))
                node.mode, node.ies = "INTERNAL", text


def _is_held(volume: Any) -> bool:
    """Whether the file is packed: Blender packs volumes only on the user's request."""
    return getattr(volume, "packed_file", None) is not None


def _copy_volume(volume: Any, folder: Path, luggage: Luggage, shared: Path | None) -> str:
    source = Path(bpy.path.abspath(volume.filepath, library=volume.library))
    if shared is not None and source.parent.resolve() == (shared / FILES).resolve():
        name = Path(os.path.relpath(source.resolve(), folder.resolve())).as_posix()
        volume.filepath = f"//{name}"
        return name
    name = f"{FILES}/{volume.session_uid}-{source.name}"
    target = folder / name
    target.parent.mkdir(exist_ok=True)
    luggage.copy(f"volume '{volume.name}'", source, FileKind.VOLUME, target)
    volume.filepath = f"//{name}"
    return name


def _refuse_other_files() -> None:
    owner: Any
    for owner, paths in cast(Any, bpy.data).file_path_map().items():
        if isinstance(owner, bpy.types.Image | bpy.types.VectorFont | bpy.types.Volume | bpy.types.Text):
            continue
        for path in sorted(paths):
            if Path(bpy.path.abspath(path)).exists():
                raise InputError(
                    f"'{owner.name}' needs the file {path}, which no .blend can hold: do without it, "
                    "or bake without a farm"
                )


def _linked() -> Iterator[Any]:
    for kind in bpy.data.bl_rna.properties:
        if kind.type == "COLLECTION" and kind.identifier not in {"all_ids", "libraries"}:
            for block in getattr(bpy.data, kind.identifier):
                if block.library is not None or block.override_library is not None:
                    yield block
