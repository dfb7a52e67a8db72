# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A small disk of its own, which can run full, become read-only or lose power: for root on Linux."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

if sys.platform != "win32":
    import fcntl

_SHUT_DOWN = 0x8004587D  # ext4's ioctl: nothing more reaches the disk, as when the power goes
_KEEP_NO_LOG = (2).to_bytes(4, sys.byteorder)


def unavailable() -> str:
    """Why there can be no such disk here; empty if there can."""
    if sys.platform != "linux" or os.geteuid() != 0:
        return "mounting takes root on Linux"
    lacking = [tool for tool in ("mkfs.ext4", "mount", "umount", "chattr") if not shutil.which(tool)]
    if lacking:
        return f"there is no {lacking[0]}"
    if subprocess.run(["losetup", "-f"], capture_output=True, check=False).returncode:
        return "there are no loop devices"
    return ""


class Disk:
    """An ext4 filesystem in a file, mounted at `folder`."""

    def __init__(self, image: Path, folder: Path, megabytes: int) -> None:
        self.folder, self._image = folder, image
        folder.mkdir(parents=True)
        with image.open("wb") as file:
            file.truncate(megabytes << 20)
        _run("mkfs.ext4", "-q", "-m", "0", "-O", "^resize_inode", image)
        self.mount()

    def mount(self) -> None:
        _run("mount", "-o", "loop", self._image, self.folder)

    def unmount(self, lazily: bool = False) -> None:
        _run("umount", *(["-l"] if lazily else []), self.folder)

    def fill(self, leave: int = 0) -> None:
        """Take all room but some bytes."""
        room = os.statvfs(self.folder)
        wanted = room.f_bavail * room.f_frsize - leave
        with (self.folder / "filler").open("ab") as file:
            while wanted > 0:
                try:
                    os.posix_fallocate(file.fileno(), file.seek(0, os.SEEK_END), wanted)
                    break
                except OSError:  # it also needs room for its own administration
                    wanted -= 4096

    def empty(self) -> None:
        (self.folder / "filler").unlink()

    def fail(self) -> None:
        """It becomes read-only, as after an error of the device."""
        _run("mount", "-o", "remount,abort", self.folder)

    def cut_power(self) -> None:
        """What has not reached it by now never will."""
        descriptor = os.open(self.folder, os.O_RDONLY)
        try:
            fcntl.ioctl(descriptor, _SHUT_DOWN, _KEEP_NO_LOG)
        finally:
            os.close(descriptor)

    def restart(self) -> None:
        """As the system does it after a failure."""
        self.unmount()
        subprocess.run(["fsck.ext4", "-p", self._image], capture_output=True, check=False)
        self.mount()


@contextmanager
def small_disk(root: Path, megabytes: int = 24) -> Iterator[Disk]:
    """A disk below `root`, until exit."""
    disk = Disk(root / "disk.img", root / "disk", megabytes)
    try:
        yield disk
    finally:
        subprocess.run(["umount", "-l", disk.folder], capture_output=True, check=False)
        (root / "disk.img").unlink()
        disk.folder.rmdir()


def set_fixed(folder: Path, fixed: bool) -> None:
    """Let nobody change what names are in a folder, root included."""
    _run("chattr", "+i" if fixed else "-i", folder)


def _run(*command: str | Path) -> None:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise OSError(f"{command[0]}: {done.stderr.strip()}")
