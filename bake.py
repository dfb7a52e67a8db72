# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake radiance textures without a window.

blender -b scene.blend -P bake.py -- --object NAME --out DIR
python bake.py scene.blend --object NAME --out DIR
python bake.py demo
python bake.py report DIR --scene scene.blend
python bake.py export DIR --to web
python bake.py compare scene.blend --object NAME --bake DIR
python bake.py prepare scene.blend --object NAME --out DIR
python bake.py assemble DIR/NAME.radiance.radtex-farm
"""

from __future__ import annotations

import atexit
import importlib
import os
import shutil
import signal
import sys
from contextlib import suppress
from pathlib import Path
from types import FrameType

_HERE = Path(__file__).resolve().parent
_REMEDY = (
    "in Blender, install the RadTex extension (Edit > Preferences > Get Extensions > Install from Disk) and "
    "enable it; with Python, run it as: uv run bake.py"
)


def run() -> int:
    """Find out how we were started, and hand over."""
    try:
        import bpy

        main = importlib.import_module(f"{_package()}.cli.main").main
    except ModuleNotFoundError as error:
        print(f"radtex: the Python module '{error.name}' is missing: {_REMEDY}", file=sys.stderr)
        return 2
    except ImportError as error:  # a wheel for another Python or platform
        reason = " ".join(str(error).split())
        print(f"radtex: a Python module does not load ({reason}): {_REMEDY}", file=sys.stderr)
        return 2
    inside_blender = not bpy.app.module
    if inside_blender:
        arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    else:
        arguments = sys.argv[1:]
    code: int = main(arguments, inside_blender)
    return code


def _package() -> str:
    """The name under which RadTex can be imported: in a clone its own, installed the extension's.

    Only a clone is added to Python's path: `blender -P` does not add a script's folder. An extension has its
    repository's package, `bl_ext.REPOSITORY`.
    """
    if (_HERE / "pyproject.toml").is_file():  # does not ship
        sys.path.insert(0, str(_HERE))
        return "radtex_addon"
    return f"bl_ext.{_repository(_HERE.parent)}.{_HERE.name}.radtex_addon"


def _repository(folder: Path) -> str:
    """The name of the extension repository in `folder`.

    With factory settings, as workers run, Blender knows its default ones only: others are added for this run.
    """
    import bpy

    assert bpy.context.preferences is not None  # only restricted contexts have none
    repositories = bpy.context.preferences.extensions.repos
    for known in repositories:
        if known.enabled and Path(known.directory).resolve() == folder:
            return known.module
    return repositories.new(name="RadTex", module="radtex", custom_directory=str(folder)).module


def _leave_when_interrupted() -> None:
    """End at once by Ctrl-C or SIGTERM until the batch listens: Blender's start swallows exceptions."""

    def leave(_number: int, _frame: FrameType | None) -> None:
        with suppress(OSError):
            os.write(2, b"radtex: interrupted: nothing unfinished is left\n")
        os._exit(130)

    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):  # else it is silenced
            signal.signal(number, leave)


def _open_what_is_closed() -> None:
    """Let no file get the number of a standard stream that was closed: Blender's words would get into it.

    What takes its place can be neither written nor read, so that a lost result is noticed.
    """
    for number, other_way in ((0, os.O_WRONLY), (1, os.O_RDONLY), (2, os.O_RDONLY)):
        try:
            os.fstat(number)
        except OSError:
            opened = os.open(os.devnull, other_way)
            if opened != number:
                os.dup2(opened, number)
                os.close(opened)


def _keep_stdout_clean() -> None:
    """Give Python another standard output than Blender, which talks on it from its import to its exit."""
    if sys.stdout is not None:  # it is not where it was closed
        sys.stdout.flush()
    ours = os.dup(1)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)
    encoding = "utf-8" if sys.stdout is None else sys.stdout.encoding
    sys.stdout = os.fdopen(ours, "w", encoding=encoding, errors="backslashreplace")


def _code(ended: SystemExit) -> int:
    """What `--help` and the like leave with."""
    return ended.code if isinstance(ended.code, int) else int(ended.code is not None)


def _said(code: int) -> int:
    """The exit code, once all that was printed is out; 1 where that cannot be."""
    try:
        sys.stdout.flush()
    except OSError as error:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())  # what it still holds goes there
        os.close(nowhere)
        if code == 0 and sys.stderr is not None:
            with suppress(OSError):
                print(f"radtex: the standard output cannot be written ({error.strerror})", file=sys.stderr)
        return code or 1
    return code


def _leave_without_destructors(ended: list[int]) -> None:
    """End with the code that is in `ended`: 4.5's C++ destructors, which would follow, may wait for ever.

    Blender's temporary folder would go after them.
    """
    if not ended:
        return
    blender = sys.modules.get("bpy")
    folder = Path(blender.app.tempdir) if blender is not None else None
    if folder is not None and folder.name.startswith("blender_"):
        shutil.rmtree(folder, ignore_errors=True)
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError, AttributeError):  # full, closed, none
            stream.flush()
    os._exit(ended[0])


if __name__ == "__main__":
    _open_what_is_closed()
    _leave_when_interrupted()
    _keep_stdout_clean()
    ended: list[int] = []
    if "bpy" not in sys.modules:  # the module, not Blender itself
        atexit.register(_leave_without_destructors, ended)
    try:
        code = run()
    except SystemExit as asked:
        code = _code(asked)
    ended.append(_said(code))
    sys.exit(ended[0])
