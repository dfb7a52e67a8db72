# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished bake drawn by OpenGL with our own shaders, as a game would: mesh, camera, textures."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import bpy
import moderngl
import numpy as np
import numpy.typing as npt

from radtex_addon.core.arrays import Floats
from radtex_addon.core.frame import normalised
from radtex_addon.report.finished_bake import Finished
from radtex_addon.scene.mesh.copy import NORMAL, SIGN, TANGENT
from radtex_addon.scene.scratch import new_data_removed
from tests.real.opengl import VERSIONS, Texture

SHADERS = Path(__file__).parents[2] / "shaders"
_VERTEX = """
uniform mat4 seen;
in vec3 in_position, in_normal;
in vec4 in_tangent;
in vec2 in_uv;
out vec3 position, normal;
out vec4 tangent;
out vec2 uv;
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
in vec3 position, normal;
in vec4 tangent;
in vec2 uv;
out vec4 result;
"""


@dataclass(frozen=True, eq=False)
class Model:
    """A baked copy in world space: `corners` (3 F, 12) float32, position, normal, tangent, sign and uv."""

    corners: Floats
    middle: Floats
    radius: float


def read_model(bake: Finished) -> Model:
    """The copy in the bake's preview, which must stand alone: without a parent."""
    libraries: Any = bpy.data.libraries
    with new_data_removed():
        with libraries.load(str(bake.preview)) as (_, wanted):
            wanted.objects = [bake.sidecar.object_name]
        (copy,) = wanted.objects
        mesh = cast(bpy.types.Mesh, copy.data)
        matrix = np.array(copy.matrix_basis, dtype=np.float64)
        index = _values(mesh.loops, "vertex_index", 1)[:, 0].astype(int)
        place = _values(mesh.vertices, "co", 3)[index] @ matrix[:3, :3].T + matrix[:3, 3]
        attributes = cast(Any, mesh).attributes
        normal, tangent = (_values(attributes[name].data, "vector", 3) for name in (NORMAL, TANGENT))
        sign = _values(attributes[SIGN].data, "value", 1) * np.sign(np.linalg.det(matrix))
        uv = _values(attributes[bake.sidecar.uv_map].data, "vector", 2)
    normal, tangent = normal @ np.linalg.inv(matrix[:3, :3]), tangent @ matrix[:3, :3].T
    corners = np.concatenate([place, normal, tangent, sign, uv], axis=1).astype(np.float32)
    middle = (place.min(axis=0) + place.max(axis=0)) / 2
    return Model(corners, middle, float(np.linalg.norm(place - middle, axis=1).max()))


@dataclass(frozen=True, eq=False)
class View:
    """A camera at `place` (3,) that looks at `target` (3,), z up; `half`: tangent of half its angle."""

    place: Floats
    target: Floats
    half: float

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
        projection = np.array([[scale, 0, 0, 0], [0, scale, 0, 0], depth, [0, 0, -1, 0]])
        matrix: Floats = projection @ look
        return matrix


class Painter:
    """One shader's pictures of one model."""

    def __init__(
        self,
        context: moderngl.Context,
        model: Model,
        code: str,
        textures: Mapping[str, Texture],
        values: Mapping[str, Any],
    ) -> None:
        """Compile; `textures` and `values` are the shader's uniforms.

        `code` defines `vec4 shade()`, which may use camera, position, normal, tangent and uv.
        """
        head = VERSIONS["GLSL 330"]
        self._context, self._textures = context, textures
        shader = head + _FRAGMENT + code + "\nvoid main() { result = vec4(shade().rgb, 1.0); }\n"
        self._program = context.program(vertex_shader=head + _VERTEX, fragment_shader=shader)
        for name, value in values.items():
            self._program[name] = value
        used = [name for name in ("in_position", "in_normal", "in_tangent", "in_uv") if name in self._program]
        widths = {"in_position": 3, "in_normal": 3, "in_tangent": 4, "in_uv": 2}
        layout = " ".join(f"{widths[name]}f" if name in used else f"{4 * widths[name]}x" for name in widths)
        buffer = context.buffer(model.corners.tobytes())
        self._triangles = context.vertex_array(self._program, [(buffer, layout, *used)])

    def draw(self, target: moderngl.Framebuffer, view: View) -> None:
        """Clear the target and draw; alpha is 1 where the model is, whatever the shader's."""
        target.use()
        target.clear()
        self._context.enable_only(moderngl.DEPTH_TEST)
        self._program["seen"] = tuple(view.matrix.T.ravel())
        if "camera" in self._program:
            self._program["camera"] = tuple(view.place)
        for unit, (name, texture) in enumerate(self._textures.items()):
            texture.use(unit)
            self._program[name] = unit
        self._triangles.render()


@dataclass(frozen=True, eq=False)
class Canvas:
    """A square target with a depth buffer: `drawn` takes the picture, `shown` has it once it is read."""

    context: moderngl.Context
    drawn: moderngl.Framebuffer
    shown: moderngl.Framebuffer

    def read(self) -> Floats:
        """The picture (H, W, 4) float32, row 0 at the bottom; the mean of each pixel's samples."""
        if self.shown is not self.drawn:
            self.context.copy_framebuffer(self.shown, self.drawn)
        values = np.frombuffer(self.shown.read(components=4, dtype="f4"), np.float32)
        return values.reshape(self.shown.height, self.shown.width, 4)


def canvas(context: moderngl.Context, pixels: int, samples: int = 1, dtype: str = "f4") -> Canvas:
    """A target of floats (or "f1", bytes), with several samples a pixel for edges if wanted."""
    size, several = (pixels, pixels), samples if samples > 1 else 0
    shown = context.framebuffer([context.texture(size, 4, dtype=dtype)], context.depth_texture(size))
    if not several:
        return Canvas(context, shown, shown)
    colour = context.renderbuffer(size, 4, samples=several, dtype=dtype)
    drawn = context.framebuffer([colour], context.depth_renderbuffer(size, samples=several))
    return Canvas(context, drawn, shown)


def _values(items: Any, field: str, width: int) -> npt.NDArray[np.float64]:
    values = np.empty(len(items) * width, dtype=np.int32 if field == "vertex_index" else np.float32)
    items.foreach_get(field, values)
    return values.reshape(-1, width).astype(np.float64)
