// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// The baked mesh in a scene of Babylon.js. What the lookups take is in the world of the bake (glTF's axes, y up), wherever
// the mesh, or an instance of it, stands by now, and whichever handedness the scene has: its world matrices flip it.

precision highp float;
in vec3 position, normal;
in vec4 tangent;
in vec2 uv;
#ifdef INSTANCES
in vec4 world0, world1, world2, world3;
#endif
uniform mat4 world, viewProjection;
uniform mat4 u_baked;  // from the mesh's own space to the world of the bake
uniform vec4 u_eye;  // the camera's place, and 1; or the direction towards an orthographic one, and 0
centroid out vec3 v_position, v_normal, v_eye;
centroid out vec4 v_tangent;
centroid out vec2 v_uv;

void main() {
    mat4 placed = world;
#ifdef INSTANCES
    placed = mat4(world0, world1, world2, world3);
#ifdef THIN_INSTANCES
    placed = world * placed;
#endif
#endif
    mat4 back = u_baked * inverse(placed);  // from the scene's world to that of the bake
    mat3 turn = mat3(u_baked);
    v_position = (u_baked * vec4(position, 1.0)).xyz;
    v_normal = transpose(inverse(turn)) * normal;
    v_tangent = vec4(turn * tangent.xyz, tangent.w * sign(determinant(turn)));
    v_uv = vec2(uv.x, 1.0 - uv.y);  // glTF's v grows downwards
    v_eye = (back * u_eye).xyz;
    gl_Position = viewProjection * placed * vec4(position, 1.0);
}
