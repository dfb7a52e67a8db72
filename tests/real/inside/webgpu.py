# SPDX-FileCopyrightText: 2026 RadTex authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Run fragment shaders once for every pixel of a picture, by wgpu: reads lines, JOB.npz ANSWERS.npy each.

It answers each by what wgpu says of a bad shader, then a line ANSWERED. Runs where only numpy and wgpu are;
tests/real/webgpu.py writes jobs and says what they hold.
"""

from __future__ import annotations

import json
import sys
import traceback
from typing import Any

import numpy as np
import wgpu  # type: ignore[import-not-found]  # only there

VERTEX = """
// one triangle that covers the picture
@vertex fn main(@builtin(vertex_index) k: u32) -> @builtin(position) vec4f {
    return vec4f(select(-1.0, 3.0, k == 1), select(-1.0, 3.0, k == 2), 0.0, 1.0);
}
"""
ANSWERS = "rgba32float"
WANTED_FEATURES = {"float32-filterable", "texture-compression-bc"}
WANTED_LIMITS = {
    "max-sampled-textures-per-shader-stage": 32,
    "max-texture-array-layers": 2048,
    "max-texture-dimension-2d": 16384,
}


def open_device() -> Any:
    """The first adapter's device, with the features and limits of WANTED_* as far as it has them."""
    adapter = wgpu.gpu.request_adapter_sync(power_preference="high-performance")
    print(f"{adapter.info['vendor']}, {adapter.info['device']}, {adapter.info['adapter_type']}")
    limits = {name: min(value, adapter.limits[name]) for name, value in WANTED_LIMITS.items()}
    return adapter.request_device_sync(
        required_features=sorted(WANTED_FEATURES & adapter.features), required_limits=limits
    )


def uploaded(device: Any, facts: dict[str, Any], levels: list[Any]) -> Any:
    """A view of a texture of mip levels (layers, rows, bytes of a row) uint8, of pixels or blocks."""
    width, height = facts["size"]
    texture = device.create_texture(
        size=(width, height, len(levels[0])),
        format=facts["format"],
        mip_level_count=len(levels),
        usage=wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST,
    )
    side = 4 if facts["format"].startswith("bc") else 1
    for level, data in enumerate(levels):
        columns, rows = (-(-max(length >> level, 1) // side) * side for length in (width, height))
        device.queue.write_texture(
            {"texture": texture, "mip_level": level},
            np.ascontiguousarray(data),
            {"bytes_per_row": data.shape[2], "rows_per_image": data.shape[1]},
            (columns, rows, len(data)),
        )
    return texture.create_view(dimension=facts["dimension"])


def attributes(sizes: list[int]) -> dict[str, Any]:
    """A vertex buffer's layout: attributes of 2 to 4 float32 each, one behind another."""
    offsets = np.cumsum([0, *sizes]).tolist()
    places = [
        {"format": f"float32x{size}", "offset": 4 * offset, "shader_location": k}
        for k, (size, offset) in enumerate(zip(sizes, offsets, strict=False))
    ]
    return {"array_stride": 4 * offsets[-1], "step_mode": "vertex", "attributes": places}


def bound(device: Any, job: Any, binding: str, facts: dict[str, Any]) -> Any:
    """What stands at a binding: a texture, a sampler, or a uniform buffer."""
    if facts["kind"] == "texture":
        return uploaded(device, facts, [job[f"{binding}.{level}"] for level in range(facts["levels"])])
    if facts["kind"] == "sampler":
        return device.create_sampler(**facts["settings"])
    data = job[binding]
    buffer = device.create_buffer_with_data(data=data, usage=wgpu.BufferUsage.UNIFORM)
    return {"buffer": buffer, "offset": 0, "size": data.nbytes}


def drawn(device: Any, job: Any) -> Any:
    """The fragment shader's answers, (height, width, 4) float32, row 0 where the fragment's y is 0."""
    facts = json.loads(str(job["facts"]))
    code = job["shader"].tobytes()  # SPIR-V begins with its number; anything else is WGSL
    spirv = code[:4] == b"\x03\x02\x23\x07"
    fragment = device.create_shader_module(code=code if spirv else code.decode())
    vertex = {"module": device.create_shader_module(code=VERTEX), "entry_point": "main"}
    if facts["attributes"]:
        vertex = {"module": fragment, "entry_point": "vertex", "buffers": [attributes(facts["attributes"])]}
    pipeline = device.create_render_pipeline(
        layout="auto",
        vertex=vertex,
        primitive={"topology": "triangle-list"},
        fragment={
            "module": fragment,
            "entry_point": facts["entry"],
            "constants": facts["constants"],
            "targets": [{"format": ANSWERS}],
        },
    )
    entries = [
        {"binding": int(binding), "resource": bound(device, job, binding, about)}
        for binding, about in facts["bindings"].items()
    ]
    width, height = facts["size"]
    target = device.create_texture(
        size=(width, height, 1),
        format=ANSWERS,
        usage=wgpu.TextureUsage.RENDER_ATTACHMENT | wgpu.TextureUsage.COPY_SRC,
    )
    encoder = device.create_command_encoder()
    attachment = {"view": target.create_view(), "load_op": "clear", "store_op": "store"}
    work = encoder.begin_render_pass(color_attachments=[attachment])
    work.set_pipeline(pipeline)
    work.set_bind_group(
        0, device.create_bind_group(layout=pipeline.get_bind_group_layout(0), entries=entries)
    )
    vertices = job["vertices"]
    if len(vertices):
        buffer = device.create_buffer_with_data(data=vertices, usage=wgpu.BufferUsage.VERTEX)
        work.set_vertex_buffer(0, buffer)
    work.draw(len(vertices) or 3)
    work.end()
    device.queue.submit([encoder.finish()])
    layout = {"bytes_per_row": 16 * width, "rows_per_image": height}
    answers = device.queue.read_texture({"texture": target}, layout, (width, height, 1))
    return np.frombuffer(answers, np.float32).reshape(height, width, 4)


def main() -> None:
    """Run jobs until the input ends."""
    device = open_device()
    for line in sys.stdin:
        job, answers = line.split()
        try:
            with np.load(job) as fields:
                np.save(answers, drawn(device, fields))
        except Exception:  # noqa: BLE001  # whatever wgpu raises of a shader
            traceback.print_exc(file=sys.stdout)
        print("ANSWERED", flush=True)


if __name__ == "__main__":
    main()
