// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
//
// What the passes of all three render pipelines share. A pass includes its pipeline's own files, defines
//
//     RADTEX_TO_WORLD(position)   from the object's space to the world's, which in HDRP begins at the camera
//     RADTEX_TO_CLIP(world, v)    from there to the screen, of the vertex v
//     RADTEX_TO_VIEWER(world)     from there to the viewer, of any length
//     RADTEX_TO_OBJECT(direction) from the world's space to the object's
//     RADTEX_TO_WORLD_NORMAL(normal), and RADTEX_PIPELINE_EXPOSURE, by which light is multiplied
//
// then includes NAME.hlsl, which has the bake's numbers and radtex_light, and then this.
//
// The mesh carries the frame of the bake in four uv sets behind that of the bake, in the world of the bake: the tangent
// and the bitangent's sign, then the normal. Where materials are shown by their own images, their set is the first, and
// the bake's the second. Importers turn normals and tangents each in their own way; uv they leave alone, but
// that Unity's v grows upwards, so that every importer of glTF makes it 1 - v.

#ifndef RADTEX_UNITY_HLSL
#define RADTEX_UNITY_HLSL

CBUFFER_START(UnityPerMaterial)
float _RadtexExposure;
float _RadtexFollowExposure;  // 1: HDRP's exposure darkens and brightens it as all else
#ifdef RADTEX_RELIT
float4 _RadtexSunDirection;  // towards the sun, in Unity's world
float4 _RadtexSunIrradiance;
#endif
CBUFFER_END

struct RadtexVertex {
    float4 position : POSITION;
    float3 normal : NORMAL;
#ifdef RADTEX_IMAGE_UVS
    float2 image_uv : TEXCOORD0;
    float2 uv : TEXCOORD1;
    float2 tangent_xy : TEXCOORD2;
    float2 tangent_z_side : TEXCOORD3;
    float2 normal_xy : TEXCOORD4;
    float2 normal_z : TEXCOORD5;
#else
    float2 uv : TEXCOORD0;
    float2 tangent_xy : TEXCOORD1;
    float2 tangent_z_side : TEXCOORD2;
    float2 normal_xy : TEXCOORD3;
    float2 normal_z : TEXCOORD4;
#endif
    UNITY_VERTEX_INPUT_INSTANCE_ID
};

// Centroid: at the rim of a triangle a pixel's middle may lie beyond it, where the mesh, and its map, has nothing.
struct RadtexFragment {
    float4 place : SV_POSITION;
    centroid float4 uv : TEXCOORD0;  // of the bake; zw: of the material's own images
    centroid float3 position : TEXCOORD1;  // this and what follows: in the world of the bake
    centroid float3 normal : TEXCOORD2;
    centroid float4 tangent : TEXCOORD3;
    centroid float3 viewer : TEXCOORD4;
    float3 sun : TEXCOORD5;
    float3 world_normal : TEXCOORD6;  // but this: in Unity's
    UNITY_VERTEX_INPUT_INSTANCE_ID
    UNITY_VERTEX_OUTPUT_STEREO
};

// A direction of Unity's world in that of the bake: what turns or moves the object takes its surroundings along.
float3 radtex_in_bake(float3 direction) {
    return mul((float3x3)RADTEX_BAKED, RADTEX_TO_OBJECT(direction));
}

RadtexFragment radtex_vertex(RadtexVertex v) {
    RadtexFragment f = (RadtexFragment)0;
    UNITY_SETUP_INSTANCE_ID(v);
    UNITY_TRANSFER_INSTANCE_ID(v, f);
    UNITY_INITIALIZE_VERTEX_OUTPUT_STEREO(f);
    float3 world = RADTEX_TO_WORLD(v.position.xyz);
    f.place = RADTEX_TO_CLIP(world, v);
#ifdef RADTEX_IMAGE_UVS
    f.uv = float4(v.uv, v.image_uv);
#else
    f.uv = float4(v.uv, v.uv);
#endif
    f.position = mul(RADTEX_BAKED, float4(v.position.xyz, 1.0));
    f.normal = float3(v.normal_xy.x, 1.0 - v.normal_xy.y, v.normal_z.x);
    f.tangent = float4(v.tangent_xy.x, 1.0 - v.tangent_xy.y, v.tangent_z_side.x, 1.0 - v.tangent_z_side.y);
    f.viewer = radtex_in_bake(RADTEX_TO_VIEWER(world));
#ifdef RADTEX_RELIT
    f.sun = radtex_in_bake(_RadtexSunDirection.xyz);
#endif
    f.world_normal = RADTEX_TO_WORLD_NORMAL(v.normal);
    return f;
}

// Light and alpha, premultiplied.
float4 radtex_seen(RadtexFragment f) {
    float3 irradiance = float3(0.0, 0.0, 0.0);
#ifdef RADTEX_RELIT
    irradiance = _RadtexSunIrradiance.rgb;
#endif
    return radtex_light(
        f.uv.xy, f.uv.zw, f.position, f.normal, f.tangent.xyz, f.tangent.w, f.viewer, f.sun, irradiance);
}

#ifdef RADTEX_CLEAR
// What is clear casts no shadow, and hides nothing.
void radtex_cut(RadtexFragment f) {
    clip(radtex_seen(f).a - 0.5);
}
#else
void radtex_cut(RadtexFragment f) {}
#endif

float4 radtex_pixel(RadtexFragment f) : SV_Target {
    UNITY_SETUP_STEREO_EYE_INDEX_POST_VERTEX(f);
    float4 light = radtex_seen(f);
#ifdef RADTEX_CLEAR
    clip(max(light.a, max(light.r, max(light.g, light.b))) - 0.002);
#else
    light.a = 1.0;
#endif
    return float4(light.rgb * (_RadtexExposure * RADTEX_PIPELINE_EXPOSURE), light.a);
}

// Passes that write depth alone.
float4 radtex_depth(RadtexFragment f) : SV_Target {
    radtex_cut(f);
    return 0.0;
}

// URP's pass of depth and normals.
float4 radtex_normals(RadtexFragment f) : SV_Target {
    radtex_cut(f);
    return float4(normalize(f.world_normal), 0.0);
}

#endif
