# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished bake drawn by OpenGL with our own shaders, as a game would: mesh, camera, textures.

Nothing here needs Blender; `baked_model` reads a bake's mesh.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import moderngl
import numpy as np

from radtex_addon.core.arrays import Floats
from radtex_addon.core.frame import normalised
from tests.real.opengl import VERSIONS, AnyTexture

SHADERS = Path(__file__).parents[2] / "shaders"
_VERTEX = """
uniform mat4 seen;
in vec3 in_position, in_normal;
in vec4 in_tangent;
in vec2 in_uv;
centroid out vec3 position, normal;
centroid out vec4 tangent;
centroid out vec2 uv;
void main() {
    gl_Position = seen * vec4(in_position, 1.0);
    position = in_position;
    normal = in_normal;
    tangent = in_tangent;
    uv = in_uv;
}
"""
_FRAGMENT = """
uniform vec3 camera;
centroid in vec3 position, normal;
centroid in vec4 tangent;
centroid in vec2 uv;
out vec4 result;
"""


@dataclass(frozen=True, eq=False)
class Model:
    """A mesh in world space: `corners` (3 F, 12) float32, position, normal, tangent, sign and uv.

    `parts`: how many corners each material has, one after the other. Its points lie within `radius` of
    `middle`.
    """

    corners: Floats
    middle: Floats
    radius: float
    parts: tuple[int, ...]

    @classmethod
    def of(cls, corners: Floats, parts: Sequence[int] = ()) -> Model:
        """With the middle of its box; of one material unless `parts` says otherwise."""
        place = corners[:, :3].astype(np.float64)
        middle = (place.min(axis=0) + place.max(axis=0)) / 2
        radius = float(np.linalg.norm(place - middle, axis=1).max())
        return cls(corners, middle, radius, tuple(parts) or (len(corners),))


@dataclass(frozen=True, eq=False)
class View:
    """A camera at `place` (3,) that looks at `target` (3,), z up; `half`: tangent of half its upright angle.

    `aspect`: the picture's width over its height.
    """

    place: Floats
    target: Floats
    half: float
    aspect: float = 1.0

    @property
    def matrix(self) -> Floats:
        """From world to clip space, (4, 4) for columns."""
        back = normalised(self.place - self.target)
        right = normalised(np.cross([0.0, 0.0, 1.0], back))
        turn = np.stack([right, np.cross(back, right), back])
        distance = float(np.linalg.norm(self.place - self.target))
        near, far = distance / 10, distance * 10
        look = np.eye(4)
        look[:3, :3], look[:3, 3] = turn, -turn @ self.place
        scale = 1 / self.half
        depth = [0, 0, -(far + near) / (far - near), -2 * far * near / (far - near)]
        projection = np.array([[scale / self.aspect, 0, 0, 0], [0, scale, 0, 0], depth, [0, 0, -1, 0]])
        matrix: Floats = projection @ look
        return matrix


class Painter:
    """One shader's pictures of one model."""

    def __init__(
        self,
        context: moderngl.Context,
        model: Model,
        code: str,
        textures: Mapping[str, AnyTexture],
        values: Mapping[str, Any],
        by_material: Sequence[Mapping[str, Any]] = (),
    ) -> None:
        """Compile; `textures` and `values` are the shader's uniforms, `by_material` those of each material.

        `code` defines `vec4 shade()`, which may use camera, position, normal, tangent and uv.
        """
        head = VERSIONS["GLSL 330"]
        self._context, self._textures = context, textures
        shader = head + _FRAGMENT + code + "\nvoid main() { result = vec4(shade().rgb, 1.0); }\n"
        self._program = context.program(vertex_shader=head + _VERTEX, fragment_shader=shader)
        self._set(values)
        self._parts = (
            [(len(model.corners), {})]
            if not by_material
            else list(zip(model.parts, by_material, strict=True))
        )
        used = [name for name in ("in_position", "in_normal", "in_tangent", "in_uv") if name in self._program]
        widths = {"in_position": 3, "in_normal": 3, "in_tangent": 4, "in_uv": 2}
        layout = " ".join(f"{widths[name]}f" if name in used else f"{4 * widths[name]}x" for name in widths)
        buffer = context.buffer(model.corners.tobytes())
        self._triangles = context.vertex_array(self._program, [(buffer, layout, *used)])

    def bind(self, target: moderngl.Framebuffer, view: View) -> None:
        """Make ready to draw: target, camera, textures."""
        target.use()
        self._context.enable_only(moderngl.DEPTH_TEST)
        self._context.depth_func = "<="
        self._set({"seen": tuple(view.matrix.T.ravel()), "camera": tuple(view.place)})
        for unit, (name, texture) in enumerate(self._textures.items()):
            texture.use(unit)
            self._program[name] = unit

    def render(self) -> None:
        """Draw once what `bind` has made ready."""
        first = 0
        for count, values in self._parts:
            self._set(values)
            self._triangles.render(vertices=count, first=first)
            first += count

    def draw(self, target: moderngl.Framebuffer, view: View) -> None:
        """Clear the target and draw; alpha is 1 where the model is, whatever the shader's."""
        self.bind(target, view)
        target.clear()
        self.render()

    def _set(self, values: Mapping[str, Any]) -> None:
        for name, value in values.items():
            if name in self._program:
                self._program[name] = value


@dataclass(frozen=True, eq=False)
class Canvas:
    """A target with a depth buffer: `drawn` takes the picture, `shown` has it once it is read."""

    context: moderngl.Context
    drawn: moderngl.Framebuffer
    shown: moderngl.Framebuffer

    def read(self) -> Floats:
        """The picture (H, W, 4) float32, row 0 at the bottom; the mean of each pixel's samples."""
        if self.shown is not self.drawn:
            self.context.copy_framebuffer(self.shown, self.drawn)
        values = np.frombuffer(self.shown.read(components=4, dtype="f4"), np.float32)
        return values.reshape(self.shown.height, self.shown.width, 4)


def canvas(context: moderngl.Context, size: tuple[int, int], samples: int = 1, dtype: str = "f4") -> Canvas:
    """A target of floats (or "f1", bytes), with several samples a pixel for edges if wanted."""
    several = samples if samples > 1 else 0
    shown = context.framebuffer([context.texture(size, 4, dtype=dtype)], context.depth_texture(size))
    if not several:
        return Canvas(context, shown, shown)
    colour = context.renderbuffer(size, 4, samples=several, dtype=dtype)
    drawn = context.framebuffer([colour], context.depth_renderbuffer(size, samples=several))
    return Canvas(context, drawn, shown)
