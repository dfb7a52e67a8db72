# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender with a window, on a screen of its own: mouse, keys and pictures from outside, Python inside."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import numpy as np
import PIL.Image

from tests.real.root import Root, Started, screen

SIZE = 1600, 900
_INSIDE = "/repository/tests/real/inside/window"
_START = 180.0  # seconds for Blender's window, whose first picture Mesa's software drivers draw
_VIEW = 700, 400  # a place in the 3D view
_LINE = 14  # pixels, less than a button is high
_SETTLED = 0.6  # seconds after which panels have glided to their places
_SIDEBAR = """
window = bpy.context.window_manager.windows[0]
area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
region = next(region for region in area.regions if region.type == "UI")
top = window.height - region.y - region.height
answer = region.x, top, region.width, region.height, region.active_panel_category
"""
_FIGURES = os.environ.get("RADTEX_FIGURES")


@dataclass(frozen=True)
class Window:
    """Blender's window. `folder` is seen by both sides, inside as `inside`."""

    agent: Started
    folder: Path
    inside: str

    def ask(self, code: str, timeout: float = 120) -> Any:
        """Execute Python in Blender's main loop; what it left in `answer`."""
        answer, question = self.folder / "answer.json", self.folder / "ask.unfinished"
        answer.unlink(missing_ok=True)
        question.write_text(code, encoding="utf-8")
        question.rename(self.folder / "ask.py")
        wait_until(answer.is_file, timeout, f"Blender does not answer {code!r}: {self.said()[-2000:]}")
        told = json.loads(answer.read_text(encoding="utf-8"))
        assert "error" not in told, told["error"]
        return told["answer"]

    def value(self, expression: str) -> Any:
        """What a Python expression is in Blender."""
        return self.ask(f"answer = {expression}")

    def run(self, *argv: str) -> str:
        """Run a program on Blender's screen; what it said."""
        told = self._order({"run": argv})
        assert told["rc"] == 0, told
        return str(told["out"])

    def start(self, argv: Sequence[str], log: str) -> int:
        """Start a program on the screen that speaks into `log`; its number."""
        return int(self._order({"start": argv, "log": f"{self.inside}/{log}"})["pid"])

    def start_blender(self, file: str = "", log: str = "blender.log") -> None:
        """Start Blender, which speaks into `log`, with a file of the folder, and wait until it answers."""
        width, height = map(str, SIZE)
        command = [
            *("blender", "--factory-startup", "--window-geometry", "0", "0", width, height),
            *([f"{self.inside}/{file}"] if file else []),
            *("--python", f"{_INSIDE}/driver.py", "--", self.inside),
        ]
        self.start(command, log)
        self.ask("", _START)

    def processes(self, word: str) -> list[int]:
        """Numbers of the processes that live and whose command lines hold `word`."""
        return [pid for pid, line in self._order({"processes": None})["processes"] if word in line]

    def point(self, x: int, y: int) -> None:
        """Move the mouse there, in pixels from the top left; Blender sees it come."""
        self.run("xdotool", "mousemove", str(x - 3), str(y - 1), "mousemove", str(x), str(y))
        sleep(0.1)

    def click(self, x: int, y: int) -> None:
        self.point(x, y)
        self.run("xdotool", "click", "1")
        sleep(0.2)

    def key(self, key: str, *, over_view: bool = False) -> None:
        """Press a key where the mouse is, or over the 3D view."""
        if over_view:
            self.point(*_VIEW)
        self.run("xdotool", "key", key)
        sleep(0.2)

    def show_tab(self, name: str) -> None:
        """Open the 3D view's sidebar by its key, and its tab by a click on it."""
        if self._sidebar()[2] <= 1:
            self.key("n", over_view=True)
            wait_until(lambda: self._sidebar()[2] > 1, 30, "no sidebar")
        left, top, width, height, _ = self._sidebar()
        for y in range(top + 20, top + height, 18):
            self.click(left + width - 10, y)
            if self._sidebar()[4] == name:
                return
        raise AssertionError(f"the sidebar has no tab {name}")

    def find(self, operator: str, *, right: int | None = None) -> tuple[int, int]:
        """Where the sidebar has a button for it: over which the mouse copies its Python by Ctrl-C.

        Looks along the sidebar's middle, or `right` pixels from its right edge.
        """
        left, top, width, height, _ = self._sidebar()
        x = left + (width // 2 if right is None else width - right)
        for patience in (0.03, 0.3):  # where others use this machine, keys take longer to come
            for y in range(top + 40, top + height, _LINE):
                if operator not in self._copied(x, y, patience):
                    continue
                for inside in (y + 5, y - 5):  # from its edge
                    if operator in self._copied(x, inside, 0.3):
                        return x, inside
        self.shot("missing")
        raise AssertionError(f"the sidebar has no button for {operator}")

    def scroll(self, notches: int) -> None:
        """Turn the wheel over the sidebar, downwards if positive."""
        left, top, width, height, _ = self._sidebar()
        self.point(left + width // 2, top + height // 2)
        button = "5" if notches > 0 else "4"
        self.run("xdotool", "click", "--repeat", str(abs(notches)), "--delay", "30", button)
        sleep(_SETTLED)

    def _copied(self, x: int, y: int, patience: float) -> str:
        """The Python of the button at that place, if Blender has copied it by then."""
        self.ask("bpy.context.window_manager.clipboard = ''")
        there = ["mousemove", str(x - 3), str(y), "mousemove", str(x), str(y)]
        self.run("xdotool", *there, "sleep", "0.03", "key", "ctrl+c")
        sleep(patience)
        return str(self.value("bpy.context.window_manager.clipboard"))

    def _sidebar(self) -> tuple[int, int, int, int, str]:
        """Left, top, width and height in pixels from the top left, and the tab that is open."""
        left, top, width, height, tab = self.ask(_SIDEBAR)
        return left, top, width, height, tab

    def picture(self, name: str) -> PIL.Image.Image:
        """A picture of the screen, once all has settled."""
        sleep(_SETTLED)
        path = self.folder / f"{name}.png"
        self.run("import", "-window", "root", f"{self.inside}/{path.name}")
        with PIL.Image.open(path) as opened_picture:
            return opened_picture.convert("RGB")

    def shot(self, name: str, box: tuple[int, int, int, int] | None = None) -> PIL.Image.Image:
        """The same, kept with the figures, in 256 colours, where those are wanted; of that only the `box`.

        The box is left, top, right and bottom in pixels.
        """
        picture = self.picture(name)
        if _FIGURES:
            picture.crop(box).quantize(256).save(Path(_FIGURES, f"window-{name}.png"), optimize=True)
        return picture

    def said(self) -> str:
        """What Blender said, each time that it was started."""
        return "".join(log.read_text(errors="replace") for log in sorted(self.folder.glob("blender*.log")))

    def _order(self, order: Mapping[str, object]) -> dict[str, Any]:
        assert self.agent.stdin is not None
        assert self.agent.stdout is not None
        self.agent.stdin.write(json.dumps(order).encode() + b"\n")
        self.agent.stdin.flush()
        answer: dict[str, Any] = json.loads(self.agent.stdout.readline())
        return answer


@contextmanager
def opened(root: Root) -> Iterator[Window]:
    """Blender's window as it is the first time, with the driver in it."""
    folder, inside = root.shared("window")
    (folder / "home").mkdir()
    command = root.command(
        screen(["python3", f"{_INSIDE}/screen.py"], *SIZE),
        env={"BLENDER_USER_RESOURCES": f"{inside}/home", "PYTHONPATH": "/repository"},
        cwd=inside,
    )
    with (
        (folder / "screen.log").open("wb") as log,
        Started(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log) as agent,
    ):
        window = Window(agent, folder, inside)
        window.start_blender()
        yield window


def wait_until(is_so: Callable[[], object], timeout: float, complaint: str) -> float:
    """Wait for it; returns how long that took, in seconds."""
    since = monotonic()
    while not is_so():
        assert monotonic() - since < timeout, complaint
        sleep(0.01)
    return monotonic() - since


def changed(before: PIL.Image.Image, after: PIL.Image.Image) -> float:
    """The share of pixels that differ between two pictures of the screen."""
    return float(np.mean(np.any(np.asarray(before) != np.asarray(after), axis=2)))
