// SPDX-FileCopyrightText: 2026 RadTex authors
// SPDX-License-Identifier: MIT
//
// The code of a material's Custom node that shows @NAME@.
// @SCRIPT@ makes the node. It gives light, premultiplied, and alpha: CMOT Float 4. Its inputs are UV0 to UV4
// (Texture Coordinates), Viewer (CameraVectorWS, transformed from world to local space)@MORE@.
//
// The mesh carries the frame of the bake in its uv sets 1 to 4, in the world of the bake: the tangent and the
// bitangent's sign, then the normal.
#if PIXELSHADER
#define RADTEX_LEVEL(uv, texels, levels) radtex_level(uv, texels, levels)
#else  // hit shaders have no derivatives
#define RADTEX_LEVEL(uv, texels, levels) 0.0
#define RADTEX_NO_DERIVATIVES
#endif
@DEFINES@
@STRUCTS@
struct RadtexLookup {
@MEMBERS@
@FUNCTIONS@
float4 radtex_light(@ARGUMENTS@) {
@LOOKUP@
}
};
RadtexLookup radtex;
@VALUES@
// From the mesh as Unreal imports glTF to the world of the bake, z up.
float3x4 radtex_baked = float3x4(@BAKED@);
float4 radtex_found = radtex.radtex_light(
    float2(UV0.x, 1.0 - UV0.y),  // Unreal's v grows downwards
    mul(radtex_baked, float4(@PLACE@, 1.0)),
    float3(UV3.xy, UV4.x), float3(UV1.xy, UV2.x), UV2.y,
    mul((float3x3)radtex_baked, Viewer), @SUN@);
@UNDEFINES@
return radtex_found;
