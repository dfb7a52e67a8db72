// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
// The mesh as its light shows it, with Babylon.js's image processing.

#include<helperFunctions>
#include<imageProcessingDeclaration>
#define texture2D texture
#include<imageProcessingFunctions>
// Centroid: at the rim of a triangle a pixel's middle may lie beyond it, where the mesh, and its map, has nothing.
centroid in vec3 v_position, v_normal, v_eye;
centroid in vec4 v_tangent;
centroid in vec2 v_uv;
uniform vec4 u_eye;
uniform vec3 u_light;  // what all light is multiplied by
layout(location = 0) out vec4 shown;

void main() {
#ifdef LAYERED
    surface_place = v_position;
#endif
    vec3 V = normalize(v_eye - u_eye.w * v_position);
    shown = vec4(light(v_uv, v_normal, v_tangent, V).rgb * u_light, 1.0);
#ifdef IMAGEPROCESSINGPOSTPROCESS
    shown.rgb = max(shown.rgb, 0.0);
#else
    shown = applyImageProcessing(shown);
#endif
}
