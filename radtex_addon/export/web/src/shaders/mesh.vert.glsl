// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// The baked copy: what every lookup wants of it, in the world of the page (glTF's, y up).

uniform mat4 modelMatrix, viewMatrix, projectionMatrix;
in vec3 position, normal;
in vec4 tangent;
in vec2 uv;
out vec3 v_position, v_normal;
out vec4 v_tangent;
out vec2 v_uv;

void main() {
    mat3 turn = mat3(modelMatrix);
    vec4 place = modelMatrix * vec4(position, 1.0);
    v_position = place.xyz;
    v_normal = transpose(inverse(turn)) * normal;
    v_tangent = vec4(turn * tangent.xyz, tangent.w * sign(determinant(turn)));
    v_uv = vec2(uv.x, 1.0 - uv.y);  // glTF's v grows downwards
    gl_Position = projectionMatrix * viewMatrix * place;
}
