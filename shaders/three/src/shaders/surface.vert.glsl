// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// The baked mesh in a scene of three.js. What the lookups take is in the world of the bake (glTF's axes, y up), wherever
// the mesh, or an instance of it, stands by now.

#include <common>
#include <fog_pars_vertex>
#include <logdepthbuf_pars_vertex>
#include <clipping_planes_pars_vertex>
#include <batching_pars_vertex>
#ifndef USE_TANGENT
in vec4 tangent;
#endif
invariant gl_Position;  // its depth is drawn first where it fades, by another shader
uniform mat4 u_baked;  // from the mesh's own space to the world of the bake
centroid out vec3 v_position, v_normal, v_eye;  // the eye: its place, or where an orthographic camera looks from
centroid out vec4 v_tangent;
centroid out vec2 v_uv;
flat out vec4 v_instance;  // what an instance's light is multiplied by, and its opacity
#ifdef IMAGES
in vec2 uv_images;
centroid out vec2 v_uv_images;  // as glTF has it, for its images
#endif
#ifdef SUNLIT
uniform vec3 u_to_sun;  // in the scene's world
centroid out vec3 v_to_sun;
#endif

void main() {
    mat4 placed = modelMatrix;
#ifdef USE_INSTANCING
    placed = placed * instanceMatrix;
#endif
#ifdef USE_BATCHING
    int instance = int(getIndirectIndex(gl_DrawID));
    placed = placed * getBatchingMatrix(float(instance));
#endif
    v_instance = vec4(1.0);
#ifdef USE_INSTANCING_COLOR
    v_instance.rgb = instanceColor.rgb;
#endif
#ifdef USE_BATCHING_COLOR
    int across = textureSize(batchingColorTexture, 0).x;
    v_instance = texelFetch(batchingColorTexture, ivec2(instance % across, instance / across), 0);
#endif
    mat4 back = u_baked * inverse(placed);  // from the scene's world to that of the bake
    mat3 turn = mat3(u_baked);
    v_position = (u_baked * vec4(position, 1.0)).xyz;
    v_normal = transpose(inverse(turn)) * normal;
    v_tangent = vec4(turn * tangent.xyz, tangent.w * sign(determinant(turn)));
    v_uv = vec2(uv.x, 1.0 - uv.y);  // glTF's v grows downwards
#ifdef IMAGES
    v_uv_images = uv_images;
    v_normal = normalize(v_normal);  // a normal map weighs one by the other, also where the node is scaled
    v_tangent.xyz = normalize(v_tangent.xyz);
#endif
    vec3 towards = vec3(viewMatrix[0][2], viewMatrix[1][2], viewMatrix[2][2]);
    v_eye = isOrthographic ? mat3(back) * towards : (back * vec4(cameraPosition, 1.0)).xyz;
#ifdef SUNLIT
    v_to_sun = normalize(mat3(back) * u_to_sun);
#endif
    vec4 mvPosition = viewMatrix * placed * vec4(position, 1.0);
    gl_Position = projectionMatrix * mvPosition;
    #include <logdepthbuf_vertex>
    #include <clipping_planes_vertex>
    #include <fog_vertex>
}
