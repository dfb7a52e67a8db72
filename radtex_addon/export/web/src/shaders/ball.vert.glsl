// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: GPL-3.0-or-later
// The mirror ball's hull.

uniform mat4 modelMatrix, viewMatrix, projectionMatrix;
in vec3 position;
out vec3 v_position;

void main() {
    vec4 place = modelMatrix * vec4(position, 1.0);
    v_position = place.xyz;
    gl_Position = projectionMatrix * viewMatrix * place;
}
