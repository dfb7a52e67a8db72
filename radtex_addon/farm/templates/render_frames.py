# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Render frames of the .blend beside this file with the bpy module, where there is no Blender program.

python render_frames.py -f 3,7..9                   of farm.blend
python render_frames.py -b farm.blend -f 3,7..9     as blender itself is called
python render_frames.py -b farm.blend -a            all of them
"""

from __future__ import annotations

import argparse
import os
import re
from collections.abc import Iterator

import bpy


def frames_of(listed: str) -> Iterator[int]:
    """3,7..9 or 3,7-9 as numbers."""
    for word in listed.split(","):
        found = re.fullmatch(r"(\d+)(?:(?:\.\.|-)(\d+))?", word.strip())
        if found is None:
            raise SystemExit(f"render_frames: '{word}' is no frame: give such as 3,7..9")
        yield from range(int(found[1]), int(found[2] or found[1]) + 1)


def main() -> None:
    """Render what the command line asks for."""
    parser = argparse.ArgumentParser(description="Render frames of a farm's .blend with the bpy module.")
    here = os.path.dirname(os.path.abspath(__file__))
    parser.add_argument("-b", dest="blend", metavar="FILE", default=os.path.join(here, "farm.blend"))
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument("-f", dest="frames", metavar="LIST")
    which.add_argument("-a", dest="all", action="store_true")
    asked = parser.parse_args()
    frames = [] if asked.all else list(frames_of(asked.frames))
    if not os.path.isfile(asked.blend):
        raise SystemExit(f"render_frames: {asked.blend} is not there: name the .blend by -b")
    bpy.ops.wm.open_mainfile(filepath=os.path.abspath(asked.blend), load_ui=False, use_scripts=False)
    scene = bpy.context.scene
    first, last = scene.frame_start, scene.frame_end
    frames = frames or list(range(first, last + 1))
    for frame in frames:
        if not first <= frame <= last:
            raise SystemExit(f"render_frames: there is no frame {frame}: they are {first} to {last}")
    for frame in frames:
        scene.frame_start = scene.frame_end = frame
        bpy.ops.render.render(animation=True)
        if not os.path.isfile(bpy.path.abspath(scene.render.frame_path(frame=frame))):
            raise SystemExit(f"render_frames: frame {frame} was not written")


if __name__ == "__main__":
    main()
