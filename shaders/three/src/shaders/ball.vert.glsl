// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// The mirror ball's hull, in the world of the bake.

#include <common>
#include <fog_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
uniform mat4 u_baked;  // from the ball's own space to the world of the bake
out vec3 v_position, v_eye;  // the eye: its place, or where an orthographic camera looks from

void main() {
    mat4 back = u_baked * inverse(modelMatrix);
    vec3 towards = vec3(viewMatrix[0][2], viewMatrix[1][2], viewMatrix[2][2]);
    v_position = (u_baked * vec4(position, 1.0)).xyz;
    v_eye = isOrthographic ? normalize(mat3(back) * towards) : (back * vec4(cameraPosition, 1.0)).xyz;
    vec4 mvPosition = viewMatrix * modelMatrix * vec4(position, 1.0);
    gl_Position = projectionMatrix * mvPosition;
    #include <logdepthbuf_vertex>
    #include <clipping_planes_vertex>
    #include <fog_vertex>
}
