// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
//
// A mesh that shows its radiance texture: the vertex and the pixel shader of a Direct3D program. Of an export (.glb and
// .dds), `position`, `normal`, `tangent` and `uv` are the mesh's POSITION, NORMAL, TANGENT and TEXCOORD_0 as they are,
// and the numbers of the texture are in <name>.export.json. `model` may turn, move, mirror and scale alike all ways.

#include "../radtex.hlsl"

Texture2D atlas : register(t0);

cbuffer Scene : register(b0) {
    float4x4 model;       // from the mesh's space to the world's
    float4x4 projection;  // from the world's space to the screen's
    float3 camera;        // in the world's space
    float exposure;
};

cbuffer Bake : register(b1) {
    int2 texels;          // "texels"
    int n;                // "bucket"
    int levels;           // "levels"
};

struct Vertex {
    float3 position : POSITION;
    float3 normal : NORMAL;
    float4 tangent : TANGENT;
    float2 uv : TEXCOORD0;
};

// Centroid: at the rim of a triangle a pixel's middle may lie beyond it, where the mesh, and its map, has nothing.
struct Fragment {
    float4 place : SV_Position;
    centroid float3 position : POSITION;
    centroid float3 normal : NORMAL;
    centroid float4 tangent : TANGENT;
    centroid float2 uv : TEXCOORD0;
};

Fragment vertex_main(Vertex v) {
    float3x3 turn = (float3x3)model;
    float mirrored = determinant(turn) < 0.0 ? -1.0 : 1.0;
    Fragment f;
    f.position = mul(model, float4(v.position, 1.0)).xyz;
    f.place = mul(projection, float4(f.position, 1.0));
    f.normal = mul(turn, v.normal);
    f.tangent = float4(mul(turn, v.tangent.xyz), v.tangent.w * mirrored);
    f.uv = float2(v.uv.x, 1.0 - v.uv.y);  // glTF's v grows downwards
    return f;
}

float4 pixel_main(Fragment f) : SV_Target {
    float3 I = radtex_incidence(camera - f.position, f.normal, f.tangent.xyz, f.tangent.w);
    float4 light = radtex_sample_level(atlas, texels, n, f.uv, I, radtex_level(f.uv, texels, levels));
    return float4(light.rgb * exposure, light.a);  // linear and premultiplied: blend by ONE, INV_SRC_ALPHA
}
